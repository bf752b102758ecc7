"""Comments, which nest and are therefore more than a terminal of the grammar."""

from __future__ import annotations

import re

from rapc.language.grammar import TERMINALS

BLOCK_MARK = re.compile(r"#\||\|#")
"""What begins and ends a comment that nests."""

_PIECE = re.compile(
    rf"(?P<string>{TERMINALS['STRING']})|(?P<line>{TERMINALS['COMMENT']})"
    r"|(?P<block>#\|)|(?P<open>\")"
)


def comment_end(text: str, start: int) -> int:
    """Return where the `#| |#` comment that begins at `start` ends, or -1."""
    depth = 0
    for mark in BLOCK_MARK.finditer(text, start):
        depth += 1 if mark[0] == "#|" else -1
        if depth == 0:
            return mark.end()
    return -1


def blanked(text: str) -> str | None:
    """Return `text` with blanks for its comments, line ends among them.

    None if it ends within a comment or a string.
    """
    made: list[str] = []
    at = 0
    while piece := _PIECE.search(text, at):
        start, end = piece.span()
        kind = piece.lastgroup
        if kind == "block":
            end = comment_end(text, start)
        if kind == "open" or end < 0 or (kind == "line" and end == len(text)):
            return None
        made.append(text[at:start])
        made.append(text[start:end] if kind == "string" else " " * (end - start))
        at = end
    return "".join(made) + text[at:]
