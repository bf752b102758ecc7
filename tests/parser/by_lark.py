"""Data of a text as our reader and lark's parser of the same grammar find them.

A text that lark refuses has findings; one that lark reads has none, but for what the
grammar does not limit: depth, length, what merely looks like a number, and a form that
begins a line within another.
"""

from __future__ import annotations

import re

from lark import Token, Tree
from lark.exceptions import UnexpectedInput

from rapc.language.build import parser as reference

from .reading import Plain, plain, reading

UNLIMITED = {"malformed-number", "too-long", "nested-too-deeply"}
"""What is said of texts that the grammar allows."""

KINDS = {"NUMBER": "Numeral", "WORD": "Symbol"}
FORM_IN_LIST = re.compile(r"\n\((?:define|declare)-")


def _by_lark(tree: Tree[Token]) -> tuple[Plain, ...]:
    items: list[Plain] = []
    for child in tree.children:
        if isinstance(child, Tree):
            meta = child.meta
            items.append(("List", _by_lark(child), meta.start_pos, meta.end_pos))
        elif not child.type.startswith("BLOCK"):
            assert child.start_pos is not None
            assert child.end_pos is not None
            text = str(child)
            if child.type == "STRING":
                text = text[1:-1]
            elif child.type == "NUMBER":
                text = str(float(text) + 0.0)  # there is no negative zero
            else:
                text = text.lower()
            kind = KINDS.get(child.type, child.type.capitalize())
            kind = "Arrow" if text == "=>" else kind
            items.append((kind, text, child.start_pos, child.end_pos))
    return tuple(items)


def _by_us(items: tuple[Plain, ...]) -> tuple[Plain, ...]:
    made: list[Plain] = []
    for kind, value, start, end in items:
        if kind == "List":
            assert isinstance(value, tuple)
            made.append((kind, _by_us(value), start, end))
        elif kind == "Numeral":
            assert isinstance(value, int | float)
            made.append((kind, str(float(value)), start, end))
        else:
            made.append((kind, value, start, end))
    return tuple(made)


def hold_data(text: str) -> None:
    """Hold our reading of a text against lark's."""
    found = reading(text)
    said = {d.rule for d in found.diagnostics}
    try:
        tree = reference().parse(text, start="data")
    except UnexpectedInput:
        assert said - UNLIMITED or text.startswith("\ufeff")
        return
    if FORM_IN_LIST.search(text):
        said -= {"missing-parenthesis", "surplus-parenthesis"}
    assert said <= UNLIMITED
    if not found.diagnostics and "\\" not in text:
        data = tuple(plain(top.datum) for top in found.forms)
        assert _by_us(data) == _by_lark(tree)
        assert not any(top.damaged for top in found.forms)
