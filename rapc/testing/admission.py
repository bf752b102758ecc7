"""What keeps a test from being run that only its world can tell.

All else that may be wrong with a test is found by the checker, without any world
(`rapc.analysis`), and is told before a world is made.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

import msgspec

from rapc.base.source import Span
from rapc.base.values import Atom
from rapc.errors import WorldError
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.testing.coverage import traced_name
from rapc.world import Kit, World
from rapc.worlds import registry


class Problem(msgspec.Struct, frozen=True):
    """What is wrong with a test, and where: one line."""

    span: Span
    message: str


def problems(
    test: nodes.DefineTest,
    library: Library,
    kit: Kit,
) -> list[Problem]:
    """Return why a test cannot be run in its world.

    Args:
        test: the test.
        library: what it runs.
        kit: what the world that it names brings along; an empty one without a world.
    """
    handled, solved = kit.handlers.data, kit.solvers
    found = [problem for row in test.script for problem in _row(row, handled)]
    for answer in test.answers:
        name = answer.call.function
        if name in kit.functions:
            said = f"the world `{test.world}` answers for `{name}` itself"
            found.append(Problem(answer.span, said))
    later = [action for at in test.ats for action in at.actions]
    inner = [
        e for one in later if isinstance(one, nodes.Expect) for e in one.expectations
    ]
    for expected in (*inner, *test.expectations):
        if isinstance(expected, nodes.MethodChosen) and expected.rap not in solved:
            rap = library.raps.get(expected.rap)
            if rap is not None and expected.method not in map(traced_name, rap.methods):
                message = f"`{rap.name}` has no method called `{expected.method}`"
                found.append(Problem(expected.span, message))
    return found


def options_of(
    test: nodes.DefineTest, world: type[World]
) -> tuple[dict[str, Atom | bool], list[Problem]]:
    """Return the options that a test sets for its world, and what is wrong with them.

    Args:
        test: the test.
        world: the world that it names.
    """
    flags = {option.name for option in world.kit.options if option.kind == "flag"}
    values: dict[str, Atom | bool] = {}
    found = []
    for option in test.options:
        given: Atom | bool = option.value
        if option.name in flags and given in ("true", "false"):
            given = given == "true"
        try:
            values |= registry.check_options(world, {option.name: given})
        except WorldError as error:
            said = f"{error.message}; {error.help}" if error.help else error.message
            found.append(Problem(option.span, said))
    return values, found


def _row(row: nodes.ScriptRow, handled: Collection[str]) -> Iterator[Problem]:
    for datum in row.data:
        if datum.name not in handled:
            message = f"there is no handler for the datum `{datum.name}`"
            yield Problem(datum.span, message)
