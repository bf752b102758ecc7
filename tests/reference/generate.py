"""Random libraries with scripts and tasks, one for each seed.

They keep to what the checker's errors ask for (declared names, right numbers of
arguments, tags that exist, orders without cycles) and are wild otherwise.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

from rapc.runtime.machine import Settings
from rapc.terms import Fact
from rapc.worlds.script import At, Row
from tests.reference.case import Case, read_atom
from tests.reference.formulas import Datum, Words
from tests.reference.vocabulary import (
    DECLARATIONS,
    NUMBERS,
    PRIMITIVES,
    PROPERTIES,
    PROPOSITIONS,
    SIGNALS,
    SYMBOLS,
    VALUES,
    WILD,
)


class Sketch:
    """A RAP before it is written: its name and its parameters."""

    def __init__(
        self, name: str, inputs: Sequence[str], outputs: Sequence[str]
    ) -> None:
        self.name = name
        self.inputs = list(inputs)
        self.outputs = list(outputs)


def generate(seed: int) -> Case:
    """The case of a seed, always the same."""
    rng = random.Random(f"{seed}:case")
    count = rng.randrange(3, 8)
    sketches = [
        Sketch(
            f"r{n}",
            ["?i", "?j"][: rng.choice((0, 1, 1, 2))],
            ["?o", "?n"][: rng.choice((0, 0, 1, 1, 2))],
        )
        for n in range(count)
    ]
    raps = [_rap(rng, sketches, n) for n in range(count)]
    return Case(
        seed=seed,
        forms=(*DECLARATIONS, *raps),
        rows=tuple(_rows(rng)),
        at=tuple(_at(rng) for _ in range(rng.randrange(9))),
        facts=tuple(_text(_fact(rng)) for _ in range(rng.randrange(2, 9))),
        tasks=tuple(_task(rng, sketches) for _ in range(rng.choice((1, 2, 2, 3, 4)))),
        solvers=_solvers(rng, sketches),
        host=tuple(_host(rng, sketches) for _ in range(rng.choice((0, 0, 0, 1, 2)))),
        until=rng.choice((20, 60, 60, 100)),
        cycles=rng.choice((40, 120, 120)),
        settings=Settings(
            futile_limit=rng.choice((1, 2, 2, 2, 3)),
            idle_cycles=rng.choice((15, 40, 40)),
            cycle_cost=rng.choice((0, 0, 0, 0, 1, 0.5)),
        ),
    )


# --- RAPs ---------------------------------------------------------------------------


def _rap(rng: random.Random, sketches: Sequence[Sketch], at: int) -> Datum:
    sketch = sketches[at]
    words = Words(rng, sketch.inputs)
    index: tuple[Any, ...] = (sketch.name, *sketch.inputs)
    if sketch.outputs:
        index = (*index, "=>", *sketch.outputs)
    words.methods = ["one", "2"]
    mild = at == 0 or words.chance(0.5)
    clauses: list[Datum] = [("index", index), *_resources(words)]
    clauses += _monitors(words, 0.5 if mild else 1)
    if words.chance(0.2):
        clauses.append(("duration", words.time()))
    if not mild or words.chance(0.3):
        clauses += _conditions(words)
    clauses += _succeed(words, sketch)
    names = ["one", "2", ""]
    for _ in range(rng.choice((0, 1, 1, 1, 2, 2, 3)) if not mild else 1):
        clauses.append(_method(words, sketches, at, names))
    if mild:
        clauses.append(_mild_method(words, sketches, at))
    return ("define-rap", *clauses)


def _conditions(words: Words) -> list[Datum]:
    made: list[Datum] = []
    for name, share in (("preconditions", 0.12), ("constraints", 0.16)):
        if words.chance(share):
            made.append((name, _likely(words)))
    if words.chance(0.2):
        made.append(("repeat-while", words.formula()))
    return made


def _mild_method(words: Words, sketches: Sequence[Sketch], at: int) -> Datum:
    """A method that can always be chosen, and whose request is in order."""
    own = Words(words.rng, [w for w in words.known if w in ("?i", "?j")])
    own.sets, own.counters = words.sets, words.counters
    if at < len(sketches) - 1 and words.chance(0.6):
        return ("method", _task_net(own, sketches, at))
    name = words.pick(("act", "act", "rest", "slow"))
    args = (words.pick(SYMBOLS) for _ in range(PRIMITIVES[name][0]))
    return ("method", ("primitive", (name, *args)))


def _likely(words: Words) -> Datum:
    """A formula that holds more often than not."""
    roll = words.rng.random()
    if roll < 0.45:
        return (
            words.pick(("p", "b", "g")),
            words.pick(SYMBOLS),
            words.pick(words.free),
        )
    return words.formula() if roll < 0.7 else ("not", words.formula(1))


def _resources(words: Words) -> list[Datum]:
    if not words.chance(0.45):
        return []
    made: list[Datum] = []
    if words.chance(0.7):
        first = words.pick(((), (), ("3",), ("1",), (words.number(),)))
        made.append(("counter", "?c", *first))
        words.counters.append("?c")
    if words.chance(0.5):
        first = words.pick(((), (), (), (), (words.ground(),)))
        made.append(("set", "?s", *first))
        words.sets.append("?s")
    return [("resources", *made)] if made else []


def _monitors(words: Words, share: float) -> list[Datum]:
    made: list[Datum] = []
    if words.chance(0.25 * share):
        made.append(("monitor-state", words.watched()))
    if words.chance(0.18 * share):
        reference = words.pick(("now", "now", "absolute"))
        stop = words.time(20)
        made.append(("monitor-time", reference, words.time(), stop))
    return made


def _succeed(words: Words, sketch: Sketch) -> list[Datum]:
    if not words.chance(0.4):
        return []
    if words.chance(0.15):
        return [("succeed", "nil")]
    if sketch.outputs and words.chance(0.6):
        wanted = ("p", words.item(), sketch.outputs[0])
        return [("succeed", ("and", wanted, words.formula(1)))]
    return [("succeed", words.formula())]


def _method(
    words: Words, sketches: Sequence[Sketch], at: int, names: list[str]
) -> Datum:
    rng = words.rng
    name = names.pop(0) if names and words.chance(0.7) else ""
    own = Words(rng, words.known)
    own.sets, own.counters, own.methods = words.sets, words.counters, words.methods
    clauses: list[Datum] = []
    if words.chance(0.8 if sketches[at].outputs else 0.4):
        context = _context(own, sketches[at])
        clauses.append(("context", context))
    if words.chance(0.25):
        clauses.append(("notations", *(_note(own) for _ in range(rng.choice((1, 2))))))
    if words.chance(0.4 if at < len(sketches) - 1 else 0.8):
        clauses.append(("primitive", _request(own)))
    else:
        clauses.append(_task_net(own, sketches, at))
    return ("method", *((name,) if name else ()), *clauses)


def _context(words: Words, sketch: Sketch) -> Datum:
    if words.chance(0.8 if sketch.outputs else 0.4):
        variable = words.pick((*words.free, *sketch.outputs * 3))
        words.known = [*words.known, variable]
        item = words.pick((*SYMBOLS, *SYMBOLS, words.item()))
        bind = words.pick(
            (("p", item, variable), ("p", item, variable), ("q", variable))
        )
        return ("and", bind, words.formula(1)) if words.chance(0.3) else bind
    return _likely(words)


def _note(words: Words) -> Datum:
    name = words.pick((*PROPERTIES, *PROPOSITIONS))
    if name in PROPOSITIONS:
        return (name, *(words.ground() for _ in range(PROPOSITIONS[name])))
    index = tuple(words.ground() for _ in range(PROPERTIES[name]))
    return (
        (name, *index)
        if index and words.chance(0.15)
        else (name, *index, words.ground())
    )


def _request(words: Words) -> Datum:
    name = words.pick(("act", "act", "act", "pair", "rest", "slow"))
    return (name, *(words.ground() for _ in range(PRIMITIVES[name][0])))


# --- task-nets ------------------------------------------------------------------------


def _task_net(words: Words, sketches: Sequence[Sketch], at: int) -> Datum:
    rng = words.rng
    count = rng.choice((0, 1, 1, 2, 2, 3, 3, 4))
    tags = [f"t{n}" for n in range(1, count + 1)]
    order = list(tags)
    rng.shuffle(order)
    if words.chance(0.7):
        order = list(tags)
    notes: dict[str, list[Datum]] = {tag: [] for tag in tags}
    known = list(words.known)
    goals: dict[str, Datum] = {}
    for tag in order:
        own = Words(rng, known)
        own.sets, own.counters = words.sets, words.counters
        goals[tag] = _goal(own, sketches, at, known)
        _annotate(own, tag, order, notes)
    steps = [(tag, *_priority(words), goals[tag], *notes[tag]) for tag in tags]
    return ("task-net", *steps)


def _priority(words: Words) -> tuple[str, ...]:
    return (words.pick(("1", "2", "-1", "0")),) if words.chance(0.2) else ()


def _goal(words: Words, sketches: Sequence[Sketch], at: int, known: list[str]) -> Datum:
    below = sketches[at + 1 :]
    sketch = words.pick(below if below and words.chance(0.9) else sketches)
    inputs = [_argument(words) for _ in sketch.inputs]
    goal: tuple[Any, ...] = (sketch.name, *inputs)
    if sketch.outputs:
        outs = [
            words.pick((*words.free, *words.free, "?", "a")) for _ in sketch.outputs
        ]
        goal = (*goal, "=>", *outs)
        known += [out for out in outs if out.startswith("?") and out != "?"]
    return goal


def _argument(words: Words) -> Datum:
    resources = (*words.sets, *words.counters)
    if resources and words.chance(0.25):
        return words.pick(resources)
    return words.ground()


def _annotate(
    words: Words, tag: str, order: Sequence[str], notes: dict[str, list[Datum]]
) -> None:
    rng = words.rng
    place = order.index(tag)
    later = list(order[place + 1 :])
    earlier = list(order[:place])
    others = [other for other in order if other != tag]
    if later and words.chance(0.65):
        target = later[0] if words.chance(0.6) else words.pick(later)
        formula = (_likely(words),) if words.chance(0.4) else ()
        notes[tag].append((*formula, "for", target))
    if others and words.chance(0.18):
        notes[tag].append(
            (words.pick(("until-end", "until-start")), words.pick(others))
        )
    if words.chance(0.2):
        reference = words.pick(("now", "now", "absolute", *earlier))
        notes[tag].append(("window", reference, words.time(6), words.time(15)))
    if words.chance(0.18):
        notes[tag].append(_wait(words))
    if words.chance(0.6 if words.sets or words.counters else 0.05):
        notes[tag].append(_effect(words))
    rng.shuffle(notes[tag])


def _wait(words: Words) -> Datum:
    name = words.pick(list(SIGNALS))
    args = tuple(words.pick((words.item(), *words.free)) for _ in range(SIGNALS[name]))
    mode = words.pick(((), (":proceed",), (":succeed",), (":fail",)))
    return ("wait-for", (name, *args), *mode)


def _effect(words: Words) -> Datum:
    ops = ["set-add", "set-sub"] * bool(words.sets)
    ops += ["counter-add", "counter-sub"] * bool(words.counters)
    op = words.pick(ops or ["set-add", "counter-add"])
    right = words.sets if op.startswith("set") else words.counters
    resource = words.pick((*words.sets, *words.counters, *words.known, "a"))
    if right and words.chance(0.95):
        resource = words.pick(right)
    amount = words.ground() if op.startswith("set") else words.pick(NUMBERS)
    amount = words.number() if words.chance(0.15) else amount
    return (op, resource, amount)


# --- the world and the tasks --------------------------------------------------------------


def _text(datum: Datum) -> str:
    if isinstance(datum, str):
        return datum
    return f"({' '.join(_text(part) for part in datum)})"


def _fact(rng: random.Random, variables: Sequence[str] = ()) -> Datum:
    name = rng.choice(("p", "p", "p", *PROPERTIES, *PROPOSITIONS))
    items = (*SYMBOLS, *SYMBOLS, *variables)
    if name in PROPOSITIONS:
        return (name, *(rng.choice(items) for _ in range(PROPOSITIONS[name])))
    index = tuple(rng.choice(items) for _ in range(PROPERTIES[name]))
    return (name, *index, rng.choice((*VALUES, *VALUES, *WILD, *NUMBERS, *variables)))


def _ground(datum: Datum) -> Fact:
    """A fact, prefix or signal as the script has it."""
    return tuple(read_atom(part) for part in datum)


def _changes(
    rng: random.Random, variables: Sequence[str] = ()
) -> dict[str, tuple[Fact, ...]]:
    found: dict[str, tuple[Fact, ...]] = {}
    if rng.random() < 0.6:
        count = rng.choice((1, 1, 2))
        found["asserts"] = tuple(_ground(_fact(rng, variables)) for _ in range(count))
    if rng.random() < 0.25:
        prefix = _fact(rng, variables)
        found["erases"] = (_ground(prefix[: rng.randrange(1, len(prefix) + 1)]),)
    if rng.random() < 0.35:
        name = rng.choice(list(SIGNALS))
        args = [rng.choice((*SYMBOLS, *variables)) for _ in range(SIGNALS[name])]
        found["signals"] = (_ground((name, *args)),)
    return found


def _rows(rng: random.Random) -> list[Row]:
    made: list[Row] = []
    for name, (arity, results) in PRIMITIVES.items():
        for _ in range(rng.randrange(4)):
            pattern = [rng.choice(("?x", "?y", "?", *SYMBOLS)) for _ in range(arity)]
            variables = sorted({p for p in pattern if p in ("?x", "?y")})
            made.append(_row(rng, (name, *pattern), results, variables))
        made.append(_row(rng, (name, *("?" for _ in range(arity))), results, (), True))
    return made


def _row(
    rng: random.Random,
    pattern: Fact,
    results: Sequence[str],
    variables: Sequence[str],
    last: bool = False,
) -> Row:
    changes = _changes(rng, variables)
    if rng.random() < 0.1:
        seen = [rng.choice((*SYMBOLS, *variables)) for _ in range(2)]
        changes["data"] = (("seen", *seen),)
    slow = rng.random() < (0.8 if pattern[0] == "slow" else 0.05)
    return Row(
        pattern,
        rng.choice((*results, *["okay"] * 6)),
        times=None if last else rng.choice((1, 1, 2, None)),
        takes=rng.choice((0, 0, 1, 2, 5, 2.5)),
        after=rng.choice((0, 1, 3, 7)) if slow else None,
        **changes,
    )


def _at(rng: random.Random) -> At:
    time = rng.choice((0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 25, 2.5))
    return At(time, **_changes(rng))


def _solvers(
    rng: random.Random, sketches: Sequence[Sketch]
) -> tuple[tuple[str, Datum], ...]:
    found = []
    for at, sketch in enumerate(sketches):
        if rng.random() < 0.1:
            words = Words(rng, sketch.inputs)
            methods = [_mild_method(words, sketches, at)]
            names = ["late", "one"]
            methods += [_method(words, sketches, at, names) for _ in range(2)]
            rng.shuffle(methods)
            found.append((sketch.name, tuple(methods[: rng.randrange(4)])))
    return tuple(found)


def _host(rng: random.Random, sketches: Sequence[Sketch]) -> tuple[float, str, str]:
    kind = rng.choice(("assert", "erase", "signal", "cancel", "submit"))
    time = rng.choice((0, 1, 2, 3, 5, 8, 13))
    if kind == "submit":
        return time, kind, _task(rng, sketches)
    if kind == "cancel":
        sketch = rng.choice(sketches[:2])
        args = (rng.choice(("?", "?x", *SYMBOLS)) for _ in sketch.inputs)
        return time, kind, _text((sketch.name, *args))
    if kind == "signal":
        name = rng.choice(list(SIGNALS))
        args = (rng.choice(SYMBOLS) for _ in range(SIGNALS[name]))
        return time, kind, _text((name, *args))
    fact = _fact(rng)
    return time, kind, _text(fact if kind == "assert" else fact[:2])


def _task(rng: random.Random, sketches: Sequence[Sketch]) -> str:
    sketch = rng.choice((*[sketches[0]] * 4, *sketches))
    args = [rng.choice((*SYMBOLS, *SYMBOLS, *VALUES)) for _ in sketch.inputs]
    words = [_text((sketch.name, *args))]
    if rng.random() < 0.3:
        words.append(f":priority {rng.choice((1, 2, 3, -1))}")
    if rng.random() < 0.3:
        words.append(f":deadline {rng.randrange(1, 30)}")
    if rng.random() < 0.2:
        words.append(f":at {rng.randrange(0, 12)}")
    if rng.random() < 0.1:
        words.append(":background true")
    return " ".join(words)
