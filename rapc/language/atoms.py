"""Validation of Python values as atoms of the language."""

from __future__ import annotations

import re
from functools import lru_cache
from math import isfinite, isnan

from rapc.base.limits import MAX_NAME
from rapc.base.values import Text
from rapc.errors import ArgumentError
from rapc.language.grammar import TERMINALS

_SYMBOL = re.compile(f"(?:{TERMINALS['SYMBOL']}|{TERMINALS['KEYWORD']})")

_HALF_CHARACTER = re.compile("[\ud800-\udfff]")
"""A surrogate, which is invalid in files and in saved bytes."""


@lru_cache(maxsize=4096)
def is_symbol(text: str) -> bool:
    """Return whether a text is a symbol or keyword in the folded form of the reader.

    Results are cached, because handlers assert the same names repeatedly.
    """
    if len(text) > MAX_NAME or _HALF_CHARACTER.search(text):
        return False
    return bool(_SYMBOL.fullmatch(text)) and text == text.lower()


def is_atom(value: object) -> bool:
    """Return whether a value is valid in a fact: a symbol, a number or a string.

    Subclasses such as `bool`, infinities and `nan` are not valid.
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


def need_atoms(values: object, what: str) -> None:
    """Raise ArgumentError unless `values` is a tuple of a name and atoms or None.

    Args:
        values: a caller's argument: a fact, a prefix of a fact, or a goal.
        what: the noun for the argument in messages.
    """
    if not isinstance(values, tuple):
        raise ArgumentError(
            f"expected a tuple for {what}, not {kind(values)}", '("name", arg...)'
        )
    if not values or not isinstance(values[0], str):
        found = kind(values[0]) if values else "missing"
        raise ArgumentError(f"the name of {what} is {found}")
    for value in values[1:]:
        if value is not None and not isinstance(value, str | int | float | Text):
            raise ArgumentError(f"an argument of {what} is {kind(value)}")


def need_fact(values: object, what: str) -> None:
    """Raise ArgumentError unless `values` is a tuple of a name and valid atoms.

    Args:
        values: a caller's argument: a signal or a goal without variables.
        what: the noun for the argument in messages.
    """
    need_atoms(values, what)
    assert isinstance(values, tuple)
    for value in values:
        if not is_atom(value):
            wanted = "use symbols, numbers and `rapc.world.Text`"
            raise ArgumentError(f"invalid value `{value!a:.60}` in {what}", wanted)


def kind(value: object) -> str:
    """Return the type of `value` in words: `a text`, `None`, `of type int`."""
    if isinstance(value, float) and isnan(value):
        return "nan"
    words: dict[type, str] = {type(None): "None", str: "a text", list: "a list"}
    found = type(value)
    name = f"of type {found.__module__}.{found.__qualname__}"
    return words.get(found, name.replace("builtins.", ""))
