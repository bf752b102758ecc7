"""Lines of text: broken at a width, and with kinds, by which they are coloured.

Light, for commands that start without rich.
"""

from __future__ import annotations

from textwrap import wrap
from typing import Literal

import msgspec

Kind = Literal["title", "head", "place", "source", "mark", "text", "trace"]


class Line(msgspec.Struct, frozen=True):
    """A line of text with its kind, by which it is coloured."""

    kind: Kind
    text: str


def wrapped(text: str, width: int, *, indent: str = "") -> list[str]:
    """Return `text` as lines of at most `width` characters, broken between words.

    A word is cut only where it fills a whole line, never at its hyphens: tags and
    options are written with them. Lines behind the first begin with `indent`.
    """
    room = max(width, len(indent) + 1)
    return wrap(text, room, break_on_hyphens=False, subsequent_indent=indent)
