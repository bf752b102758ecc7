"""Values of Python that are values of the language: what programs can write down."""

from __future__ import annotations

import re
from math import isfinite

from rapc.base.values import Text
from rapc.language.grammar import TERMINALS

_PLAIN = re.compile(r"[a-z][a-z0-9-]*")
"""Most symbols: what this matches needs no other look."""

_SYMBOL = re.compile(f"(?:{TERMINALS['SYMBOL']}|{TERMINALS['KEYWORD']})")

_HALF_CHARACTER = re.compile("[\ud800-\udfff]")
"""A surrogate: it has no place in a file, nor in saved bytes."""


def is_symbol(text: str) -> bool:
    """Whether a text is a symbol or keyword as the reader returns it, folded."""
    if _PLAIN.fullmatch(text):
        return True
    if not _SYMBOL.fullmatch(text) or _HALF_CHARACTER.search(text):
        return False
    return text == text.lower()


def is_atom(value: object) -> bool:
    """Whether a value may stand in a fact: a symbol, a number or a string.

    Subclasses are none of these, `bool` among them, nor are infinities and `nan`.
    """
    kind = type(value)
    if kind is str:
        return is_symbol(value)  # type: ignore[arg-type]
    if kind is int:
        return True
    if kind is float:
        return isfinite(value)  # type: ignore[arg-type]
    if kind is not Text or type(value.value) is not str:  # type: ignore[attr-defined]
        return False
    return not _HALF_CHARACTER.search(value.value)  # type: ignore[attr-defined]
