"""Values of programs and their written form.

Symbols are Python `str` (already folded to lower case), numbers are `int` or `float`,
strings of the language are `Text`. A symbol and a string of the same letters are
different values. A whole float is always stored as the equal `int`.
Not here: resources, that is, sets and counters (`rapc.base.resources`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec


class Text(msgspec.Struct, frozen=True, tag="text"):
    """A string of the language; its letters are kept as written."""

    value: str


Atom = str | int | float | Text
"""A ground value that may stand in a fact."""

Number = int | float

Fact = tuple[Atom, ...]
"""A ground proposition: its name, then its arguments."""

Bindings = Mapping[str, Any]
"""Values by variable name, with its question mark."""


def number(value: float) -> Number:
    """Return a number in its canonical form: a whole float becomes an integer.

    Raises:
        ValueError: for infinities and NaN.
    """
    if isinstance(value, int):
        return value
    if not math.isfinite(value):
        raise ValueError("not a finite number")
    return int(value) if value.is_integer() else value


def is_number(value: object) -> bool:
    """Return whether a value is a number of the language (`bool` is not)."""
    kind = type(value)
    return kind is int or kind is float


def holds_between(op: str, left: Number, right: Number) -> bool:
    """Return whether a comparison of two numbers is true."""
    match op:
        case "<":
            return left < right
        case ">":
            return left > right
        case "<=":
            return left <= right
        case ">=":
            return left >= right
        case "=":
            return left == right
    return left != right


def is_variable(part: object) -> bool:
    """Return whether a part of a pattern is a variable: a symbol with a leading `?`."""
    return isinstance(part, str) and part.startswith("?")


def match_pattern(
    pattern: Sequence[object], values: Sequence[object]
) -> Bindings | None:
    """Return the bindings of a flat pattern that match values, or None; `?` is free."""
    if len(pattern) != len(values):
        return None
    bound: dict[str, Any] = {}
    for part, value in zip(pattern, values, strict=True):
        if part == "?":
            continue
        expected = bound.setdefault(str(part), value) if is_variable(part) else part
        if expected != value:
            return None
    return bound


def format_atom(value: object) -> str:
    """Return a value as RAP text; types with their own form use `str`."""
    if type(value) is Text:
        body = value.value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{body}"'
    if type(value) is float:
        return format_float(value)
    return str(value)


def typed(value: Atom | bool) -> str:
    """Return the value of an option as typed: text without quotes, flag as a word."""
    if isinstance(value, bool):
        return str(value).lower()
    return value.value if isinstance(value, Text) else format_atom(value)


def format_float(value: float) -> str:
    """Return a float in the form of the language: digits and a point, no exponent."""
    text = repr(value)
    if "e" not in text:
        return text
    head, exponent = text.removeprefix("-").split("e")
    whole, _, part = head.partition(".")
    sign, power = "-" * text.startswith("-"), int(exponent)
    if power < 0:
        return f"{sign}0.{'0' * (-power - 1)}{whole}{part}"
    return f"{sign}{(whole + part).ljust(power + 1, '0')}.0"


_DECIMALS = 6
"""The number of decimals shown to people; sums of floats have noise after them."""


def readable(value: object) -> str:
    """Return a value for people: RAP text, with at most 6 decimals in a number.

    A nonzero number that would be rounded to 0 has 6 significant digits.
    """
    if type(value) is float and math.isfinite(value):
        shown = round(value, _DECIMALS) or float(f"{value:.{_DECIMALS}g}")
        return format_atom(number(shown))
    return format_atom(value)


_LONG_NUMBER = re.compile(rf"(?<![\w.])-?\d+\.\d{{{_DECIMALS + 1},}}(?![\w.])")


def readable_numbers(text: str) -> str:
    """Return a text for people, with each long number as `readable` returns it."""
    return _LONG_NUMBER.sub(lambda found: readable(float(found[0])), text)


def format_list(parts: Iterable[object]) -> str:
    """Return values as a RAP list; nested tuples become nested lists."""
    words = [
        part
        if type(part) is str
        else format_list(part)
        if isinstance(part, tuple)
        else format_atom(part)
        for part in parts
    ]
    return f"({' '.join(words)})"
