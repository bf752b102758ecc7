"""Text broken into lines of a width. Light, for commands that start without rich."""

from __future__ import annotations

from textwrap import wrap


def wrapped(text: str, width: int, *, indent: str = "") -> list[str]:
    """Return `text` as lines of at most `width` characters, broken between words.

    A word is cut only where it fills a whole line, never at its hyphens: tags and
    options are written with them. Lines behind the first begin with `indent`.
    """
    room = max(width, len(indent) + 1)
    return wrap(text, room, break_on_hyphens=False, subsequent_indent=indent)
