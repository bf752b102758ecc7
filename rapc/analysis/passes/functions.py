"""RAP018 and RAP019: computed terms whose function is not declared, or not met.

The built-in functions are checked by the parser, which knows how many arguments they
take. Functions used as tests are facts to `fact_arity` and `undeclared_predicate`.
"""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.arity import written, wrong_arity
from rapc.analysis.names import Names
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.analysis.passes.predicates import PREDICATES
from rapc.analysis.unknown import Unknown
from rapc.analysis.vocabulary import Predicate
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.library.library import word_span
from rapc.parser.names import CALLS

UNDECLARED = Rule(
    code="RAP018",
    name="undeclared-function",
    severity=Severity.ERROR,
    summary="a term is computed by a function that is not declared",
    why="""A list that stands as an argument is computed. Besides arithmetic, `size-of`
and `value` only declared functions can do that; a proposition or property has no value
there.""",
    example="""\
(declare-memory-property size (?thing ?size) unknown)
(declare-memory-property room (?box ?size) unknown)
(define-rap (pack ?thing ?box)
  (preconditions (room ?box (size ?thing))))
""",
    better="""\
(declare-memory-property size (?thing ?size) unknown)
(declare-memory-property room (?box ?size) unknown)
(define-rap (pack ?thing ?box)
  (preconditions (and (size ?thing ?size) (room ?box ?size))))
""",
)

ARITY = Rule(
    code="RAP019",
    name="wrong-function-arity",
    severity=Severity.ERROR,
    summary="a declared function gets another number of arguments than was declared",
    why="""The function that the world or the host registers is called with what the
term gives it; with too much or too little the query fails.""",
    example="""\
(declare-memory-function distance (?from ?to))
(define-rap (go ?from ?to)
  (duration (distance ?to)))
""",
    better="""\
(declare-memory-function distance (?from ?to))
(define-rap (go ?from ?to)
  (duration (distance ?from ?to)))
""",
)


def _run(run: Pass) -> None:
    known = run.result(PREDICATES)
    advice = "declare it with `declare-memory-function`"
    names = Names([*run.library.functions, *CALLS])
    unknown = Unknown(UNDECLARED, "no function is called `{}`", names, advice)
    for use in run.result(OCCURRENCES).of(nodes.Call):
        call = use.node
        declared = known.get(call.function)
        if call.function in CALLS:
            continue
        if declared is None:
            place = word_span(run.library.files, call.span, 0)
            unknown.add(call.function, place)
        elif declared.kind != "function":
            run.report(_no_function(call, declared))
        elif declared.args is not None and len(declared.args) != len(call.args):
            said = (declared.name, declared.args, declared.span)
            run.report(wrong_arity(ARITY, call, said))
    unknown.report(run)


ANALYZER = Analyzer(
    name="functions",
    doc="Finds computed terms whose function is not declared, or not met.",
    run=_run,
    needs=(OCCURRENCES, PREDICATES),
    rules=(UNDECLARED, ARITY),
)


def _no_function(call: nodes.Call, declared: Predicate) -> Diagnostic:
    form = written(declared.name, declared.args or ())
    return Diagnostic(
        rule=UNDECLARED.name,
        message=f"`{call.function}` is a {declared.kind} and computes nothing",
        span=call.span,
        labels=(Label(declared.span, "declared here"),),
        help=f"ask `{form}` in a formula first and use the variable it binds",
    )
