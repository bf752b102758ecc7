"""Definitions as people write them: trees as documents, documents as lines.

A list that does not fit on its line is broken between its operands: a definition, a
method and what holds rows of others go on below their first word, two columns to the
right of it; all else goes on behind the word, one operand below the other. An option
stays beside its value. What `_BROKEN` names is never on one line.
"""

from __future__ import annotations

from collections.abc import Sequence

from wadler_lindig import AbstractDoc, BreakDoc, NestDoc, TextDoc, join, pformat

from rapc.ir import nodes
from rapc.ir.printer import Tree, one_line, trees
from rapc.language.grammar import RULES
from rapc.language.heads import FORMS, heads, rules_by_head, words
from rapc.language.shapes import Shape, is_list, is_rule, leaves

WIDTH = 88
"""How many columns a line has."""


def laid_out(node: nodes.Node, width: int = WIDTH) -> str:
    """Any node as text of lines of a width, as far as its atoms let it."""
    return " ".join(lines(tree, width) for tree in trees(node))


def lines(tree: Tree, width: int = WIDTH) -> str:
    """A tree as text of lines of a width; strings keep the lines that they have."""
    used = set(one_line(tree))
    kept = next(chr(at) for at in _PRIVATE if chr(at) not in used)
    text: str = pformat(document(_without_lines(tree, kept)), width=width)
    return text.replace(kept, "\n")


_PRIVATE = range(0xE000, 0x10FFFF)
"""Characters one of which stands for the ends of lines within strings."""


def _without_lines(tree: Tree, kept: str) -> Tree:
    if isinstance(tree, str):
        return tree.replace("\n", kept)
    return tuple([_without_lines(one, kept) for one in tree])


def document(tree: Tree, after: str = "") -> AbstractDoc:
    """Return the document of a tree: what may be broken, and where it goes on then.

    Its atoms have no ends of lines in them. `after` is what stands behind it, such as
    the parentheses of the lists that end with it, and has to fit on its last line.
    """
    if isinstance(tree, str):
        return TextDoc(tree + after)
    word = tree[0] if tree and isinstance(tree[0], str) else ""
    operands = _together(tree[1:] if word else tree)
    beside, below = _beside(word, operands), word in _BELOW
    said: list[AbstractDoc] = [TextDoc(f"({word}")]
    column = first = len(word) + (2 if word else 1)
    last = len(operands) - 1
    for at, row in enumerate(operands):
        if at < beside or (at == 0 and not below):
            said.append(TextDoc(" " * bool(word or at)))
        else:
            column = 2 if below else first
            said.append(NestDoc(BreakDoc(" "), column))
        said.append(_side_by_side(row, column, f"){after}" if at == last else ""))
        column += sum(len(one_line(one)) + 1 for one in row)
    if not operands:
        said.append(TextDoc(f"){after}"))
    broken = word in _BROKEN and any(map(_holds_list, operands[beside:]))
    return join(TextDoc(""), said).group(force_vertical=broken)


def _together(operands: Sequence[Tree]) -> list[Sequence[Tree]]:
    """The operands of a list, each option with the value behind it."""
    found: list[Sequence[Tree]] = []
    at = 0
    while at < len(operands):
        here, behind = operands[at], operands[at + 1 : at + 2]
        alone = not _is_option(here) or not behind or _is_option(behind[0])
        found.append(operands[at : at + 1 if alone else at + 2])
        at += len(found[-1])
    return found


def _is_option(tree: Tree) -> bool:
    return isinstance(tree, str) and tree.startswith(":") and tree not in _ALONE


def _side_by_side(row: Sequence[Tree], column: int, after: str) -> AbstractDoc:
    """An operand that begins at a column of its list, or an option with its value."""
    if len(row) == 1:
        return document(row[0], after).nest(column)
    option, value = row
    word = f"{one_line(option)} "
    inner = document(value, after).nest(column + len(word))
    return TextDoc(word) + inner


def _beside(word: str, operands: Sequence[Sequence[Tree]]) -> int:
    """How many operands stay beside the word, or first list, that heads their list."""
    told = _BESIDE.get(word, 0) if word else 1
    behind = operands if word else operands[1:]
    atoms = next((at for at, row in enumerate(behind) if not _is_name(row)), 0)
    return max(told, atoms + (not word))


def _is_name(row: Sequence[Tree]) -> bool:
    """Whether an operand is an atom, and no string or option with its value."""
    return len(row) == 1 and isinstance(row[0], str) and row[0][0] != '"'


def _holds_list(row: Sequence[Tree]) -> bool:
    return not all(isinstance(one, str) for one in row)


def _has_rows(rule: str) -> bool:
    """Whether a list holds any number of lists of one kind."""
    last = RULES[rule][-1]
    inner = _entered(last) if last[0] in ("*", "+") else []
    return bool(inner) and all(is_list(RULES.get(one, "")) for one in inner)


def _entered(shape: Shape) -> list[str]:
    """The leaves of a shape and of the groups in it."""
    return [
        one
        for leaf in leaves(shape)
        for one in (_entered(RULES[leaf]) if _is_group(leaf) else [leaf])
    ]


def _is_group(leaf: str) -> bool:
    return is_rule(leaf) and RULES[leaf][0] == "or"


def _first_words(shape: Shape) -> set[str]:
    """The words of a shape behind which something stands that belongs to them."""
    if isinstance(shape, str):
        return set()
    inner = [word for part in shape[1:] for word in _first_words(part)]
    return {*inner, *(words(shape[1]) if shape[0] == "seq" else ())}


_ALONE = frozenset(
    word
    for shape in RULES.values()
    for word in set(words(shape)) - _first_words(shape)
    if word.startswith(":")
)
"""Words with a colon that have no value."""


_BELOW = frozenset(FORMS) | {
    word
    for rule in RULES
    if rule == "method" or (_has_rows(rule) and rule not in rules_by_head("formula"))
    for word in heads(rule)
}
"""The words whose operands stand below them, two columns to the right."""

_BROKEN = frozenset(
    (
        *("define-rap", "method", "task-net", "define-agenda"),
        *("define-test", "define-test-defaults", "script"),
        *("define-memory-rule", "define-event-rule", "match-result"),
    )
)
"""The words whose lists are never on one line, if they hold anything."""

_BESIDE = {
    **dict.fromkeys(FORMS, 1),
    **{word: 2 for word in FORMS if word.startswith("declare-")},
    "define-memory-rule": 2,
    "at": 1,
}
"""How many operands stay beside a word; atoms that lists come behind always do."""
