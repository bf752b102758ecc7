"""Random RAPs: every clause of sections 1 to 6 that does something at run time."""

from __future__ import annotations

import random
from collections.abc import Collection, Sequence
from typing import Any

from tests.reference.formulas import deep, formula, likely, watched
from tests.reference.nets import Sketch, task_net
from tests.reference.vocabulary import (
    METHODS,
    PRIMITIVES,
    PROPERTIES,
    PROPOSITIONS,
    QUERIES,
    SIGNALS,
    SKILLS,
    SYMBOLS,
    THINGS,
    USING,
)
from tests.reference.words import Datum, Words


def rap(
    rng: random.Random,
    wild: float,
    sketches: Sequence[Sketch],
    at: int,
    forms: Collection[str],
) -> Datum:
    """The RAP of a sketch; a mild one has a method that can always be chosen."""
    sketch = sketches[at]
    words = Words(rng, wild, sketch.inputs)
    words.forms = forms
    words.queries = tuple(QUERIES) if "queries" in forms else ()
    words.counters += [name for name in sketch.inputs if name == "?k"]
    mild = at == 0 or words.chance(1 - wild / 2)
    index: tuple[Any, ...] = (sketch.name, *sketch.inputs)
    if sketch.outputs:
        index = (*index, "=>", *sketch.outputs)
    clauses: list[Datum] = [("index", index), *_monitors(words, at), *_resources(words)]
    if words.chance(0.2):
        clauses.append(("duration", words.time()))
    if not mild or words.odd(0.3):
        clauses += _conditions(words)
    clauses += _succeed(words, sketch)
    names = [*METHODS, ""]
    for _ in range(words.pick((0, 1, 1)) if mild else words.pick((0, 1, 1, 2, 2, 3))):
        clauses.append(method(words, sketches, at, names))
    if mild:
        clauses.append(mild_method(words, sketches, at))
    return ("define-rap", *clauses)


def _resources(words: Words) -> list[Datum]:
    made: list[Datum] = []
    if words.chance(0.35):
        first = words.pick(((), (), ("3",), ("1",)))
        first = (words.number(),) if words.odd(0.2) else first
        if words.counters and words.chance(0.5):
            first = tuple(words.counters)
        made.append(("counter", "?c", *first))
        words.counters.append("?c")
    if words.chance(0.25):
        made.append(("set", "?s", *((words.ground(),) if words.odd(0.15) else ())))
        words.sets.append("?s")
    return [("resources", *made)] if made else []


def _monitors(words: Words, at: int) -> list[Datum]:
    made: list[Datum] = []
    share = 0.5 if words.counters else 0.2
    if words.chance(0.08 if at == 0 else share):
        made.append(("monitor-state", watched(words)))
    if words.chance(0.06 if at == 0 else 0.14):
        reference = words.pick(("now", "now", "absolute"))
        made.append(("monitor-time", reference, words.time(), words.time(20)))
    return made


def _conditions(words: Words) -> list[Datum]:
    made: list[Datum] = []
    for name, share in (("preconditions", 0.2), ("constraints", 0.25)):
        if words.chance(share):
            made.append((name, likely(words)))
    if words.chance(0.25):
        made.append(("repeat-while", likely(words)))
    return made


def _succeed(words: Words, sketch: Sketch) -> list[Datum]:
    if words.chance(0.65):
        return []
    if words.chance(0.3):
        return [("succeed", words.pick(("nil", ("q", words.item()))))]
    if sketch.outputs and words.chance(0.6):
        wanted = ("p", words.item(), sketch.outputs[0])
        return [("succeed", ("and", ("last-result", "okay"), wanted))]
    return [("succeed", formula(words))]


# --- methods ----------------------------------------------------------------------


