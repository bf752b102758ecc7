"""What one operand of a list must be, and the readers of words, names and numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import msgspec

from rapc.base.values import Number
from rapc.language.grammar import GRAMMAR, TERMINALS
from rapc.parser.context import Context, Read
from rapc.parser.syntax import Datum, Keyword, Numeral, String, Symbol, Variable
from rapc.parser.terms import term

Fits = Callable[[Datum], bool]
"""Whether a datum is of the kind wanted, by its type and first word alone."""


class OperandWanted(msgspec.Struct, frozen=True):
    """What a single operand must be."""

    fits: Fits
    read: Read
    #: Whether `read` is for data that fit only; lists tell by themselves what is wrong.
    strict: bool


def one_word(word: str) -> Fits:
    """Return what tells the symbol or keyword `word` from all other data."""

    def fits(datum: Datum) -> bool:
        return isinstance(datum, Symbol | Keyword) and datum.name == word

    return fits


def _is_name(datum: Datum) -> bool:
    return type(datum) is Symbol


def is_string(datum: Datum) -> bool:
    """Whether a datum is a string."""
    return type(datum) is String


def _is_parameter(datum: Datum) -> bool:
    return type(datum) is Variable and datum.name != "?"


def terminal(name: str) -> OperandWanted:
    """Return what reads a terminal: constants, variables to nodes, names to strings."""
    if name in _NODES:
        return OperandWanted(_NODES[name], term, True)
    if name in _NUMBERS:
        return OperandWanted(_is_numeral, _number(name), False)
    if name == "FILE":
        return OperandWanted(_names_file, _file, True)
    if name == "STRING":
        return OperandWanted(is_string, _text, True)
    if TERMINALS[name] == TERMINALS["SYMBOL"]:
        return OperandWanted(_is_name, _named, True)
    if TERMINALS[name] == TERMINALS["KEYWORD"]:
        return OperandWanted(_NODES["KEYWORD"], _named, True)
    raise TypeError(f"no operand is a {name} alone")


def _named(ctx: Context, datum: Datum) -> str:
    assert isinstance(datum, Symbol | Keyword)
    return datum.name


def _text(ctx: Context, datum: Datum) -> str:
    assert isinstance(datum, String)
    return datum.value


def _names_file(datum: Datum) -> bool:
    return isinstance(datum, Symbol) or (isinstance(datum, String) and datum.value > "")


def _file(ctx: Context, datum: Datum) -> str:
    """The name of a file; a symbol is read as one that lacks its quotes."""
    if isinstance(datum, String):
        return datum.value
    assert isinstance(datum, Symbol)
    fix = ctx.replace(datum, f'"{datum.name}"')
    ctx.report_fixable("malformed-form", "`require` takes a string", datum, fix=fix)
    return datum.name


def _is_numeral(datum: Datum) -> bool:
    return type(datum) is Numeral


_NODES: Mapping[str, Fits] = {
    "SYMBOL": _is_name,
    "VARIABLE": lambda datum: type(datum) is Variable,
    "NUMBER": _is_numeral,
    "KEYWORD": lambda datum: type(datum) is Keyword,
}
_NUMBERS: Mapping[str, Callable[[Number], bool]] = {
    "INTEGER": lambda value: isinstance(value, int),
    "COUNT": lambda value: isinstance(value, int) and value >= 0,
    "POSITIVE": lambda value: isinstance(value, int) and value > 0,
    "TIME": lambda value: value >= 0,
    "PERIOD": lambda value: value > 0,
}
"""For each terminal of numbers which of them it is."""


def _number(name: str) -> Read:
    def read(ctx: Context, datum: Datum) -> Number | None:
        if isinstance(datum, Numeral) and _NUMBERS[name](datum.value):
            return datum.value
        ctx.report("malformed-clause", f"{GRAMMAR[name].wanted} is wanted here", datum)
        return None

    return read
