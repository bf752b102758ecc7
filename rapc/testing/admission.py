"""What keeps a test from being run that only its world can tell.

All else that may be wrong with a test is found by the checker, without any world
(`rapc.analysis`), and is told before a world is made.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import msgspec

from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.library import Library


class Problem(msgspec.Struct, frozen=True):
    """What is wrong with a test, and where: one line."""

    span: Span
    message: str


def problems(
    test: nodes.DefineTest,
    library: Library,
    handled: Collection[str] = (),
    solved: Collection[str] = (),
) -> list[Problem]:
    """Return why a test cannot be run in its world.

    Args:
        test: the test.
        library: what it runs.
        handled: the sensor data that the world it names has handlers for.
        solved: the RAPs that its problem solvers bring methods for.
    """
    found = [problem for row in test.script for problem in _row(row, handled)]
    for clause in ("seed", "agenda", "answers", "options"):
        if getattr(test, clause) not in (None, ()):
            found.append(Problem(test.name_span, f"`{clause}` cannot be run yet"))
    later = [action for at in test.ats for action in at.actions]
    inner = [
        e for one in later if isinstance(one, nodes.Expect) for e in one.expectations
    ]
    for expected in (*inner, *test.expectations):
        if isinstance(expected, nodes.MethodChosen) and expected.rap not in solved:
            rap = library.raps.get(expected.rap)
            if rap is not None and expected.method not in method_names(rap):
                message = f"`{rap.name}` has no method called `{expected.method}`"
                found.append(Problem(expected.span, message))
    return found


def method_names(rap: nodes.DefineRap) -> list[str]:
    """Return the names of a RAP's methods as a trace writes them."""
    return [
        f"#{method.position}" if method.name is None else str(method.name)
        for method in rap.methods
    ]


def _row(row: nodes.ScriptRow, handled: Collection[str]) -> Iterator[Problem]:
    if row.kind != "request":
        yield Problem(row.span, "skills cannot be run yet")
    for datum in row.data:
        if datum.name not in handled:
            message = f"there is no handler for the datum `{datum.name}`"
            yield Problem(datum.span, message)
