"""Lines of text: wrapped at a width, and with kinds, which select colours.

The module does not import rich, so that commands start fast.
"""

from __future__ import annotations

from textwrap import wrap
from typing import Literal

import msgspec

Kind = Literal["title", "head", "place", "source", "mark", "text", "trace"]


class Line(msgspec.Struct, frozen=True):
    """A line of text with its kind, which selects the colour."""

    kind: Kind
    text: str


def wrapped(text: str, width: int, *, indent: str = "") -> list[str]:
    """Return `text` as lines of at most `width` characters, broken between words.

    A word is cut only if it is longer than a whole line, never at its hyphens, because
    tags and options contain hyphens. Lines after the first begin with `indent`.
    """
    room = max(width, len(indent) + 1)
    return wrap(text, room, break_on_hyphens=False, subsequent_indent=indent)
