"""Random formulas."""

from __future__ import annotations

import random
from collections.abc import Collection, Sequence

from tests.reference.vocabulary import (
    METHODS,
    NUMBERS,
    PROPERTIES,
    PROPOSITIONS,
    QUERIES,
    RESULTS,
    SYMBOLS,
    VALUES,
)
from tests.reference.words import Datum, Words


def formula(words: Words, depth: int = 2) -> Datum:
    """A formula, nested at most so deep."""
    if words.among("deep", 0.15):
        return deep(words)
    if words.queries and words.chance(0.25):
        return named(words)
    roll = words.rng.random()
    if depth > 0 and roll < 0.46:
        return _compound(words, depth - 1, roll)
    if roll < 0.56:
        return _compare(words)
    if roll < 0.64:
        age = words.pick((*NUMBERS, *NUMBERS, "?u", "?w", "?", words.number()))
        return ("believe", pattern(words), age)
    return _odd(words) if roll < 0.72 else pattern(words)


def named(words: Words) -> Datum:
    """A named query, with whatever may stand for its arguments."""
    name = words.pick(words.queries)
    resources = (*words.sets, *words.counters)
    terms = []
    for _ in range(QUERIES[name]):
        kind = words.rng.randrange(6)
        if kind == 0 and resources:
            terms.append(words.pick(resources))
        elif kind == 1:
            terms.append(words.ground())
        else:
            terms.append(words.item() if kind < 5 else words.number())
    return (name, *terms)


def query(
    rng: random.Random,
    wild: float,
    name: str,
    below: Sequence[str],
    forms: Collection[str],
) -> Datum:
    """The definition of a named query, which may use those below it."""
    args = ["?i", "?x"][: QUERIES[name]]
    if args and rng.random() < 0.3:
        args[0] = "?u"
    words = Words(rng, wild, args)
    words.queries, words.forms = below, forms
    if name == "wide" and "deep" in forms:
        return ("define-query", (name, *args), wide(words))
    if args and rng.random() < 0.5:
        words.sets, words.counters = [args[-1]], [args[-1]]
    made = words.pick((formula, likely, watched))(words)
    return ("define-query", (name, *args), made)


def deep(words: Words, depth: int = 2, count: int | None = None) -> Datum:
    """A conjunction of parts most of which may have several solutions."""
    words = words.inner()
    words.free = [*words.free, "?d", "?e", "?f"]
    least = words.pick((2, 3, 4, 5, 6)) if count is None else count
    parts = [_deep_part(words, depth) for _ in range(least)]
    if words.chance(0.6):
        parts.append(words.pick(("nil", ("q", "nowhere"), ("=", "1", "2"))))
    return ("and", *parts)


def wide(words: Words) -> Datum:
    """A formula of more parts than are written where a query is used."""
    return ("or", *(deep(words, 1, 5) for _ in range(words.pick((3, 4, 6)))))


def _deep_part(words: Words, depth: int) -> Datum:
    roll = words.rng.random()
    if depth > 0 and roll < 0.25:
        few = words.pick((0, 1, 2, 2, 3))
        return ("or", *(_deep_part(words, depth - 1) for _ in range(few)))
    if depth > 0 and roll < 0.35:
        return ("not", deep(words, depth - 1))
    if words.queries and roll < 0.47:
        return named(words)
    variable, other = words.pick((*words.free, "?")), words.pick((*words.free, "?"))
    if roll < 0.55:
        return words.pick((("=", variable, "a"), ("n=", variable, other)))
    if roll < 0.6:
        return words.pick((("know-sensor-name", variable), ("last-result", variable)))
    found = words.pick(
        (
            ("q", variable),
            ("r", variable, words.pick((other, *SYMBOLS))),
            ("p", variable, words.pick((other, "?"))),
            ("p", words.pick(SYMBOLS), variable),
            ("k", variable, words.pick((other, "a")), "?"),
        )
    )
    return ("believe", found, words.pick(("9", "?w"))) if roll < 0.7 else found


