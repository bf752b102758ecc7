"""RAP text and commands cut into tokens, for colours; and how deep a line is set in."""

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
    """Cut a text into tokens, each with its kind; together they are the whole text.

    Args:
        text: RAP text, or a command.
        known: the words of the language; names among them are of the kind `word`.
    """
    for found in _TOKEN.finditer(text):
        kind = found.lastgroup or "rest"
        said = found.group()
        yield ("word" if kind == "name" and said.lower() in known else kind), said


def indentation(text: str) -> int:
    """Return how many spaces the next line of an unfinished list begins with."""
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
