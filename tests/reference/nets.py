"""Random task-nets: steps with their annotations, in an order without cycles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from tests.reference.formulas import likely
from tests.reference.vocabulary import NUMBERS, SIGNALS, SYMBOLS
from tests.reference.words import Datum, Words


class Sketch:
    """A RAP before it is written: its name and its parameters."""

    def __init__(
        self, name: str, inputs: Sequence[str], outputs: Sequence[str]
    ) -> None:
        self.name = name
        self.inputs = list(inputs)
        self.outputs = list(outputs)


def task_net(words: Words, sketches: Sequence[Sketch], at: int) -> Datum:
    """A task-net of the RAP at a position; it asks mostly for RAPs further on."""
    count = words.pick((0, 1, 1, 2, 2, 2, 3, 3, 3, 4))
    tags = [f"t{n}" for n in range(1, count + 1)]
    order = list(tags)
    if words.odd(0.4):
        words.rng.shuffle(order)
    notes: dict[str, list[Datum]] = {tag: [] for tag in tags}
    known = list(words.known)
    chained = words.chance(0.5)
    goals: dict[str, Datum] = {}
    for tag in order:
        own = words.inner(known)
        goals[tag] = _goal(own, sketches, at, known)
        _annotate(own, tag, order, notes[tag], chained)
        known += _bound_by(words, notes[tag])
    steps = ((tag, *_priority(words), goals[tag], *notes[tag]) for tag in tags)
    return ("task-net", *steps)


def _bound_by(words: Words, notes: list[Datum]) -> list[str]:
    """The variables that the formulas of `for` annotations may bind."""
    formulas = [note[0] for note in notes if note[1] == "for"]
    return [f[-1] for f in formulas if f[-1] in words.free]


def _priority(words: Words) -> tuple[str, ...]:
    share = 0.5 if "claims" in words.forms else 0.2
    return (words.pick(("1", "2", "-1", "0")),) if words.chance(share) else ()


def _goal(words: Words, sketches: Sequence[Sketch], at: int, known: list[str]) -> Datum:
    below = sketches[at + 1 :]
    again = not below or words.chance(0.15)
    sketch = words.pick((*[sketches[at]] * 3, *sketches) if again else below)
    inputs = [_argument(words, name) for name in sketch.inputs]
    if again and words.chance(0.6):
        inputs = [words.pick(known or SYMBOLS) for _ in inputs]
    goal: tuple[Any, ...] = (sketch.name, *inputs)
    if sketch.outputs:
        wanted = (*words.free, *words.free, "?", "a")
        outs = [words.pick(wanted) for _ in sketch.outputs]
        goal = (*goal, "=>", *outs)
        known += [out for out in outs if out in words.free]
    return goal


def _argument(words: Words, name: str) -> Datum:
    if name == "?k" and words.counters and not words.odd(0.2):
        return words.pick(words.counters)
    resources = (*words.sets, *words.counters)
    return words.pick(resources) if resources and words.chance(0.3) else words.ground()


def _annotate(
    words: Words, tag: str, order: Sequence[str], notes: list[Datum], chained: bool
) -> None:
    place = order.index(tag)
    later = list(order[place + 1 :])
    others = [other for other in order if other != tag]
    if later and (chained or words.chance(0.5)):
        target = later[0] if chained or words.chance(0.5) else words.pick(later)
        formula = (likely(words),) if words.chance(0.35) else ()
        notes.append((*formula, "for", target))
    if others and words.chance(0.2):
        kind = words.pick(("until-end", "until-end", "until-start"))
        notes.append((kind, words.pick(others)))
    for _ in range(words.pick((0, 0, 0, 0, 0, 0, 1, 1, 2))):
        reference = words.pick(("now", "now", "absolute", *order[:place]))
        notes.append(("window", reference, words.time(6), words.time(15)))
    if words.chance(0.18):
        notes.append(_wait(words))
    for _ in range(words.pick((0, 1, 1, 2))):
        if words.sets or words.counters or words.odd(0.1):
            notes.append(_effect(words))
    words.rng.shuffle(notes)


def _wait(words: Words) -> Datum:
    name = words.pick(list(SIGNALS))
    item = words.computed() if words.odd(0.2) else words.item()
    args = tuple(words.pick((item, *words.free)) for _ in range(SIGNALS[name]))
    mode = words.pick(((), (":proceed",), (":succeed",), (":succeed",), (":fail",)))
    return ("wait-for", (name, *args), *mode)


def _effect(words: Words) -> Datum:
    ops = ["set-add", "set-sub"] * bool(words.sets)
    ops += ["counter-add", "counter-sub"] * bool(words.counters)
    op = words.pick(ops or ["set-add", "counter-add"])
    right = words.sets if op.startswith("set") else words.counters
    if not right or words.odd(0.1):
        right = [*words.sets, *words.counters, *words.known, "a"]
    amount = words.ground() if op.startswith("set") else words.pick(NUMBERS)
    return (op, words.pick(right), words.number() if words.odd(0.2) else amount)
