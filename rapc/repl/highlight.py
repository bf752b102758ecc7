"""Tokens of RAP text and commands for colours, and indentation of lines."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator

from rapc.language.grammar import TERMINALS

_TOKEN = re.compile(
    "|".join(
        f"(?P<{name}>{pattern})"
        for name, pattern in (
            ("comment", TERMINALS["COMMENT"]),
            ("string", r'"(?:[^"\\]|\\.)*"?'),
            ("variable", TERMINALS["VARIABLE"]),
            ("keyword", TERMINALS["KEYWORD"]),
            ("number", TERMINALS["NUMBER"]),
            ("name", TERMINALS["_NAME"]),
            ("bracket", r"[()]"),
            ("rest", r"\s+|."),
        )
    ),
    re.S,
)


def tokens(text: str, known: Collection[str] = ()) -> Iterator[tuple[str, str]]:
    """Yield the tokens of a text, each with its kind; no character is lost.

    Args:
        text: RAP text, or a command.
        known: the words of the language; matching names have the kind `word`.
    """
    for found in _TOKEN.finditer(text):
        kind = found.lastgroup or "rest"
        said = found.group()
        yield ("word" if kind == "name" and said.lower() in known else kind), said


def indentation(text: str) -> int:
    """Return the indentation of the next line of an unfinished list, in spaces."""
    open_at: list[int] = []
    column = 0
    for kind, said in tokens(text):
        if said == "(":
            open_at.append(column)
        elif said == ")" and open_at:
            open_at.pop()
        newline = said.rfind("\n") if kind in ("rest", "string") else -1
        column = len(said) - newline - 1 if newline >= 0 else column + len(said)
    return open_at[-1] + 2 if open_at else 0
