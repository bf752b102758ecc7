"""RAP015 and RAP073: facts that no declaration knows, and what is taken for facts.

T A.1: what stands in memory must be declared. Numbers of arguments are the business
of `wrong-fact-arity`.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Form, Index
from rapc.analysis.facts.names import UnknownNames, misuses, wrong_kind
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.signatures import Use

UNDECLARED = Rule(
    code="RAP015",
    name="undeclared-predicate",
    severity=Severity.ERROR,
    summary="a fact, property or test is not declared",
    why="""Every proposition, property and function is declared, so that a slip of the
pen is not taken for a fact that just never holds. Rows of comparators, `:reads` and
`:excludes` name declared predicates too.""",
    fix="unsafe: writes the name that is spelled almost so, where there is one",
    source="T A.1",
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
    summary="a function or a query is asserted, noted or believed as if it were a fact",
    why="""A declared function is computed when it is asked, and a named query is a
formula. Neither is in memory, so nothing can put it there or take it away, be it an
effect or an `:on`, and it has no age.""",
    source="T A.1",
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

_FACTS: tuple[Use, ...] = ("test", "believed", "asserted", "erased")


@check(UNDECLARED, NOT_A_FACT)
def undeclared_predicate(run: Pass) -> Iterator[Diagnostic]:
    """Find facts and tests that are not declared, and what is taken for facts."""
    unknown = UnknownNames(UNDECLARED)
    for one in misuses(run, _FACTS, "unknown"):
        unknown.add(one.fault, one.used.place(run.library.files), one.used.owner)
    for name, place, owner in _further(run.result(INDEX)):
        if name not in run.signatures.predicates:
            unknown.add(run.signatures.unknown("test", name), place, owner)
    yield from unknown.findings(run)
    yield from wrong_kind(run, NOT_A_FACT, _FACTS)


def _further(index: Index) -> Iterator[tuple[str, Span, Form]]:
    """Predicates named outside of propositions."""
    for row in index.of(nodes.ComparatorRow):
        yield row.node.property, row.node.span, row.owner
    for function in index.of(nodes.DeclareFunction):
        for name in function.node.reads or ():
            yield name, function.node.span, function.owner
