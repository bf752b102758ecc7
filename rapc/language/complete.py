"""Completion: the words and kinds of names that fit at a position in a text.

Lark's parser of `rap.lark` parses the text before the position and returns the accepted
terminals. A terminal for a word becomes the word, a terminal for a name becomes the
kind of the name. The grammar loads at the first call, which takes about 0.5 s.

Not here: the names themselves, and texts other than the language (commands of a shell).
"""

from __future__ import annotations

import re
from functools import cache
from typing import Any, Final

import msgspec
from lark.exceptions import UnexpectedInput

from rapc.language.build import START, parser, words
from rapc.language.comments import blanked
from rapc.language.grammar import TERMINALS

_BRACKETS = ("LPAR", "RPAR")
_NAME = re.compile(TERMINALS["_NAME"])
_FORM = re.compile(r"^\(", re.M)
_DEFINITION = re.compile(r"\((?:define|declare)-", re.I)

NOTHING: Final = frozenset[str]()


class Fits(msgspec.Struct, frozen=True):
    """The completions at a position; all fields are empty if nothing is known."""

    #: The start of the word at the position; the position itself if there is no word.
    start: int
    #: The part of the word before the position, in lower case.
    prefix: str
    #: The words of the language that fit and begin with `prefix`, sorted.
    words: tuple[str, ...] = ()
    #: The kinds of names that fit, by their names in `rap.lark`: RAP, TAG, ...
    kinds: frozenset[str] = NOTHING
    #: Whether a list may begin here.
    opens: bool = False
    #: Whether the list around the position may end here.
    closes: bool = False


def fits(text: str, *, start: str = START) -> Fits:
    """Return the completions at the end of `text`; a partial word is a prefix.

    Args:
        text: the text before the position. For programs, only the last form that
            begins in column 1 is parsed.
        start: the start rule of the grammar, from `rapc.language.build.STARTS`; the
            default is a program.
    """
    code = blanked(text[last_form(text) :] if start == START else text)
    if code is None:
        return Fits(len(text), "")
    at = _word_start(code)
    prefix = code[at:].lower()
    if start == START:
        forms = [form.start() for form in _FORM.finditer(code, 0, at)]
        code = code[forms[-1] :] if forms else code
        at -= forms[-1] if forms else 0
    accepted = _accepted(code[:at], start)
    known = words()
    return Fits(
        start=len(text) - len(prefix),
        prefix=prefix,
        words=tuple(
            sorted(
                {
                    known[one]
                    for one in accepted
                    if one in known
                    if known[one].startswith(prefix)
                }
            )
        ),
        kinds=frozenset(one for one in accepted if _is_kind(one, prefix)),
        opens="LPAR" in accepted and not prefix,
        closes="RPAR" in accepted and not prefix,
    )


def last_form(text: str) -> int:
    """Return the start of the last form that begins in column 1; if none, 0.

    A string may contain a line that begins with `(`, but hardly one that begins with
    `(define-` or `(declare-`. A text with `#| |#` comments is not cut, because such
    comments often contain forms.
    """
    if "#|" in text:
        return 0
    at = len(text)
    while (at := text.rfind("\n(", 0, at)) >= 0:
        if _DEFINITION.match(text, at + 1):
            return at + 1
    return 0


def _word_start(code: str) -> int:
    """Return the start of the word at the end of the code; if none, the end."""
    for word in _NAME.finditer(code, code.rfind("\n") + 1):
        if word.end() == len(code):
            return word.start()
    return len(code)


def _accepted(code: str, start: str) -> frozenset[str]:
    """Return the terminals accepted after the code; none if the code is invalid."""
    try:
        state: Any = parser(positions=False).parse_interactive(code, start=start)
        state.exhaust_lexer()
    except UnexpectedInput:
        return NOTHING
    return frozenset(state.accepts())


def _is_kind(terminal: str, prefix: str) -> bool:
    """Return whether a terminal is a kind of name that may begin with `prefix`."""
    if terminal in words() or terminal in _BRACKETS or terminal not in TERMINALS:
        return False
    return not prefix or _pattern(terminal).match(prefix) is not None


@cache
def _pattern(terminal: str) -> re.Pattern[str]:
    """Return the regular expression for a prefix of a terminal."""
    if TERMINALS[terminal][0] in ":\\":
        return re.compile(re.escape(":" if TERMINALS[terminal][0] == ":" else "?"))
    return re.compile(TERMINALS[terminal])
