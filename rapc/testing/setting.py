"""The setting of a test: its world or the borrowed parts of one, script, answers.

A library may call functions that nobody registered, because the functions belong to a
world that the test does not use. Answers of the test replace these functions.

Errors that depend on the world of a test prevent its run, and are found here. The
checker finds all other errors of a test, without a world (`rapc.analysis`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Container, Mapping, Sequence
from typing import Any

import msgspec

from rapc.base.files import path_of, read_bytes
from rapc.base.source import Span
from rapc.base.values import Atom, Fact, format_list, match_pattern, readable
from rapc.debug.saved_state import SavedState
from rapc.errors import Error, StateError, WorldError, in_a_line
from rapc.ir import nodes
from rapc.library.effects import complete_data
from rapc.library.library import Library
from rapc.library.signatures import Signatures
from rapc.testing.patterns import atom, flat
from rapc.world import Kit, Refused, Reply, Time, World, Wrapper
from rapc.worlds import registry
from rapc.worlds.script import Row


class Unmet(msgspec.Struct, frozen=True):
    """A failed expectation: its position, and what happened instead.

    `events` is the number of events in the trace at the time of the failure.
    """

    span: Span
    happened: tuple[str, ...]
    events: int = 0


class UnansweredQuestion(Error):
    """A call of a memory function that no answer of the test matches."""

    def __init__(self, question: Fact) -> None:
        super().__init__(f"no answer of the test matches {format_list(question)}")

    def __str__(self) -> str:
        """Return the message, with the clauses that called the function."""
        return ", asked by ".join([self.message, *getattr(self, "__notes__", ())])


def functions(answers: Sequence[nodes.Answer]) -> Mapping[str, Callable[..., Any]]:
    """Return the functions for `answers`, by name, as a host registers functions."""
    tables: dict[str, list[tuple[Fact, Atom]]] = {}
    for answer in answers:
        name = answer.call.function
        pattern = (name, *[atom(arg) for arg in answer.call.args])
        tables.setdefault(name, []).append((pattern, answer.value.value))
    return {name: _function(name, table) for name, table in tables.items()}


def _function(name: str, table: Sequence[tuple[Fact, Atom]]) -> Callable[..., Any]:
    """Return a function that returns the first answer that matches a call."""

    def answered(memory: object, *given: Any) -> Atom:
        """Return the answer to (name given...); of a default, `given` is an index.

        Raises:
            UnansweredQuestion: if no answer matches.
        """
        args = given[0] if len(given) == 1 and isinstance(given[0], tuple) else given
        question = (name, *args)
        for pattern, value in table:
            if match_pattern(pattern, question) is not None:
                return value
        raise UnansweredQuestion(question)

    return answered


# --- the world ------------------------------------------------------------------------


class ObservedWorld(Wrapper):
    """A wrapper of a simulator that calls `leaving` before the clock may move."""

    def __init__(self, world: World, leaving: Callable[[], None]) -> None:
        super().__init__(world)
        self._leaving = leaving

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Call `leaving`, then pass the request on."""
        self._leaving()
        return super().perform(ticket, request)

    def advance(self, to: Time) -> None:
        """Call `leaving` if the clock moves, then advance the world."""
        if to > self.now():
            self._leaving()
        super().advance(to)


def saved_state(test: nodes.DefineTest) -> SavedState | None:
    """Return the state in which a test begins, if the test names a file.

    Raises:
        LoadError: if the file cannot be read.
        StateError: if the file is not a saved state.
    """
    if test.saved_state is None:
        return None
    path = path_of(test.name_span.file).parent / test.saved_state
    try:
        return SavedState(read_bytes(path))
    except StateError as error:
        raise StateError(f"cannot begin in `{path}`: {error}") from error