def _compound(words: Words, depth: int, roll: float) -> Datum:
    if roll < 0.13:
        return ("not", formula(words, depth))
    word = "or" if roll < 0.21 else "and"
    count = words.rng.randrange(1, 4)
    return (word, *(formula(words, depth) for _ in range(count)))


def likely(words: Words) -> Datum:
    """A formula that holds more often than not."""
    if words.among("deep", 0.2):
        return deep(words)
    if words.queries and words.chance(0.2):
        return named(words)
    if words.chance(1 - words.wild * 0.5):
        name = words.pick(("p", "b", "g"))
        return (name, words.pick(SYMBOLS), words.pick(words.free))
    return formula(words) if words.chance(0.4) else ("not", formula(words, 1))


def watched(words: Words) -> Datum:
    """A formula that what the script does makes true and false."""
    if words.among("deep", 0.2):
        return deep(words)
    if words.odd(0.3):
        return formula(words)
    if words.queries and words.chance(0.3):
        return named(words)
    if words.chance(0.7 if words.counters else 0.1):
        return _about_resources(words)
    name = words.pick(("p", "p", "q", "q", "b", "mode"))
    item = words.pick((*SYMBOLS, *words.known, "?u"))
    fact: Datum = (name, item)
    if name == "mode":
        fact = (name, words.pick((*VALUES, "?v", *["unknown"] * 4)))
    elif name != "q":
        default = "unknown" if name == "p" else "false"
        fact = (name, item, words.pick((*VALUES, "?v", *[default] * 4)))
    if words.chance(0.15):
        return ("and", ("believe", fact, "?w"), (">", "?w", words.pick(NUMBERS)))
    if words.chance(0.4):
        fact = ("believe", fact, words.pick((*NUMBERS, *NUMBERS, "?w")))
    return ("not", fact) if words.chance(0.4) else fact


def _about_resources(words: Words) -> Datum:
    """A test of a set or counter, often one passed as an input."""
    resources = (*words.counters * 4, *words.sets, *words.known, "a")
    resource = words.pick(resources)
    if resource in words.sets or words.chance(0.3):
        return words.pick((("empty", resource), ("member", resource, words.ground())))
    sign = words.pick((">", "<", "="))
    return (sign, ("value", resource), words.pick(NUMBERS))


def pattern(words: Words) -> Datum:
    """A proposition or property, at times without its value."""
    if words.chance(0.3):
        name = words.pick(list(PROPOSITIONS))
        return (name, *(words.item() for _ in range(PROPOSITIONS[name])))
    name = words.pick(("p", "p", "p", *PROPERTIES))
    index = tuple(words.item() for _ in range(PROPERTIES[name]))
    short = index and words.chance(0.1)
    return (name, *index) if short else (name, *index, words.value())


def _compare(words: Words) -> Datum:
    if words.chance(0.2):
        return (
            "is",
            words.pick((*words.free, *words.known, "?u")),
            words.pick((words.ground(), words.number())),
        )
    if words.chance(0.5):
        return (words.pick(("=", "n=")), words.ground(), words.ground())
    return (words.pick(("<", ">", "<=", ">=")), words.number(), words.number())


def _odd(words: Words) -> Datum:
    """What is asked more rarely."""
    kind = words.rng.randrange(7)
    if kind < 2 and words.sets:
        chosen = words.pick(words.sets)
        return ("empty", chosen) if kind else ("member", chosen, words.ground())
    if kind == 2:
        result = words.pick((*RESULTS, "?v"))
        return ("result-with-method", words.pick(METHODS), result)
    if kind == 3:
        return ("method-tried", words.pick(METHODS))
    if kind == 4:
        return ("odd", words.number())
    if kind == 5:
        value = words.pick(((), ("true",), ("false",)))
        return ("know-sensor-name", words.item(), *value)
    last = ("last-result", words.pick((*RESULTS, "?u")))
    return words.pick((last, last, "true", "nil", "t", "false"))
