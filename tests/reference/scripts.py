"""Random worlds and tasks: facts, rows and `at` of a script, what the host does."""

from __future__ import annotations

import random
from collections.abc import Collection, Sequence
from typing import Any

from rapc.base.values import Fact
from rapc.world import Time
from rapc.worlds.script import At, Row
from tests.reference.case import read_atom
from tests.reference.nets import Sketch
from tests.reference.raps import method, mild_method
from tests.reference.vocabulary import (
    METHODS,
    NUMBERS,
    PRIMITIVES,
    PROPERTIES,
    PROPOSITIONS,
    QUERIES,
    SIGNALS,
    SKILLS,
    SYMBOLS,
    USING,
    VALUES,
    WILD,
)
from tests.reference.words import Datum, Words


def text(datum: Datum) -> str:
    """Nested data as text."""
    if isinstance(datum, str):
        return datum
    return f"({' '.join(text(part) for part in datum)})"


def fact(rng: random.Random, variables: Sequence[str] = ()) -> Datum:
    """A fact; it may use some variables."""
    name = rng.choice(("p", "p", "p", *PROPERTIES, *PROPOSITIONS))
    items = (*SYMBOLS, *SYMBOLS, *variables)
    if name in PROPOSITIONS:
        return (name, *(rng.choice(items) for _ in range(PROPOSITIONS[name])))
    index = tuple(rng.choice(items) for _ in range(PROPERTIES[name]))
    if index and rng.random() < 0.2:
        return (name, *index, index[0])
    return (name, *index, rng.choice((*VALUES * 2, *WILD, *NUMBERS, *variables)))


def common(rng: random.Random) -> Datum:
    """A fact of those that questions with many solutions are about."""
    items = (*SYMBOLS, *SYMBOLS, "b", "e", "1", "2")
    name = rng.choice(("p", "q", "r", "r"))
    return (name, *(rng.choice(items) for _ in range(1 if name == "q" else 2)))


def _read(datum: Datum) -> Fact:
    return tuple(read_atom(part) for part in datum)


def _changes(rng: random.Random, variables: Sequence[str] = ()) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if rng.random() < 0.6:
        count = rng.choice((1, 1, 2))
        found["asserts"] = tuple(_read(fact(rng, variables)) for _ in range(count))
    if rng.random() < 0.25:
        prefix = fact(rng, variables)
        found["erases"] = (_read(prefix[: rng.randrange(1, len(prefix) + 1)]),)
    if rng.random() < 0.35:
        name = rng.choice(list(SIGNALS))
        args = [rng.choice((*SYMBOLS, *variables)) for _ in range(SIGNALS[name])]
        found["signals"] = (_read((name, *args)),)
    return found


def rows(rng: random.Random, wild: float, forms: Collection[str]) -> tuple[Row, ...]:
    """The rows of a script; for each primitive the last one answers anything."""
    made: list[Row] = []
    using = USING if "claims" in forms else {}
    for name, (arity, results) in (*PRIMITIVES.items(), *using.items()):
        for _ in range(rng.randrange(4)):
            pattern = [rng.choice(("?x", "?y", "?", *SYMBOLS)) for _ in range(arity)]
            times = rng.choice((1, 1, 2, None))
            row = _row(rng, wild, (name, *pattern), results, times)
            made.append(_refused(rng, row) if "refusals" in forms else row)
        anything = ("?" for _ in range(arity))
        made.append(_row(rng, wild, (name, *anything), results, None))
    if "skills" in forms:
        on = _skills(rng)
        made += [_refused(rng, row) for row in on] if "refusals" in forms else on
    return tuple(made)


def _refused(rng: random.Random, row: Row) -> Row:
    """A row or, at times, the same request refused, as in conflict with others."""
    if row.kind == "disable" or rng.random() > 0.3:
        return row
    times = rng.choice((1, 1, 1, 2, None))
    return Row(row.pattern, kind=row.kind, times=times, refused=True)


def _skills(rng: random.Random) -> list[Row]:
    """Rows for skills that come on and go off; what they tell, and when."""
    made: list[Row] = []
    for name, arity in SKILLS.items():
        for _ in range(rng.randrange(4)):
            pattern = [rng.choice(("?x", "?y", "?", *SYMBOLS)) for _ in range(arity)]
            bound = sorted({str(p) for p in pattern if p in ("?x", "?y")})
            changes = _changes(rng, bound)
            told = [_signal(rng, bound) for _ in range(rng.choice((0, 1, 1, 2, 3)))]
            changes["signals"] = tuple(told)
            off = rng.random() < 0.2
            made.append(
                Row(
                    (name, *pattern),
                    kind="disable" if off else "enable",
                    times=rng.choice((1, 2, None, None)),
                    after=None if off else rng.choice((None, 0, 1, 3, 7)),
                    pauses=() if off else tuple(rng.choice((0, 0, 1, 4)) for _ in told),
                    every=None if off else rng.choice((None, None, 2, 5)),
                    **changes,
                )
            )
    return made