def named_world(
    test: nodes.DefineTest,
    seed: int,
    modules: Collection[str],
    state: SavedState | None,
) -> tuple[World | None, list[Unmet]]:
    """Return the world that a test names, or why it is unavailable.

    Raises:
        WorldError: if the world is unknown, or may not be used.
        StateError: if the state belongs to another world.
    """
    if test.world is None:
        return None, []
    found = registry.find_permitted(test.world, modules)
    options, wrong = _options(test, found)
    if wrong:
        return None, wrong
    if state is not None:
        options = state.options_of(found) | options
    return registry.build_world(found, seed, options), []


def _options(
    test: nodes.DefineTest, world: type[World]
) -> tuple[dict[str, Atom | bool], list[Unmet]]:
    """Return the options that a test sets for its world, and their errors."""
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
            found.append(Unmet(option.span, (in_a_line(error),)))
    return values, found


def problems(
    test: nodes.DefineTest,
    library: Library,
    kit: Kit,
    figures: Container[str],
    state: SavedState | None,
) -> list[Unmet]:
    """Return the reasons why a test cannot be run in its world.

    Args:
        test: the test.
        library: the library under test.
        kit: the kit of the named world; an empty kit without a world.
        figures: the names of the figures of the world, if the test runs in it.
        state: the state in which the test begins, if it names a file.
    """
    handled = {*kit.handlers.data, *complete_data(library)}
    solved = kit.solvers
    found = [
        Unmet(datum.span, (f"datum `{datum.name}` has no handler",))
        for row in test.script
        for datum in row.data
        if datum.name not in handled
    ]
    for answer in test.answers:
        name = answer.call.function
        if name in kit.functions:
            said = f"the world `{test.world}` answers for `{name}` itself"
            found.append(Unmet(answer.span, (said,)))
    if state is not None and (test.world is None or test.script):
        message = "`saved-state` requires a world and no script"
        found.append(Unmet(test.name_span, (message,)))
    found += [
        Unmet(at.span, (f"the saved state is of time {readable(state.time)}",))
        for at in test.ats
        if state is not None and at.time < state.time
    ]
    later = [action for at in test.ats for action in at.actions]
    inner = [
        e for one in later if isinstance(one, nodes.Expect) for e in one.expectations
    ]
    for expected in (*inner, *test.expectations):
        if isinstance(expected, nodes.Figure) and expected.name not in figures:
            if test.world is None or test.script:
                message = "figures require a world and no script"
            else:
                message = f"the world `{test.world}` has no figure `{expected.name}`"
            found.append(Unmet(expected.span, (message,)))
        if isinstance(expected, nodes.MethodChosen) and expected.rap not in solved:
            rap = library.raps.get(expected.rap)
            names = () if rap is None else [one.traced_name for one in rap.methods]
            planned = rap is not None and rap.plan is not None
            if rap is not None and not planned and expected.method not in names:
                message = f"`{rap.name}` has no method called `{expected.method}`"
                found.append(Unmet(expected.span, (message,)))
    return found


def row_of(row: nodes.ScriptRow, signatures: Signatures) -> Row:
    """Return a row of a test's script in the form of the scripted world.

    The value `true` that a property leaves out in text is written out [L 2.26].
    """

    def stated(fact: nodes.Proposition) -> Fact:
        known = signatures.relations.get(fact.name)
        args = fact.args if known is None else known.full(fact.args)
        return (fact.name, *map(atom, args))

    return Row(
        pattern=flat(row.request),
        result=row.result or "okay",
        times=row.times,
        takes=row.takes,
        after=row.after,
        asserts=tuple(map(stated, row.asserts)),
        erases=tuple(map(flat, row.erases)),
        moves=tuple((atom(one.item), atom(one.place)) for one in row.moves),
        loses=tuple(map(atom, row.loses)),
        data=tuple(map(flat, row.data)),
        signals=tuple(map(flat, row.signals)),
        refused=row.refused,
        kind=row.kind,
        pauses=row.pauses,
        every=row.every,
    )
