"""Random formulas."""

from __future__ import annotations

import random
from collections.abc import Sequence

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


def query(rng: random.Random, wild: float, name: str, below: Sequence[str]) -> Datum:
    """The definition of a named query, which may use those below it."""
    args = ["?i", "?x"][: QUERIES[name]]
    if args and rng.random() < 0.3:
        args[0] = "?u"
    words = Words(rng, wild, args)
    words.queries = below
    if args and rng.random() < 0.5:
        words.sets, words.counters = [args[-1]], [args[-1]]
    made = words.pick((formula, likely, watched))(words)
    return ("define-query", (name, *args), made)


def _compound(words: Words, depth: int, roll: float) -> Datum:
    if roll < 0.13:
        return ("not", formula(words, depth))
    word = "or" if roll < 0.21 else "and"
    count = words.rng.randrange(1, 4)
    return (word, *(formula(words, depth) for _ in range(count)))


def likely(words: Words) -> Datum:
    """A formula that holds more often than not."""
    if words.queries and words.chance(0.2):
        return named(words)
    if words.chance(1 - words.wild * 0.5):
        name = words.pick(("p", "b", "g"))
        return (name, words.pick(SYMBOLS), words.pick(words.free))
    return formula(words) if words.chance(0.4) else ("not", formula(words, 1))


def watched(words: Words) -> Datum:
    """A formula that what the script does makes true and false."""
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
