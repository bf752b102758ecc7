"""The rows of a script, their match with requests, and the checks of a script.

Rows are tried in order for each request. The first row that matches and is not used up
answers the request; its variables fill its effects. Symbols that begin with `?` are
variables; `?` alone matches any value.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal

import msgspec

from rapc.base.values import Atom, Fact, format_list, is_variable
from rapc.errors import FactError
from rapc.library.library import Library
from rapc.library.signatures import Fault, Signatures, Use
from rapc.world import OKAY, HandlerMemory, Offer, Time

_EFFECTS = ("asserts", "erases", "moves", "loses", "data", "signals")
"""The fields of a row that may use its variables."""


class Row(msgspec.Struct, frozen=True):
    """A row of a script: matching requests and their effects.

    Args:
        pattern: the request, with variables. result: its result. times: the number of
        uses of the row; None: no limit. takes: the time for which the primitive holds
        the robot. after: if set, the primitive is not atomic: its end, with all
        effects, comes this
            many time units after `takes`.
        asserts: facts asserted with the result.
        erases: prefixes erased with the result, before `asserts`.
        moves: items moved with the result, each with its new place.
        loses: items that lose their place with the result.
        data: sensor data sent with the result.
        signals: signals sent with the result.
        refused: whether the request is refused instead, as in conflict with all active
            requests and activations.
        kind: a request, or switching a skill on (`enable`) or off.
        pauses: the wait before each signal of a skill after the preceding signal; if
            empty, all signals come at once.
        every: the time after which a skill repeats its signals; None: never.
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

    def __str__(self) -> str:
        return f"row {format_list(self.pattern)}"

    def pause(self, at: int) -> Time:
        """Return the wait before the signal `at` after the preceding signal."""
        return self.pauses[at] if self.pauses else 0


class At(msgspec.Struct, frozen=True):
    """Changes at a time, without a request: changes of memory, then signals.

    During an atomic primitive the changes happen at its end, before its result.
    """

    time: Time
    asserts: tuple[Fact, ...] = ()
    erases: tuple[Fact, ...] = ()
    moves: tuple[tuple[Atom, Atom], ...] = ()
    loses: tuple[Atom, ...] = ()
    signals: tuple[Fact, ...] = ()

    def __str__(self) -> str:
        return f"at {self.time}"


def fillers(row: Row) -> tuple[str, ...]:
    """Return the names of a row's non-empty effects, for `fill`."""
    return tuple([name for name in _EFFECTS if getattr(row, name)])


def fill(
    row: Row, effects: Iterable[str], bound: Mapping[Any, Any], pattern: Fact
) -> Row:
    """Return a row with its variables replaced in its effects.

    Args:
        row: the row.
        effects: the result of `fillers` for the row.
        bound: the values of its variables.
        pattern: the pattern of the new row.
    """
    filled: dict[str, Any] = {}
    if bound:
        for name in effects:
            filled[name] = tuple([_put(bound, part) for part in getattr(row, name)])
    elif row.pattern is pattern:
        return row
    return msgspec.structs.replace(row, pattern=pattern, **filled)


def _put(bound: Mapping[Any, Any], part: Atom | Fact) -> Any:
    """Return an atom or a fact with its variables replaced by their values."""
    if type(part) is tuple:
        return tuple([bound.get(one, one) for one in part])
    return bound.get(part, part)


def change(
    memory: HandlerMemory, effects: Row | At, names: Mapping[Atom, Atom] | None = None
) -> None:
    """Apply a row's or an entry's effects to memory: erase, assert, move and lose.

    Args:
        memory: the memory.
        effects: the row or entry, filled in.
        names: memory's names of items, by the sensor names in `effects`.

    Raises:
        FactError: for an item that no handler has introduced, with the row's name.
    """
    names = names or {}
    for name, *args in effects.erases:
        memory.erase(name, *[names.get(part, part) for part in args])
    for name, *args in effects.asserts:
        memory.assert_fact(name, *[names.get(part, part) for part in args])
    try:
        for item, place in effects.moves:
            memory.move(str(names.get(item, item)), names.get(place, place))
        for item in effects.loses:
            memory.lose(str(names.get(item, item)))
    except FactError as error:
        raise FactError(f"{effects}: {error}") from error


def offer_of(declared: Library) -> Offer:
    """Return the offer of all names that a library declares."""
    forms = declared.primitives
    return Offer(
        {name: (len(form.args), form.results) for name, form in forms.items()},
        {name: len(form.args) for name, form in declared.data.items()},
        {name: len(form.args) for name, form in declared.skills.items()},
        {name: len(form.args) for name, form in declared.events.items()},
        not_atomic=tuple([name for name, form in forms.items() if not form.atomic]),
    )


def mentioned(rows: Sequence[Row], at: Sequence[At]) -> Offer:
    """Return the offer of all names that a script mentions."""
    requests = [row for row in rows if row.kind == "request"]
    results: dict[str, dict[str, None]] = {}
    for row in requests:
        results.setdefault(str(row.pattern[0]), {OKAY: None})[row.result] = None
    arity = _arities(row.pattern for row in reversed(requests))
    script: list[Row | At] = [*rows, *at]
    ends_later = [str(row.pattern[0]) for row in requests if row.after is not None]
    return Offer(
        {name: (arity[name], tuple(found)) for name, found in results.items()},
        _arities(datum for row in rows for datum in row.data),
        _arities(row.pattern for row in rows if row.kind != "request"),
        _arities(signal for one in script for signal in one.signals),
        not_atomic=tuple(dict.fromkeys(ends_later)),
    )


def check_script(
    rows: Sequence[Row], at: Sequence[At], offer: Offer, handled: Container[str]
) -> None:
    """Validate a script against an offer.

    Args:
        rows: the rows of the script.
        at: the entries without a request.
        offer: the offer of the script's world.
        handled: the sensor data with handlers.

    Raises:
        ValueError: with the first invalid row or entry, and the reason.
    """
    signatures = Signatures.offered(offer)
    script: list[Row | At] = [*rows, *at]
    for one in script:
        for problem in _problems(one, signatures, handled, offer):
            raise ValueError(f"{one}: {problem}")


def _problems(
    one: Row | At, signatures: Signatures, handled: Container[str], offer: Offer
) -> Iterator[object]:
    """Yield the faults of a row or an entry of a script."""
    facts = (*one.asserts, *one.erases, *one.moves, one.loses, *one.signals)
    if isinstance(one, At):
        yield from _unbound(facts, ())
        yield from _faults(signatures, "event", one.signals)
        return
    name = str(one.pattern[0])
    yield from _faults(
        signatures, "primitive" if one.kind == "request" else "skill", [one.pattern]
    )
    if one.kind == "request":
        no_result = signatures.no_result(name, one.result)
        if no_result is not None:
            yield no_result
        if one.after is not None and name not in offer.not_atomic:
            wrong = "is declared atomic, so it does not end `:after` its request"
            yield f"`{name}` {wrong}"
    yield from _unbound((*facts, *one.data), one.pattern)
    yield from _faults(signatures, "event", one.signals)
    yield from _faults(signatures, "datum", one.data)
    for datum in one.data:
        if datum[0] not in handled:
            yield f"datum `{datum[0]}` has no handler"


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
