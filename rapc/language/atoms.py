"""Values of Python that are values of the language: what programs can write down."""

from __future__ import annotations

import re
from functools import lru_cache
from math import isfinite

from rapc.base.limits import MAX_NAME
from rapc.base.values import Text
from rapc.language.grammar import TERMINALS

_SYMBOL = re.compile(f"(?:{TERMINALS['SYMBOL']}|{TERMINALS['KEYWORD']})")

_HALF_CHARACTER = re.compile("[\ud800-\udfff]")
"""A surrogate: it has no place in a file, nor in saved bytes."""


@lru_cache(maxsize=4096)
def is_symbol(text: str) -> bool:
    """Whether a text is a symbol or keyword as the reader returns it, folded.

    Handlers assert the same names again and again, so answers are kept.
    """
    if len(text) > MAX_NAME or _HALF_CHARACTER.search(text):
        return False
    return bool(_SYMBOL.fullmatch(text)) and text == text.lower()


def is_atom(value: object) -> bool:
    """Whether a value may stand in a fact: a symbol, a number or a string.

    Subclasses are none of these, `bool` among them, nor are infinities and `nan`.
    """
    kind = type(value)
    if kind is str:
        return is_symbol(value)
    if kind is int:
        return True
    if kind is float:
        return isfinite(value)  # type: ignore[arg-type]
    if kind is not Text or type(value.value) is not str:  # type: ignore[attr-defined]
        return False
    return not _HALF_CHARACTER.search(value.value)  # type: ignore[attr-defined]
