"""`unbound-variable` against brute force: all orders of a task-net are tried."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations

from hypothesis import given
from hypothesis import strategies as st

from rapc.analysis.driver import check_library
from rapc.base.diagnostics import Label
from rapc.base.source import Span
from rapc.library.loader import load_text
from tests.effort import examples

Net = Sequence[tuple[str | None, str | None, str | None, Sequence[int], str]]
"""Steps: the variable used, the one handed out, the one a formula binds, the steps put
behind, and how the order is said."""

VARIABLES = ("?alpha", "?bravo", "?citron")


@st.composite
def nets(draw: st.DrawFn) -> Net:
    """Task-nets of up to five steps in a random partial order.

    No step hands out what it is given: that is a slip, which accounts for what is
    unbound behind it.
    """
    count = draw(st.integers(2, 5))
    shuffled = draw(st.permutations(range(count)))
    variable = st.sampled_from((*VARIABLES, None))
    rows: list[tuple[str | None, str | None, str | None, list[int], str]] = []
    for at in range(count):
        later = [o for o in range(count) if shuffled[o] > shuffled[at]]
        behind = draw(st.lists(st.sampled_from(later), unique=True)) if later else []
        used, handed = draw(variable), draw(variable)
        rows.append(
            (
                used,
                handed if handed != used else None,
                draw(variable),
                behind,
                draw(st.sampled_from(["for", "formula"])),
            )
        )
    return rows


def _program(net: Net) -> str:
    steps = []
    for at, (used, handed, formed, behind, how) in enumerate(net):
        goal = f"(go {used or 'here'} => {handed or '?'})"
        notes = " ".join(
            f"((at {formed or 'here'}) for t{other})"
            if how == "formula"
            else f"(for t{other})"
            for other in behind
        )
        steps.append(f"\n  (t{at} {goal} {notes})")
    return (
        "(declare-memory-proposition at (?place))\n"
        "(define-rap (go ?x => ?y))\n"
        f"(define-rap (all) (method (task-net{''.join(steps)})))"
    )


def _orders(net: Net) -> Iterator[Sequence[int]]:
    for order in permutations(range(len(net))):
        if all(
            order.index(at) < order.index(o)
            for at, row in enumerate(net)
            for o in row[3]
        ):
            yield order


def _lacking(net: Net) -> set[int]:
    """The steps that find their variable unbound in some order."""
    lacking = set()
    for order in _orders(net):
        bound: set[str | None] = {None}
        for at in order:
            used, handed, *_ = net[at]
            for _, _, formed, behind, how in net:
                if at in behind and how == "formula":
                    bound.add(formed)
            if used not in bound:
                lacking.add(at)
            bound.add(handed)
    return lacking


@examples(600)
@given(nets())
def test_agrees_with_all_orders_tried(net: Net) -> None:
    report = check_library(load_text(_program(net)))
    found = [f for f in report.findings if f.rule.name == "unbound-variable"]
    variables = {net[at][0] for at in _lacking(net)}
    assert {f.diagnostic.message.split("`")[1] for f in found} == variables
    rows = {
        report.files["<text>"].position(span.start).row
        for f in found
        for span in (f.diagnostic.span, *_further(f.diagnostic.labels))
    }
    shown = {at + 4 for at in _lacking(net)}
    assert rows <= shown
    assert len(rows) == len(shown) or len(shown) > 4


def _further(labels: Sequence[Label]) -> Iterator[Span]:
    return (label.span for label in labels if label.message == "not bound here, either")
