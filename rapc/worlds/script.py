"""The rows of a script, how they match requests, and what is wrong with them.

Rows are tried in order for each request; the first whose pattern matches and that is
not used up answers it, and its variables serve its effects. Symbols that begin with
`?` are variables, `?` alone matches anything.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal, Protocol

import msgspec

from rapc.base.values import (
    Atom,
    Bindings,
    Fact,
    format_list,
    is_variable,
    match_pattern,
)
from rapc.errors import FactError
from rapc.ir.nodes import DeclareDatum, DeclareEvent, DeclarePrimitive, DeclareSkill
from rapc.library.signatures import Fault, Signatures, Use
from rapc.world import OKAY, HandlerMemory, Offer, Time

_AS_THEY_ARE: Mapping[Atom, Atom] = {}

_EFFECTS = ("asserts", "erases", "moves", "loses", "data", "signals")
"""What of a row may have its variables."""


class Row(msgspec.Struct, frozen=True):
    """One row of a script: the requests it answers, and what comes of them.

    Args:
        pattern: the request, with variables.
        result: its result.
        times: how often the row may be used; None: always.
        takes: how long the primitive holds the robot, in time units.
        after: given, the primitive is not atomic: its end, with all that comes with
            it, is that many time units after `takes`.
        asserts: facts asserted with the result.
        erases: prefixes erased with the result, before that.
        moves: items that then are at other places, each with its place.
        loses: items that then are not where they were.
        data: sensor data sent with the result.
        signals: signals sent with the result.
        refused: whether instead the request is refused, as in conflict with all that
            are under way.
        kind: whether it is a request, or a skill that goes on (`enable`) or off.
        pauses: how long each of the signals of a skill waits for the one before it;
            none: they come at once.
        every: how long after its signals a skill tells them again; None: never.
    """

    pattern: Fact
    result: str = OKAY
    times: int | None = None
    takes: Time = 0
    after: Time | None = None
    asserts: tuple[Fact, ...] = ()
    erases: tuple[Fact, ...] = ()
    moves: tuple[tuple[Atom, Atom], ...] = ()
    loses: tuple[Atom, ...] = ()
    data: tuple[Fact, ...] = ()
    signals: tuple[Fact, ...] = ()
    refused: bool = False
    kind: Literal["request", "enable", "disable"] = "request"
    pauses: tuple[Time, ...] = ()
    every: Time | None = None

    def pause(self, at: int) -> Time:
        """Return how long the signal `at` waits for the one before it."""
        return self.pauses[at] if self.pauses else 0


class At(msgspec.Struct, frozen=True):
    """What happens at a time without a request: changes of memory, then signals.

    In the course of an atomic primitive it happens at its end, before its result.
    """

    time: Time
    asserts: tuple[Fact, ...] = ()
    erases: tuple[Fact, ...] = ()
    moves: tuple[tuple[Atom, Atom], ...] = ()
    loses: tuple[Atom, ...] = ()
    signals: tuple[Fact, ...] = ()


class Declarations(Protocol):
    """What a library says of its world: the part of a `Library` needed."""

    @property
    def primitives(self) -> Mapping[str, DeclarePrimitive]:
        """The primitives declared, by name."""

    @property
    def data(self) -> Mapping[str, DeclareDatum]:
        """The data declared, by name."""

    @property
    def skills(self) -> Mapping[str, DeclareSkill]:
        """The skills declared, by name."""

    @property
    def events(self) -> Mapping[str, DeclareEvent]:
        """The events declared, by name."""


def fillers(row: Row) -> tuple[str, ...]:
    """Return the names of a row's effects that there are: those that `fill` fills."""
    return tuple([name for name in _EFFECTS if getattr(row, name)])


def fill(
    row: Row, effects: Iterable[str], bound: Mapping[Any, Any], pattern: Fact
) -> Row:
    """Return a row with its variables put into its effects.

    Args:
        row: the row.
        effects: what `fillers` says of the row.
        bound: the values of its variables.
        pattern: the pattern of the row to be returned.
    """
    filled: dict[str, Any] = {}
    if bound:
        for name in effects:
            filled[name] = tuple([_put(bound, part) for part in getattr(row, name)])
    elif row.pattern is pattern:
        return row
    return msgspec.structs.replace(row, pattern=pattern, **filled)


def _put(bound: Mapping[Any, Any], part: Atom | Fact) -> Any:
    """Return an atom, or a fact, with the values of its variables."""
    if type(part) is tuple:
        return tuple([bound.get(one, one) for one in part])
    return bound.get(part, part)


FoundRow = tuple[int, Bindings]
"""The number of a row that matches, and what it binds."""


class Script:
    """The rows of a script; how often each has been used is kept outside."""

    def __init__(self, rows: Sequence[Row]) -> None:
        self.rows = tuple(rows)
        self._fillers = [fillers(row) for row in self.rows]

    def find(self, kind: str, asked: Fact, used: Sequence[int]) -> FoundRow | None:
        """Return the first row of a kind that matches and is not used up.

        Args:
            kind: `request`, `enable` or `disable`.
            asked: the request or the skill.
            used: how often each row has been used.
        """
        for index, row in enumerate(self.rows):
            if row.kind != kind or used[index] == row.times:
                continue
            bound = match_pattern(row.pattern, asked)
            if bound is not None:
                return index, bound
        return None

    def use(self, found: FoundRow, used: list[int], asked: Fact | None = None) -> Row:
        """Use a row that was found, with what it binds; return it filled in.

        Args:
            found: the row.
            used: how often each row has been used; one more for this.
            asked: the request that it answers, to be its pattern; a skill's row keeps
                its own.
        """
        (index, bound), row = found, self.rows[found[0]]
        used[index] += 1
        return fill(row, self._fillers[index], bound, asked or row.pattern)


