"""RAP108: comparisons whose answer stands in the text [L 2]."""

from __future__ import annotations

from collections.abc import Container, Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Index
from rapc.analysis.facts.logic import holds_between, literals, number_of
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.values import Number
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import subformulas

SETTLED_COMPARISON = Rule(
    code="RAP108",
    name="settled-comparison",
    severity=Severity.WARNING,
    summary="a comparison holds always, or never, as it is written",
    why="""Two constants, or a variable and the same one with a number added, compare in
one way whatever happens; so do the age of a belief, a number, and a word. Mostly one of
the two was to be another variable: a test is missing, or stands in the way of all that
depends on it.""",
    ignore="never: write `true` or `nil` if that is meant",
    source="T 4.1",
    example="""\
(declare-memory-property tank (?level) unknown)
(declare-memory-property room-for (?litres) unknown)
(define-query (tank-full)
  (and (tank ?level) (room-for ?litres) (> (+ ?level 5) ?level)))
""",
    better="""\
(declare-memory-property tank (?level) unknown)
(declare-memory-property room-for (?litres) unknown)
(define-query (tank-full)
  (and (tank ?level) (room-for ?litres) (> (+ ?level 5) ?litres)))
""",
)


@check(SETTLED_COMPARISON)
def settled_comparison(run: Pass) -> Iterator[Diagnostic]:
    """Find comparisons whose answer stands in the text."""
    index = run.result(INDEX)
    of_ages = {id(test): holds for test, holds in _tests_of_ages(index)}
    for use in index.of(nodes.Compare):
        holds = _answer(use.node)
        if holds is None:
            holds = of_ages.get(id(use.node))
        if holds is not None:
            yield SETTLED_COMPARISON.at(
                use.node.span,
                f"`{format_formula(use.node)}` {'always' if holds else 'never'} holds",
                help="compare with something else, or leave it out",
            )


def _answer(test: nodes.Compare) -> bool | None:
    """Return what a comparison comes to whatever happens; None if that depends."""
    one, first = _apart(test.left)
    other, second = _apart(test.right)
    if isinstance(one, nodes.Const) and isinstance(other, nodes.Const):
        equal = one.value == other.value
        return {"=": equal, "n=": not equal}.get(test.op)
    if type(one) is not type(other) or one != other:
        return None
    if one is not None and (not isinstance(one, nodes.Var) or one.anonymous):
        return None
    return holds_between(test.op, first, second)


def _tests_of_ages(index: Index) -> Iterator[tuple[nodes.Compare, bool]]:
    """Yield comparisons of an age, behind its `believe`, with a constant that is none.

    Yields:
        the comparison, and whether it holds.
    """
    if not index.of(nodes.Believe):
        return
    for use in index.of(nodes.And):
        ages: set[str] = set()
        for literal in literals(use.node):
            belief = literal.formula
            if isinstance(belief, nodes.Believe):
                if literal.holds and isinstance(belief.age, nodes.Var):
                    ages.add(belief.age.name)
                continue
            for test in subformulas(belief) if ages else ():
                if isinstance(test, nodes.Compare) and _is_age_and_word(test, ages):
                    holds = {"n=": True, "=": False}.get(test.op)
                    if holds is not None:
                        yield test, holds


def _is_age_and_word(test: nodes.Compare, ages: Container[str]) -> bool:
    """Whether an age, which is a number, is compared with a constant that is none."""
    return any(
        isinstance(one, nodes.Var)
        and one.name in ages
        and isinstance(other, nodes.Const)
        and number_of(other) is None
        for one, other in ((test.left, test.right), (test.right, test.left))
    )


def _apart(term: nodes.Term) -> tuple[nodes.Term | None, Number]:
    """Return a term without a number that is added to it, and that number.

    A number alone is nothing and that number.
    """
    alone = number_of(term)
    if alone is not None:
        return None, alone
    if isinstance(term, nodes.Call) and term.function in _ADDING:
        left, right = term.args[0], term.args[-1]
        added = number_of(right)
        if added is not None:
            return left, added if term.function == "+" else -added
        added = number_of(left)
        if added is not None and term.function == "+":
            return right, added
    return term, 0


_ADDING = ("+", "-")
"""What adds a number to a term, or takes one away."""
