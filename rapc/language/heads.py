"""The words that begin the lists of the language, and how its rules are written."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache

from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.shapes import Shape, is_list, is_rule, is_word, leaves


def words_of_shape(shape: Shape) -> tuple[str, ...]:
    """The words in a shape, without their quotes; rules are not entered."""
    return tuple([leaf[1:-1] for leaf in leaves(shape) if is_word(leaf)])


def heads(rule: str) -> tuple[str, ...]:
    """The words that a rule may begin with; of a list, the words it is headed by.

    Rules that are headed by a name have none, and so have the alternatives of a group
    that are.
    """
    return _heads(RULES[rule])


def _heads(shape: Shape) -> tuple[str, ...]:
    if is_word(shape):
        return words_of_shape(shape)
    if isinstance(shape, str):
        return _heads(RULES[shape]) if is_rule(shape) else ()
    if shape[0] in ("list", "seq"):
        first = shape[1]
        named = first[0] == "or" and any(map(is_word, first[1:]))
        return words_of_shape(first) if is_word(first) or named else ()
    if shape[0] == "or":
        return tuple(dict.fromkeys(h for part in shape[1:] for h in _heads(part)))
    return _heads(shape[1])


@cache
def rules_by_head(group: str) -> Mapping[str, str]:
    """The rules that stand in a rule by the words that head them, groups entered."""
    found: dict[str, str] = {}
    for rule in filter(is_rule, leaves(RULES[group])):
        if rule[0] == "_":
            found |= rules_by_head(rule)
        else:
            found |= dict.fromkeys(heads(rule), rule)
    return found


@cache
def often(rule: str) -> frozenset[str]:
    """The words of what may stand more than once in a list of a rule."""
    return frozenset(_often(RULES[rule], repeated=False))


def _often(shape: Shape, *, repeated: bool) -> Iterator[str]:
    if isinstance(shape, tuple):
        inner = repeated or shape[0] in ("*", "+")
        for part in shape[1:]:
            yield from _often(part, repeated=inner)
    elif shape[0] == "_" and not shape.startswith("_once"):
        yield from _often(RULES[shape], repeated=repeated)
    elif repeated and is_rule(shape) and shape[0] != "_":
        yield from heads(shape)


def rule_named(node: str) -> str:
    """The rule that a class of nodes is named after: `last_result` of `LastResult`."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", node).lower()


def spelling(rule: str) -> str:
    """Return how a list is written, as in `(believe (fact) term)`."""
    return _spelt(RULES[rule])


def _spelt(shape: Shape) -> str:
    if isinstance(shape, tuple):
        texts = [_spelt(part) for part in shape[1:]]
        if shape[0] == "or":
            texts = list(dict.fromkeys(texts))
        return _JOINED[shape[0]].format("|".join(texts), " ".join(texts))
    if is_word(shape):
        return shape[1:-1]
    name = shape.replace("_", "-").lower()
    return (GRAMMAR[shape].short if is_rule(shape) else "") or name


_JOINED: Mapping[Shape, str] = {
    "list": "({1})",
    "seq": "{1}",
    "or": "{0}",
    "?": "[{0}]",
    "*": "{0}...",
    "+": "{0}...",
}
"""How parts are written together: as alternatives, or one behind the other."""


FORMS = heads("_form")
"""What may stand at the top level."""

RAP_CLAUSES = tuple(rules_by_head("define_rap"))
"""The clauses of a `define-rap`."""

METHOD_CLAUSES = tuple(rules_by_head("method"))
"""The clauses of a method."""

TEST_CLAUSES = heads("_test_clause")
"""The clauses of a `define-test`."""

ANNOTATIONS = heads("annotation")
"""What may head an annotation of a step."""

CALLS = heads("call")
"""Functions that compute a term; others are declared."""

TRUTHS = {"t": True, "true": True, "nil": False, "false": False}
"""The constants that are formulas."""

ALONE = {
    word: rule
    for word, rule in rules_by_head("formula").items()
    if not is_list(RULES[rule])
}
"""The words that are formulas by themselves, with their rules."""

QUERIES = tuple([word for word in heads("formula") if word not in ALONE])
"""Words that head a formula and are no propositions."""

SLIPS = {slip: heads(rule)[0] for rule, row in GRAMMAR.items() for slip in row.slips}
"""Words that print has had, with those that are meant."""

ARROW = "=>"
"""The symbol between the inputs and the outputs of an index or a goal."""
