"""Text of other authors in a form that is safe to show on a terminal."""

from __future__ import annotations

import unicodedata

_TAB = "    "


def visible(text: str) -> str:
    """Return a text with its control characters replaced."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else _stand_in(c) for c in text)


def visible_lines(text: str) -> str:
    """Return a text of several lines with the control characters of each replaced."""
    return text if text.isprintable() else "\n".join(map(visible, text.split("\n")))


def _stand_in(character: str) -> str:
    if character == "\t":
        return _TAB
    if unicodedata.category(character) == "Zs":
        return character
    return "\N{REPLACEMENT CHARACTER}"
