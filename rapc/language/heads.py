"""The first words of the lists of the language, and the notation of its rules."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache

from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.shapes import Shape, is_list, is_rule, is_word, leaves


def words_of_shape(shape: Shape) -> tuple[str, ...]:
    """Return the words in a shape, without their quotes; rules are not entered."""
    return tuple([leaf[1:-1] for leaf in leaves(shape) if is_word(leaf)])


def heads(rule: str) -> tuple[str, ...]:
    """Return the possible first words of a rule; for a list, of the list.

    Rules that begin with a name have none. In a group, alternatives that begin with a
    name add none.
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
    """Return the rules within a rule by their first words; groups are entered."""
    found: dict[str, str] = {}
    for rule in filter(is_rule, leaves(RULES[group])):
        if rule[0] == "_":
            found |= rules_by_head(rule)
        else:
            found |= dict.fromkeys(heads(rule), rule)
    return found


@cache
def often(rule: str) -> frozenset[str]:
    """Return the first words of the parts that may occur repeatedly in a rule."""
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
    """Return the rule of a class of nodes: `last_result` for `LastResult`."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", node).lower()


def spelling(rule: str) -> str:
    """Return the notation of a rule, for example `(believe (fact) term)`."""
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
"""The notation of parts: {0} joins alternatives, {1} joins a sequence."""


FORMS = heads("_form")
"""The first words of top-level forms."""

RAP_CLAUSES = tuple(rules_by_head("define_rap"))
"""The clauses of a `define-rap`."""

METHOD_CLAUSES = tuple(rules_by_head("method"))
"""The clauses of a method."""

TEST_CLAUSES = heads("_test_clause")
"""The clauses of a `define-test`."""

ANNOTATIONS = heads("annotation")
"""The first words of the annotations of a step."""

CALLS = heads("call")
"""The built-in functions of computed terms."""

TRUTHS = {"t": True, "true": True, "nil": False, "false": False}
"""The constants that are formulas."""

ALONE = {
    word: rule
    for word, rule in rules_by_head("formula").items()
    if not is_list(RULES[rule])
}
"""The words that are formulas by themselves, with their rules."""

QUERIES = tuple([word for word in heads("formula") if word not in ALONE])
"""The first words of formulas that are not propositions."""

SLIPS = {slip: heads(rule)[0] for rule, row in GRAMMAR.items() for slip in row.slips}
"""Words of printed programs in place of a first word, with that first word."""

ARROW = "=>"
"""The symbol between the inputs and the outputs of an index or a goal."""
