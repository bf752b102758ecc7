"""Layout of definitions: trees to documents, documents to lines.

A list that does not fit on its line is broken between its operands. In a definition, a
method and a list of lists the operands continue below the first word, indented by two
columns. In all other lists the operands are aligned after the word, one on each line.
An option stays on the line of its value. Lists in `_BROKEN` are never on one line.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import msgspec
from wadler_lindig import AbstractDoc, BreakDoc, NestDoc, TextDoc, join, pformat

from rapc.ir import nodes
from rapc.ir.printer import trees
from rapc.language.grammar import RULES
from rapc.language.heads import FORMS, heads, rules_by_head, words_of_shape
from rapc.language.shapes import Shape, is_list, is_rule, leaves

WIDTH = 88
"""The number of columns of a line."""


class Note(msgspec.Struct, frozen=True):
    """A comment among the operands of a list; without text, a blank line."""

    text: str
    #: Whether the comment follows an operand, on its line.
    beside: bool = False


Noted = str | Note | tuple["Noted", ...]
"""A tree with comments in it."""


def laid_out(node: nodes.Node, width: int = WIDTH) -> str:
    """Return a node as text; lines are within `width` if the atoms allow it."""
    return " ".join(lines(tree, width) for tree in trees(node))


def lines(tree: Noted, width: int = WIDTH) -> str:
    """Return a tree as text with lines within `width`; strings stay unchanged."""
    used = {letter for text in _texts(tree) for letter in text}
    kept = next(chr(at) for at in _PRIVATE if chr(at) not in used)
    text: str = pformat(document(_without_lines(tree, kept)), width=width)
    whole = "\n".join(line.rstrip(" ") for line in text.split("\n"))
    return whole.replace(kept, "\n")


def _texts(tree: Noted) -> Iterator[str]:
    stack = [tree]
    while stack:
        one = stack.pop()
        if isinstance(one, tuple):
            stack.extend(one)
        else:
            yield one if isinstance(one, str) else one.text


_PRIVATE = range(0xE000, 0x10FFFF)
"""Candidates for the character that replaces line ends within strings."""


def _without_lines(tree: Noted, kept: str) -> Noted:
    if isinstance(tree, str):
        return tree.replace("\n", kept)
    if isinstance(tree, Note):
        return Note(tree.text.replace("\n", kept), tree.beside)
    return tuple([_without_lines(one, kept) for one in tree])


def document(tree: Noted, after: str = "") -> AbstractDoc:
    """Return the document of a tree, with its possible line breaks and indentation.

    The atoms of the tree have no line ends. `after` is the text that follows the tree,
    for example closing parentheses, and must fit on its last line. A list with comments
    is never on one line.
    """
    if isinstance(tree, str):
        return TextDoc(tree + after)
    if isinstance(tree, Note):
        return TextDoc(tree.text, width=False)
    word = tree[0] if tree and isinstance(tree[0], str) else ""
    operands = _together(tree[1:] if word else tree)
    beside, below = _beside(word, operands), word in _BELOW - _FILLED
    first = len(word) + (2 if word else 1)
    broken_at = 2 if below else first
    said: list[AbstractDoc] = [TextDoc(f"({word}")]
    column = first
    noted = False
    for at, row in enumerate(operands):
        was, noted = noted, isinstance(row[0], Note)
        closed = f"){after}" if at == len(operands) - 1 and not noted else ""
        if isinstance(row[0], Note) and row[0].beside:
            said.append(TextDoc(f"  {row[0].text}", width=False))
        elif noted or was or (at >= beside and (at > 0 or below)):
            operand = _side_by_side(row, broken_at, closed)
            fresh = NestDoc(BreakDoc(" "), broken_at) + operand
            filled = not (noted or was) and _is_filled(word, row)
            said.append(fresh.group() if filled else fresh)
        else:
            said.append(TextDoc(" " * bool(word or at)))
            said.append(_side_by_side(row, column, closed))
            column += sum(_wide(one) + 1 for one in row)
    if noted:
        said.append(NestDoc(BreakDoc(""), broken_at))
    if noted or not operands:
        said.append(TextDoc(f"){after}"))
    lists = sum(map(_holds_list, operands[beside:]))
    broken = lists > (word in _JOINED) and word in _BROKEN | _JOINED
    return join(TextDoc(""), said).group(force_vertical=broken or _is_noted(tree))


def _is_filled(word: str, row: Sequence[Noted]) -> bool:
    """Return whether a list fills each line with as many operands as fit."""
    if word.startswith("declare-"):
        return len(row) == 1 and not str(row[0]).startswith('"')
    return not word or word in _FILLED


def _wide(tree: Noted) -> int:
    """Return the width of a tree on one line, without its comments."""
    if isinstance(tree, tuple):
        inner = [_wide(one) for one in tree if not isinstance(one, Note)]
        return sum(inner) + max(1, len(inner)) + 1
    return 0 if isinstance(tree, Note) else len(tree)


def _is_noted(tree: Noted) -> bool:
    """Return whether a tree has a comment."""
    stack = [tree]
    while stack:
        one = stack.pop()
        if isinstance(one, Note):
            return True
        if isinstance(one, tuple):
            stack.extend(one)
    return False


def _together(operands: Sequence[Noted]) -> list[Sequence[Noted]]:
    """Return the operands of a list, each option together with its value."""
    found: list[Sequence[Noted]] = []
    at = 0
    while at < len(operands):
        here, behind = operands[at], operands[at + 1 : at + 2]
        alone = not _is_option(here) or not behind or _is_option(behind[0])
        alone = alone or isinstance(behind[0], Note)
        found.append(operands[at : at + 1 if alone else at + 2])
        at += len(found[-1])
    return found


def _is_option(tree: Noted) -> bool:
    return isinstance(tree, str) and tree.startswith(":") and tree not in _ALONE


def _side_by_side(row: Sequence[Noted], column: int, after: str) -> AbstractDoc:
    """Return the document of an operand or an option with its value, at a column."""
    if len(row) == 1:
        return document(row[0], after).nest(column)
    option, value = row
    word = f"{option} "
    inner = document(value, after).nest(column + len(word))
    return TextDoc(word) + inner


def _beside(word: str, operands: Sequence[Sequence[Noted]]) -> int:
    """Return the number of operands on the line of the head of their list."""
    told = _BESIDE.get(word, 0) if word else 1
    behind = operands if word else operands[1:]
    atoms = next((at for at, row in enumerate(behind) if not _is_name(row)), 0)
    return max(told, atoms + (not word))


def _is_name(row: Sequence[Noted]) -> bool:
    """Return whether an operand is an atom, but no string and no option with value."""
    return len(row) == 1 and isinstance(row[0], str) and row[0][0] != '"'


def _holds_list(row: Sequence[Noted]) -> bool:
    return any(isinstance(one, tuple) for one in row)


def _has_rows(rule: str) -> bool:
    """Return whether a list ends with any number of lists of the same kind."""
    last = RULES[rule][-1]
    inner = _entered(last) if last[0] in ("*", "+") else []
    return bool(inner) and all(is_list(RULES.get(one, "")) for one in inner)


def _entered(shape: Shape) -> list[str]:
    """Return the leaves of a shape and of the groups in it."""
    return [
        one
        for leaf in leaves(shape)
        for one in (_entered(RULES[leaf]) if _is_group(leaf) else [leaf])
    ]


def _is_group(leaf: str) -> bool:
    return is_rule(leaf) and RULES[leaf][0] == "or"


def _first_words(shape: Shape) -> set[str]:
    """Return the words of a shape that have a value after them."""
    if isinstance(shape, str):
        return set()
    inner = [word for part in shape[1:] for word in _first_words(part)]
    return {*inner, *(words_of_shape(shape[1]) if shape[0] == "seq" else ())}


_ALONE = frozenset(
    word
    for shape in RULES.values()
    for word in set(words_of_shape(shape)) - _first_words(shape)
    if word.startswith(":")
)
"""Words with a colon that have no value."""


_BELOW = frozenset(FORMS) | {
    word
    for rule in RULES
    if rule == "method" or (_has_rows(rule) and rule not in rules_by_head("formula"))
    for word in heads(rule)
}
"""The words with their operands on the lines below, indented by two columns."""

_BROKEN = frozenset(
    (
        *("define-rap", "define-method", "method", "task-net"),
        *("define-agenda", "define-query"),
        *("define-test", "define-test-defaults", "script", "expect"),
        *("define-memory-rule", "define-event-rule", "match-result"),
    )
)
"""The words whose lists are never on one line if they have a list inside."""

_JOINED = frozenset(("and", "or", "resources"))
"""The words whose lists are never on one line if they have two lists or more."""

_FILLED = frozenset(("facts", "primitives", "primitives-include"))
"""The words of lists of facts and requests, which fill their lines."""

_BESIDE = {
    **dict.fromkeys(FORMS, 1),
    "define-memory-rule": 2,
    "at": 1,
}
"""The number of operands on the line of a word, besides atoms before a list."""