def method(
    words: Words, sketches: Sequence[Sketch], at: int, names: list[str]
) -> Datum:
    """A method of any kind; takes one of the names, or none."""
    name = names.pop(0) if names and words.chance(0.7) else ""
    own = words.inner()
    clauses: list[Datum] = []
    if words.chance(0.8 if sketches[at].outputs else 0.4):
        clauses.append(("context", _context(own, sketches[at])))
    if words.among("otherwise", 0.25):
        clauses = [("context", _otherwise(own, clauses))]
    if words.among("claims", 0.3):
        clauses.append(("claims", *(_thing(own) for _ in range(own.pick((1, 1, 2))))))
    if words.chance(0.25):
        clauses.append(("notations", *(_note(own) for _ in range(own.pick((1, 2))))))
    if words.among("skills", 0.3):
        clauses.append(("primitive", *skilled(own)))
    elif words.chance(0.4 if at < len(sketches) - 1 else 0.8):
        clauses.append(("primitive", _request(own)))
    else:
        if words.among("constraints", 0.25):
            clauses.append(("constraints", likely(own)))
        if words.among("skills", 0.6):
            clauses.append(("skills", *_skills(own)))
        clauses.append(task_net(own, sketches, at))
    return ("method", *((name,) if name else ()), *clauses)


def mild_method(words: Words, sketches: Sequence[Sketch], at: int) -> Datum:
    """A method that can always be chosen, and whose request is in order."""
    sketch, own = sketches[at], words.inner(sketches[at].inputs)
    clauses: list[Datum] = []
    if sketch.outputs:
        wanted = ("p", words.pick((*SYMBOLS, *sketch.inputs * 3)), sketch.outputs[0])
        clauses.append(("context", wanted))
    elif words.among("deep", 0.3):
        clauses.append(("context", ("or", deep(own), "true")))
    elif words.among("claims", 0.4):
        shared = words.pick((("q", "?d"), ("p", "?d", "?"), ("r", "?", "?d")))
        clauses.append(("context", ("or", shared, ("is", "?d", "a"))))
        clauses.append(("claims", (words.pick(("arm", "arm", "way")), "?d")))
        if clauses[-1][1][0] == "way":
            clauses[-1] = ("claims", ("way", "a", "?d"))
    if not any(one[0] == "claims" for one in clauses) and words.among("claims", 0.25):
        clauses.append(("claims", *(_thing(own) for _ in range(own.pick((1, 1, 2))))))
    if at < len(sketches) - 1 and words.chance(0.95 if at == 0 else 0.6):
        if words.among("skills", 0.6):
            clauses.append(("skills", *_skills(own)))
        return ("method", *clauses, task_net(own, sketches, at))
    if words.among("skills", 0.5):
        return ("method", *clauses, ("primitive", *skilled(own)))
    name = words.pick(("act", "act", "rest", "slow", "slow"))
    if words.among("claims", 0.9):
        name = words.pick(tuple(USING))
    items = ("a", "a", "c") if name in USING else (*SYMBOLS, *sketch.inputs)
    args = (words.pick(items) for _ in range(_arity(name)))
    return ("method", *clauses, ("primitive", (name, *args)))


def _context(words: Words, sketch: Sketch) -> Datum:
    if words.among("deep", 0.3):
        return deep(words)
    if words.chance(0.2):
        return likely(words)
    variable = words.pick((*words.free, *sketch.outputs * 3))
    words.known = [*words.known, variable]
    item = words.item() if words.odd(0.4) else words.pick(SYMBOLS)
    bind = words.pick((("p", item, variable), ("p", item, variable), ("q", variable)))
    return ("and", bind, formula(words, 1)) if words.chance(0.3) else bind


def _note(words: Words) -> Datum:
    name = words.pick((*PROPERTIES, *PROPOSITIONS))
    if name in PROPOSITIONS:
        return (name, *(words.ground() for _ in range(PROPOSITIONS[name])))
    index = tuple(words.ground() for _ in range(PROPERTIES[name]))
    short = index and words.chance(0.15)
    return (name, *index) if short else (name, *index, words.ground())


def _request(words: Words) -> Datum:
    name = words.pick(("act", "act", "act", "pair", "rest", "slow"))
    if words.among("claims", 0.85):
        name = words.pick(tuple(USING))
    few = name in USING and words.chance(0.7)
    return (name, *("a" if few else words.ground() for _ in range(_arity(name))))


