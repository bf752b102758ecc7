"""Layout of definitions: trees to lines.

A list that does not fit on its line is broken between its operands. In a definition, a
method and a list of lists the operands continue below the first word, indented by two
columns. In all other lists the operands are aligned after the word, one on each line.
An option stays on the line of its value. Lists in `_BROKEN` are never on one line.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

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
    writer = _Writer(width)
    writer.tree(tree, "", 0, vertical=True)
    return "".join(writer.parts)


class _Shape(msgspec.Struct, frozen=True, gc=False):
    """The properties of a tree that determine whether it is written on one line."""

    #: The width on one line, without comments.
    wide: int
    #: The tree on one line; None if a list in it is always broken.
    text: str | None
    #: Whether the tree has a comment.
    noted: bool = False
    #: The operands of a list, each option together with its value.
    operands: Sequence[Sequence[Noted]] = ()
    #: Whether the list itself is always broken.
    broken: bool = False


_NOTE = _Shape(0, None, noted=True)


class _Writer:
    """The lines of a tree, written from left to right.

    Args:
        width: the number of columns of a line.
    """

    def __init__(self, width: int) -> None:
        self.parts: list[str] = []
        self._width = width
        self._column = 0
        self._shapes: dict[int, _Shape] = {}

    def tree(self, tree: Noted, after: str, column: int, *, vertical: bool) -> None:
        """Write a tree.

        Args:
            tree: the tree.
            after: the text that follows the tree, for example closing parentheses; it
                must fit on the last line of the tree.
            column: the column from which the lines of the tree are indented.
            vertical: whether the list around the tree is broken.
        """
        if isinstance(tree, Note):
            if not tree.text:
                self.parts[-1] = "\n"  # a blank line has no indentation
            self.parts.append(tree.text)
            return
        shape = self._shape(tree)
        fits = shape.wide + len(after) <= self._width - self._column
        if isinstance(tree, str) or (shape.text is not None and (fits or not vertical)):
            self._write(f"{shape.text}{after}")
            return
        self._list(tree, shape, after, column, shape.broken or (vertical and not fits))

    def _list(
        self,
        tree: tuple[Noted, ...],
        shape: _Shape,
        after: str,
        column: int,
        vertical: bool,
    ) -> None:
        word = tree[0] if tree and isinstance(tree[0], str) else ""
        operands = shape.operands
        beside, below = _beside(word, operands), word in _BELOW - _FILLED
        first = len(word) + (2 if word else 1)
        broken_at = column + (2 if below else first)
        here = column + first
        self._write(f"({word}")
        noted = False
        for at, row in enumerate(operands):
            was, noted = noted, isinstance(row[0], Note)
            closed = f"){after}" if at == len(operands) - 1 and not noted else ""
            if isinstance(row[0], Note) and row[0].beside:
                self.parts.append(f"  {row[0].text}")
            elif noted or was or (at >= beside and (at > 0 or below)):
                inner = vertical
                if vertical and not (noted or was) and _is_filled(word, row):
                    wide = sum(self._shape(one).wide + 1 for one in row) + len(closed)
                    inner = wide > self._width - self._column
                self._break(" ", broken_at, inner)
                self._row(row, closed, broken_at, inner)
            else:
                self._write(" " * bool(word or at))
                self._row(row, closed, here, vertical)
                here += sum(self._shape(one).wide + 1 for one in row)
        if noted:
            self._break("", broken_at, vertical)
        if noted or not operands:
            self._write(f"){after}")

    def _row(
        self, row: Sequence[Noted], after: str, column: int, vertical: bool
    ) -> None:
        """Write an operand, or an option with its value."""
        if len(row) > 1:
            option = str(row[0])
            self._write(f"{option} ")
            column += len(option) + 1
        self.tree(row[-1], after, column, vertical=vertical)

    def _write(self, text: str) -> None:
        self.parts.append(text)
        self._column += len(text)

    def _break(self, text: str, column: int, vertical: bool) -> None:
        """End the line, or write `text` if the list is not broken."""
        if not vertical:
            self._write(text)
            return
        self.parts.append("\n" + " " * column)
        self._column = column

    def _shape(self, tree: Noted) -> _Shape:
        if isinstance(tree, str):
            return _Shape(len(tree), tree)
        if isinstance(tree, Note):
            return _NOTE
        known = self._shapes.get(id(tree))
        if known is None:
            known = self._shapes[id(tree)] = self._measured(tree)
        return known

    def _measured(self, tree: tuple[Noted, ...]) -> _Shape:
        word = tree[0] if tree and isinstance(tree[0], str) else ""
        operands = _together(tree[1:] if word else tree)
        shapes = [self._shape(one) for one in tree]
        widths = [one.wide for one in shapes if one is not _NOTE]
        wide = sum(widths) + max(1, len(widths)) + 1
        noted = any(one.noted for one in shapes)
        broken = noted
        if word in _BROKEN or word in _JOINED:
            lists = sum(map(_holds_list, operands[_beside(word, operands) :]))
            broken = broken or lists > (word in _JOINED)
        texts = [one.text for one in shapes if one.text is not None]
        text = None
        if not broken and len(texts) == len(shapes):
            text = f"({' '.join(texts)})"
        return _Shape(wide, text, noted, operands, broken)


def _is_filled(word: str, row: Sequence[Noted]) -> bool:
    """Return whether a list fills each line with as many operands as fit."""
    if word.startswith("declare-"):
        return len(row) == 1 and not str(row[0]).startswith('"')
    return not word or word in _FILLED


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
