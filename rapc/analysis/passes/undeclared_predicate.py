"""RAP015 and RAP073: facts that no declaration knows, and functions taken for facts.

T A.1: what stands in memory must be declared. Numbers of arguments are the business
of `wrong-fact-arity`.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.names import Names
from rapc.analysis.occurrences import Occurrences
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.analysis.passes.predicates import PREDICATES
from rapc.analysis.unknown import Unknown
from rapc.analysis.vocabulary import Predicate, Role, facts
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.library import word_span
from rapc.parser.names import QUERIES

UNDECLARED = Rule(
    code="RAP015",
    name="undeclared-predicate",
    severity=Severity.ERROR,
    summary="a fact, property or test is not declared",
    why="""Every proposition, property and function is declared, so that a slip of the
pen is not taken for a fact that just never holds. Rows of comparators, `:reads` and
`:excludes` name declared predicates too.""",
    example="""\
(declare-memory-property location (?thing ?place) unknown)
(define-rap (fetch ?thing)
  (succeed (loction ?thing arm)))
""",
    better="""\
(declare-memory-property location (?thing ?place) unknown)
(define-rap (fetch ?thing)
  (succeed (location ?thing arm)))
""",
)

NOT_A_FACT = Rule(
    code="RAP073",
    name="not-a-fact",
    severity=Severity.ERROR,
    summary="a function is asserted, erased, noted or believed as if it were a fact",
    why="""A declared function is computed when it is asked. It is not in memory, so
nothing can put it there or take it away, and it has no age.""",
    example="""\
(declare-memory-function near (?this ?that) "Whether two things are near.")
(define-rap (stay ?thing)
  (succeed (believe (near ?thing truck) 10)))
""",
    better="""\
(declare-memory-function near (?this ?that) "Whether two things are near.")
(define-rap (stay ?thing)
  (succeed (near ?thing truck)))
""",
)

_DONE: dict[Role, str] = {
    "believe": "has no age",
    "assert": "cannot be asserted",
    "erase": "cannot be erased",
}


def _run(run: Pass) -> None:
    known = run.result(PREDICATES)
    names = Names([*known, *QUERIES])
    unknown = Unknown(
        UNDECLARED,
        "`{}` is not declared",
        names,
        "declare it, or `require` the file that does",
    )
    occurrences = run.result(OCCURRENCES)
    for pattern, role in facts(occurrences):
        declared = known.get(pattern.name)
        if declared is None:
            unknown.add(pattern.name, word_span(run.library.files, pattern.span, 0))
        elif declared.kind == "function" and role != "query":
            place = word_span(run.library.files, pattern.span, 0)
            run.report(_not_a_fact(declared, role, place))
    for name, place in _further(occurrences):
        if name not in known:
            unknown.add(name, place)
    unknown.report(run)


ANALYZER = Analyzer(
    name="undeclared-predicate",
    doc="Finds facts and tests that are not declared, and functions taken for facts.",
    run=_run,
    needs=(OCCURRENCES, PREDICATES),
    rules=(UNDECLARED, NOT_A_FACT),
)


def _further(occurrences: Occurrences) -> Iterator[tuple[str, Span]]:
    """Predicates named outside of patterns."""
    for row in occurrences.of(nodes.ComparatorRow):
        yield row.node.property, row.node.span
    for function in occurrences.of(nodes.DeclareFunction):
        for name in function.node.reads or ():
            yield name, function.node.span


def _not_a_fact(declared: Predicate, role: Role, place: Span) -> Diagnostic:
    return Diagnostic(
        rule=NOT_A_FACT.name,
        message=f"`{declared.name}` is a function and {_DONE[role]}",
        span=place,
        labels=(Label(declared.span, "declared here"),),
    )