def _skills(words: Words) -> list[Datum]:
    """Skills to be switched on; some use one thing."""
    made = []
    for name in words.rng.sample(list(SKILLS), words.pick((1, 1, 2, 3))):
        few = words.chance(0.85)
        args = ("a" if few else words.ground() for _ in range(SKILLS[name]))
        made.append((name, *args))
    return made


def skilled(words: Words) -> list[Datum]:
    """A primitive of skills: what it enables, and what it awaits."""
    made: list[Datum] = [("enable", *_skills(words))]
    for _ in range(words.pick((0, 1, 1, 2, 2))):
        name = words.pick(list(SIGNALS))
        args = (words.pick((words.item(), *words.free)) for _ in range(SIGNALS[name]))
        mode = words.pick((":succeed", ":succeed", ":fail"))
        made.append(("wait-for", (name, *args), mode))
    words.rng.shuffle(made)
    return made


# --- rules over memory --------------------------------------------------------------


def rules(rng: random.Random, wild: float, sketches: Sequence[Sketch]) -> list[Datum]:
    """Rules for ends of tasks and for signals."""
    made: list[Datum] = []
    for _ in range(rng.randrange(5)):
        sketch, words = rng.choice(sketches), Words(rng, wild, ())
        words.known = list(dict.fromkeys(rng.choice(("?i", "?j", "?z")) for _ in "ab"))
        inputs = [rng.choice((*words.known, *SYMBOLS, "?")) for _ in sketch.inputs]
        index: tuple[Any, ...] = (sketch.name, *inputs)
        if sketch.outputs:
            outputs = [rng.choice((*words.known, "?", "a")) for _ in sketch.outputs]
            index = (*index, "=>", *outputs)
        words.known = [w for w in words.known if w in index] or ["?none"]
        when = rng.choice((":finish", ":event"))
        cases = [_case(words, when) for _ in range(rng.choice((1, 2, 3)))]
        made.append(("define-memory-rule", index, when, ("match-result", *cases)))
    for _ in range(rng.randrange(3)):
        words = Words(rng, wild, ())
        made.append(("define-event-rule", _signal(words), *_rules(words)))
    return made


def _case(words: Words, when: str) -> Datum:
    own = words.inner()
    result = own.pick(("succeed", "succeed", "bad", "go", "interference", "?why"))
    if when == ":event":
        result = "?why" if own.chance(0.2) else _signal(own)
    if result == "?why":
        own.known = [*own.known, "?why"]
    return (result, *_rules(own))


def _signal(words: Words) -> Datum:
    """A signal as rules match it; what it carries is known from there on."""
    name = words.pick(list(SIGNALS))
    args = [words.pick(("?z", "?z", "?", "a")) for _ in range(SIGNALS[name])]
    words.known = [*words.known, *(arg for arg in args if arg == "?z")]
    return (name, *args)


def _rules(words: Words) -> list[Datum]:
    """Rules, each of one or two queries with what they do."""
    return [
        (
            "rule",
            *(
                (likely(words), *(_action(words) for _ in range(words.pick((1, 2)))))
                for _ in range(words.pick((1, 1, 2)))
            ),
        )
        for _ in range(words.pick((1, 1, 2)))
    ]


def _action(words: Words) -> Datum:
    fact = _note(words)
    if words.chance(0.25):
        return ("mem-del", fact[: words.pick(range(1, len(fact) + 1))])
    return ("mem-add", fact)


def _arity(primitive: str) -> int:
    return {**PRIMITIVES, **USING}[primitive][0]


def _otherwise(words: Words, clauses: Sequence[Datum]) -> Datum:
    """`otherwise`, alone or beside what a context asks besides."""
    if not clauses:
        return "otherwise"
    context = clauses[0][1]
    return words.pick((("and", "otherwise", context), ("and", context, "otherwise")))


def _thing(words: Words) -> Datum:
    name = words.pick(tuple(THINGS))
    few = words.chance(0.7)
    args = tuple("a" if few else words.ground() for _ in range(THINGS[name]))
    return (name, *args) if args else name