def change(
    memory: HandlerMemory, effects: Row | At, names: Mapping[Atom, Atom] = _AS_THEY_ARE
) -> None:
    """Do to memory what a row or an entry says: erase, assert, move and lose.

    Args:
        memory: where it is done.
        effects: what says it, filled in.
        names: memory's names of items, by the sensor names in `effects`.

    Raises:
        FactError: for an item that no handler has introduced, naming the row.
    """
    for fact in effects.erases:
        memory.erase(*_by_names(fact, names))
    for fact in effects.asserts:
        memory.assert_fact(*_by_names(fact, names))
    try:
        for item, place in effects.moves:
            memory.move(str(names.get(item, item)), names.get(place, place))
        for item in effects.loses:
            memory.lose(str(names.get(item, item)))
    except FactError as error:
        raise FactError(f"{_named(effects)}: {error}") from error


def _by_names(fact: Fact, names: Mapping[Atom, Atom]) -> Fact:
    """Return a fact with memory's names of items."""
    if not names:
        return fact
    return (fact[0], *[names.get(part, part) for part in fact[1:]])


def _named(effects: Row | At) -> str:
    """Return a row or an entry as a message names it."""
    if isinstance(effects, At):
        return f"at {effects.time}"
    return f"row {format_list(effects.pattern)}"


def offer_of(declared: Declarations) -> Offer:
    """All that a library declares."""
    return Offer(
        primitives={
            name: (len(form.args), form.results)
            for name, form in declared.primitives.items()
        },
        data={name: len(form.args) for name, form in declared.data.items()},
        skills={name: len(form.args) for name, form in declared.skills.items()},
        events={name: len(form.args) for name, form in declared.events.items()},
        not_atomic=tuple(
            [name for name, form in declared.primitives.items() if not form.atomic]
        ),
    )


def mentioned(rows: Sequence[Row], at: Sequence[At]) -> Offer:
    """All that a script mentions."""
    results: dict[str, dict[str, None]] = {}
    arity: dict[str, int] = {}
    for row in rows:
        name = str(row.pattern[0])
        if row.kind != "request":
            continue
        arity.setdefault(name, len(row.pattern) - 1)
        results.setdefault(name, {OKAY: None})[row.result] = None
    signals = [signal for row in rows for signal in row.signals]
    signals += [signal for entry in at for signal in entry.signals]
    return Offer(
        primitives={name: (arity[name], tuple(results[name])) for name in results},
        data=_arities(datum for row in rows for datum in row.data),
        skills=_arities(row.pattern for row in rows if row.kind != "request"),
        events=_arities(signals),
        not_atomic=tuple(
            {
                str(row.pattern[0]): None
                for row in rows
                if row.kind == "request" and row.after is not None
            }
        ),
    )


def check_script(
    rows: Sequence[Row], at: Sequence[At], offer: Offer, handled: Container[str]
) -> None:
    """See that a script keeps to an offer.

    Args:
        rows: the rows of the script.
        at: what happens without a request.
        offer: what the world of the script offers.
        handled: the sensor data that there are handlers for.

    Raises:
        ValueError: with the first row or entry that does not, and why.
    """
    signatures = Signatures.offered(offer)
    for row in rows:
        for problem in _row_problems(row, signatures, handled, offer):
            raise ValueError(f"row {format_list(row.pattern)}: {problem}")
    for entry in at:
        facts = (*entry.asserts, *entry.erases, *entry.moves, entry.loses)
        facts = (*facts, *entry.signals)
        unknown = _faults(signatures, "event", entry.signals)
        for problem in (*_unbound(facts, ()), *unknown):
            raise ValueError(f"at {entry.time}: {problem}")


def _row_problems(
    row: Row, signatures: Signatures, handled: Container[str], offer: Offer
) -> Iterator[object]:
    """Yield what is wrong with a row of a script."""
    if row.kind == "request":
        yield from _faults(signatures, "primitive", [row.pattern])
        no_result = signatures.no_result(str(row.pattern[0]), row.result)
        if no_result is not None:
            yield no_result
        if row.after is not None and row.pattern[0] not in offer.not_atomic:
            name = row.pattern[0]
            wrong = "is declared atomic, so it does not end `:after` its request"
            yield f"`{name}` {wrong}"
    else:
        yield from _faults(signatures, "skill", [row.pattern])
    changes = (*row.asserts, *row.erases, *row.moves, row.loses)
    yield from _unbound((*changes, *row.data, *row.signals), row.pattern)
    yield from _faults(signatures, "event", row.signals)
    yield from _faults(signatures, "datum", row.data)
    for datum in row.data:
        if datum[0] not in handled:
            yield f"there is no handler for the datum `{datum[0]}`"


def _unbound(facts: Iterable[Fact], pattern: Fact) -> Iterator[str]:
    for part in (part for fact in facts for part in fact):
        if is_variable(part) and (part == "?" or part not in pattern):
            yield f"`{part}` is not bound by its pattern"


def _faults(signatures: Signatures, use: Use, facts: Iterable[Fact]) -> Iterator[Fault]:
    for fact in facts:
        fault = signatures.fault(use, str(fact[0]), len(fact) - 1)
        if fault is not None:
            yield fault


def _arities(facts: Iterable[Fact]) -> dict[str, int]:
    return {str(fact[0]): len(fact) - 1 for fact in facts}
