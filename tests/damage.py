"""Texts with random slips: in parentheses, lines, letters and tokens."""

from __future__ import annotations

import re
import string
from functools import cache
from pathlib import Path
from random import Random

from tests import slips_said

CHECKOUT = Path(__file__).resolve().parent.parent

_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[()]|[^\s()"]+')
_RAP = re.compile(r"^\(define-rap.*?(?=^[(;]|\Z)", re.DOTALL | re.MULTILINE)

_LONGEST = 20_000
"""The longest texts that `sound_texts` returns: a check takes as long as its text."""

MOST_SLIPS = 3
"""The most slips that `slipped` makes."""

_MOST_TOKENS = 5
"""The most tokens that `with_other_tokens` changes."""


@cache
def shipped_texts() -> tuple[str, ...]:
    """Return the texts of all RAP files in stdlib and examples."""
    folders = (CHECKOUT / "stdlib", CHECKOUT / "examples")
    paths = sorted(path for folder in folders for path in folder.rglob("*.rap"))
    return tuple(path.read_text(encoding="utf-8") for path in paths)


@cache
def shipped_raps() -> tuple[str, ...]:
    """Return the RAPs of stdlib and examples, each without its declarations."""
    return tuple(rap for text in shipped_texts() for rap in _RAP.findall(text))


@cache
def sound_texts() -> tuple[str, ...]:
    """Return shipped texts, and libraries of one file with their declarations."""
    near = sorted((CHECKOUT / "tests/analysis/near").glob("*.rap"))
    told = (slips_said.without(path.read_text(encoding="utf-8")) for path in near)
    return tuple(text for text in (*shipped_texts(), *told) if len(text) < _LONGEST)


def with_other_parenthesis(text: str, dice: Random) -> tuple[str, int]:
    """Return a text with one parenthesis dropped or doubled, and where."""
    at = dice.choice([i for i, c in enumerate(text) if c in "()"] or [0])
    twice = text[at : at + 1] if dice.random() < 0.5 else ""
    return text[:at] + twice * 2 + text[at + 1 :], at


def with_moved_line(text: str, dice: Random) -> str:
    """Return a text with one line elsewhere."""
    lines = text.splitlines(keepends=True)
    moved = lines.pop(dice.randrange(len(lines)))
    lines.insert(dice.randrange(len(lines) + 1), moved)
    return "".join(lines)


def with_other_letter(text: str, dice: Random) -> str:
    """Return a text with one letter dropped, doubled, changed or swapped."""
    at = dice.choice([i for i, c in enumerate(text) if c.isalpha()])
    letters = text[at : at + 2]
    other = dice.choice(string.ascii_lowercase) + letters[1:]
    changed = (letters[1:], letters[0] + letters, other, letters[::-1])
    return text[:at] + dice.choice(changed) + text[at + 2 :]


def slipped(text: str, dice: Random) -> str:
    """Return a text with one to three slips (`MOST_SLIPS`)."""
    for _ in range(dice.randint(1, MOST_SLIPS)):
        match dice.randrange(3):
            case 0:
                text, _ = with_other_parenthesis(text, dice)
            case 1:
                text = with_moved_line(text, dice)
            case _:
                text = with_other_letter(text, dice)
    return text


def with_other_tokens(text: str, dice: Random) -> str:
    """Return a text with tokens dropped, doubled, swapped or changed, on one line."""
    tokens = _TOKEN.findall(text)
    for _ in range(dice.randint(1, _MOST_TOKENS)):
        if len(tokens) < 2:
            break
        at, other = dice.randrange(len(tokens)), dice.randrange(len(tokens))
        match dice.randrange(4):
            case 0:
                del tokens[at]
            case 1:
                tokens.insert(at, tokens[other])
            case 2:
                tokens[at], tokens[other] = tokens[other], tokens[at]
            case _:
                tokens[at] = dice.choice(("?x", "a", "7", "(", ")", "not", ":a", "#1"))
    return " ".join(tokens)