def _signal(rng: random.Random, variables: Sequence[str]) -> Fact:
    name = rng.choice(list(SIGNALS))
    args = [rng.choice((*SYMBOLS, *variables)) for _ in range(SIGNALS[name])]
    return _read((name, *args))


def _row(
    rng: random.Random,
    wild: float,
    pattern: Fact,
    results: Sequence[str],
    times: int | None,
) -> Row:
    variables = sorted({str(p) for p in pattern if p in ("?x", "?y")})
    changes = _changes(rng, variables)
    if rng.random() < 0.1:
        seen = [rng.choice((*SYMBOLS, *variables)) for _ in range(2)]
        changes["data"] = (("seen", *seen),)
    uses = pattern[0] in USING
    lasting = pattern[0] == "slow" or (uses and pattern[0] != "tap")
    slow = lasting and rng.random() < 0.85
    return Row(
        pattern,
        rng.choice(results) if rng.random() < 0.2 + 0.2 * wild else "okay",
        times=times,
        takes=0 if uses and slow else rng.choice((0, 0, 1, 2, 5, 2.5)),
        after=rng.choice((3, 7, 12) if uses else (0, 1, 3, 7)) if slow else None,
        **changes,
    )


def at(rng: random.Random) -> At:
    """What happens at a time."""
    time = rng.choice((0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 25, 2.5))
    return At(time, **_changes(rng))


def task(
    rng: random.Random, sketches: Sequence[Sketch], forms: Collection[str] = ()
) -> str:
    """A top-level task with its options; those that fight for things differ more."""
    rivals = "claims" in forms
    sketch = rng.choice((*[sketches[0]] * 4, *sketches))
    args = [rng.choice((*SYMBOLS, *SYMBOLS, *VALUES)) for _ in sketch.inputs]
    words = [text((sketch.name, *args))]
    if rng.random() < (0.7 if rivals else 0.3):
        words.append(f":priority {rng.choice((1, 2, 3, -1))}")
    if rng.random() < 0.3:
        words.append(f":deadline {rng.randrange(1, 30)}")
    if rng.random() < (0.5 if rivals else 0.2):
        words.append(f":at {rng.randrange(0, 12)}")
    if rng.random() < 0.1:
        words.append(":background true")
    return " ".join(words)


def host(rng: random.Random, sketches: Sequence[Sketch]) -> tuple[Time, str, str]:
    """What the host does in the course of a run: when, what and with what."""
    kind = rng.choice(("assert", "erase", "signal", "cancel", "submit"))
    time = rng.choice((0, 1, 2, 3, 5, 8, 13))
    if kind == "submit":
        return time, kind, task(rng, sketches)
    if kind == "cancel":
        sketch = rng.choice(sketches[:2])
        wanted = tuple(rng.choice(("?", "?x", *SYMBOLS)) for _ in sketch.inputs)
        return time, kind, text((sketch.name, *wanted))
    if kind == "signal":
        name = rng.choice(list(SIGNALS))
        args = tuple(rng.choice(SYMBOLS) for _ in range(SIGNALS[name]))
        return time, kind, text((name, *args))
    made = fact(rng)
    return time, kind, text(made if kind == "assert" else made[:2])


def solvers(
    rng: random.Random,
    wild: float,
    sketches: Sequence[Sketch],
    forms: Collection[str],
) -> tuple[tuple[str, Datum], ...]:
    """Methods that problem solvers return, for some RAPs."""
    found = []
    for place, sketch in enumerate(sketches):
        if rng.random() < 0.3:
            words = Words(rng, wild, sketch.inputs)
            words.forms = forms
            words.queries = tuple(QUERIES) if "queries" in forms else ()
            names = ["late", METHODS[0]]
            made = [method(words, sketches, place, names) for _ in range(2)]
            made.append(mild_method(words, sketches, place))
            rng.shuffle(made)
            found.append((sketch.name, tuple(made[: rng.randrange(4)])))
    return tuple(found)
