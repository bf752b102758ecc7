"""RAP016 and RAP017: facts with the wrong number of arguments, or one left out.

Semantics 2: a property pattern one argument short means the value `true`, in queries,
assertions and notations; erasing takes a prefix.
"""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.arity import written, wrong_arity
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.analysis.passes.predicates import PREDICATES
from rapc.analysis.vocabulary import Predicate, facts
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.ir import nodes

ARITY = Rule(
    code="RAP016",
    name="wrong-fact-arity",
    severity=Severity.ERROR,
    summary="a fact or test has another number of arguments than was declared",
    why="""A fact with too many or too few arguments matches nothing in memory; a
function called so fails. Erasing takes a prefix, which may be shorter but not longer
than the facts it is to erase.""",
    example="""\
(declare-memory-proposition road (?from ?to))
(define-rap (drive ?from ?to)
  (preconditions (road ?from ?to paved)))
""",
    better="""\
(declare-memory-proposition road (?from ?to))
(define-rap (drive ?from ?to)
  (preconditions (road ?from ?to)))
""",
)

IMPLIED = Rule(
    code="RAP017",
    name="implied-true",
    severity=Severity.INFO,
    summary="a property is used without its value, which then means `true`",
    why="""`(class ?x box)` for `(class ?x box true)` is read as it was meant, but a
reader cannot see whether the value was left out on purpose, and a property whose value
is not true or false never holds so.""",
    example="""\
(declare-memory-property open (?door ?is) unknown)
(define-rap (pass ?door)
  (preconditions (open ?door)))
""",
    better="""\
(declare-memory-property open (?door ?is) unknown)
(define-rap (pass ?door)
  (preconditions (open ?door true)))
""",
)


def _run(run: Pass) -> None:
    known = run.result(PREDICATES)
    for pattern, role in facts(run.result(OCCURRENCES)):
        declared = known.get(pattern.name)
        if declared is None or declared.args is None:
            continue
        given, wanted = len(pattern.args), len(declared.args)
        if given == wanted or (role == "erase" and given < wanted):
            continue
        if declared.kind == "property" and 0 < given == wanted - 1:
            run.report(
                _implied(pattern, declared, written(pattern.name, declared.args))
            )
        else:
            said = (declared.name, declared.args, declared.span)
            most = "at most " if role == "erase" else ""
            run.report(wrong_arity(ARITY, pattern, said, most=most))


ANALYZER = Analyzer(
    name="wrong-fact-arity",
    doc="Finds facts and tests with too many or too few arguments.",
    run=_run,
    needs=(OCCURRENCES, PREDICATES),
    rules=(ARITY, IMPLIED),
)


def _implied(pattern: nodes.Proposition, declared: Predicate, form: str) -> Diagnostic:
    end = pattern.args[-1].span.end
    edit = Edit(Span(pattern.span.file, end, end), " true")
    return Diagnostic(
        rule=IMPLIED.name,
        message=f"the value of `{pattern.name}` is left out and means `true`",
        span=pattern.span,
        labels=(Label(declared.span, f"declared here as `{form}`"),),
        fix=Fix(Applicability.SAFE, "write the value", (edit,)),
    )
