"""Positions of comments and strings in a text.

Comments nest, and a comment may contain quotes: terminals of the grammar cannot
describe either.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from rapc.language.grammar import TERMINALS

BLOCK_MARK = re.compile(r"#\||\|#")
"""The start and the end of a nested comment."""

_PIECE = re.compile(
    rf"(?P<string>{TERMINALS['STRING']})|(?P<line>{TERMINALS['COMMENT']})"
    r"|(?P<block>#\|)|(?P<open>\")"
)


def comment_end(text: str, start: int) -> int:
    """Return the end of the `#| |#` comment that begins at `start`, or -1."""
    depth = 0
    for mark in BLOCK_MARK.finditer(text, start):
        depth += 1 if mark[0] == "#|" else -1
        if depth == 0:
            return mark.end()
    return -1


def strings(text: str) -> Iterator[tuple[int, int]]:
    """Yield the start and end of each string in a text, with the quotes.

    The text after an unclosed string or comment is left out.
    """
    for kind, start, end in _pieces(text):
        if kind == "string":
            yield start, end


def blanked(text: str) -> str | None:
    """Return `text` with blanks for its comments, also for line ends in comments.

    The result is None if the text ends within a comment or a string.
    """
    made: list[str] = []
    at = 0
    for kind, start, end in _pieces(text):
        if kind == "open" or (kind == "line" and end == len(text)):
            return None
        made.append(text[at:start])
        made.append(text[start:end] if kind == "string" else " " * (end - start))
        at = end
    return "".join(made) + text[at:]


def _pieces(text: str) -> Iterator[tuple[str | None, int, int]]:
    """Yield the strings and comments of a text, each as kind, start and end.

    The kind of an unclosed string or comment is `open`; it is the last.
    """
    end = 0
    while piece := _PIECE.search(text, end):
        kind, (start, end) = piece.lastgroup, piece.span()
        if kind == "block":
            end = comment_end(text, start)
        if end < 0 or kind == "open":
            yield "open", start, len(text)
            return
        yield kind, start, end
