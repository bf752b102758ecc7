"""What fits at a place in an unfinished text.

The answer comes from lark's parser of `rap.lark`: after the text up to the place has
been read, the parser says which terminals it would take. Those that are words come back
as words, those that are names as the kind of name that is wanted; whoever asks knows
which names of that kind there are. Loading the grammar takes about half a second, so it
is loaded by the first question.

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

NOTHING: Final = frozenset[str]()


class Fits(msgspec.Struct, frozen=True):
    """What may stand at a place; all empty where nothing is known."""

    #: Where the word begins that is being written, the place itself if there is none.
    start: int
    #: The part of that word before the place, in lower case.
    prefix: str
    #: The words of the language that fit and begin with `prefix`, sorted.
    words: tuple[str, ...] = ()
    #: The kinds of names that fit, as `rap.lark` calls them: RAP, TAG, PREDICATE, ...
    kinds: frozenset[str] = NOTHING
    #: Whether a list may begin here.
    opens: bool = False
    #: Whether the list that the place is in may end here.
    closes: bool = False


def fits(text: str, *, start: str = START) -> Fits:
    """Return what fits at the end of `text`; the part of a word there is a prefix.

    Args:
        text: everything before the place. What comes before the last form that
            begins in column one is not looked at.
        start: the rule of the grammar that the whole text is to be an example of:
            a program, or one of `rapc.language.build.STARTS`.
    """
    code = blanked(text)
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


def _word_start(code: str) -> int:
    """Return where the word begins that ends some code; its end if there is none."""
    for word in _NAME.finditer(code, code.rfind("\n") + 1):
        if word.end() == len(code):
            return word.start()
    return len(code)


def _accepted(code: str, start: str) -> frozenset[str]:
    """The terminals that may stand behind some code; none if it is wrong already."""
    try:
        state: Any = parser(positions=False).parse_interactive(code, start=start)
        state.exhaust_lexer()
    except UnexpectedInput:
        return NOTHING
    return frozenset(state.accepts())


def _is_kind(terminal: str, prefix: str) -> bool:
    """Whether a terminal is a kind of name that may begin with `prefix`."""
    if terminal in words() or terminal in _BRACKETS or terminal not in TERMINALS:
        return False
    return not prefix or _pattern(terminal).match(prefix) is not None


@cache
def _pattern(terminal: str) -> re.Pattern[str]:
    """A terminal as a regular expression for what may be the beginning of one."""
    if TERMINALS[terminal][0] in ":\\":
        return re.compile(re.escape(":" if TERMINALS[terminal][0] == ":" else "?"))
    return re.compile(TERMINALS[terminal])
