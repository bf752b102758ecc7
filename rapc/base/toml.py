"""Conversion of TOML files into typed records, with messages in terms of TOML."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from typing import Any, TypeVar

import msgspec

from rapc.errors import Error

T = TypeVar("T")

_NAMES = " of small letters, digits and hyphens"
"""The text for a regular expression in messages; only one is in use."""

_WORDS = {
    "str": "text",
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "array": "a list",
    "object": "a table",
    "int | float": "a number",
    "object | array": "a list or a table",
    "bool | int | float | str": "text, a number or true or false",
}


class TomlError(Error):
    """An error for text that is not TOML, or has invalid keys or values."""


def parsed(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises:
        TomlError: for text that is not TOML, or is nested too deeply.
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise TomlError(_lower(str(error))) from error
    except RecursionError as error:
        raise TomlError("nested too deeply") from error


def converted(table: Mapping[str, Any], kind: type[T]) -> T:
    """Return a table as a record.

    Raises:
        TomlError: for a value of the wrong kind.
    """
    try:
        return msgspec.convert(table, kind)
    except msgspec.ValidationError as error:
        raise TomlError(_in_words(str(error))) from error


def _in_words(message: str) -> str:
    """Return msgspec's message, with the position in words and the types of TOML.

    `Expected `str`, got `int` - at `$.part[0].vary`` becomes
    ``part 1, vary`: expected text, got a whole number`.
    """
    what, _, path = message.partition(" - at ")
    what = what.partition(" matching regex")[0] + _NAMES * ("regex" in what)
    what = re.sub(r"Object missing required field (.*)", r"the key \1 is missing", what)
    what = re.sub(r"Invalid enum value '(.*)'", r"there is no value `\1` here", what)
    what = what.replace("`str` of length >= 1", "a text that is not empty").replace(
        " | null`", "`"
    )
    what = re.sub(r"`([^`]*)`", lambda m: _WORDS.get(m[1], f"`{m[1]}`"), what)
    path = path.strip("`").removeprefix("$").replace("[...]", "").removeprefix(".")
    path = re.sub(r"\[(\d+)\]", lambda m: f" {int(m[1]) + 1}", path).replace(".", ", ")
    return f"`{path}`: {_lower(what)}" if path else _lower(what)


def _lower(text: str) -> str:
    return text[:1].lower() + text[1:]
