"""The fix for a name that seems to be a slip for another: write the other name.

Never certain, for only its author knows what was meant.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from rapc.base.diagnostics import Applicability, Edit, Fix
from rapc.base.names import is_slip
from rapc.base.source import SourceFile, Span

_WORD = r"[^\s()\";']"
"""What a name is made of, in regular expressions."""


def renaming(
    files: Mapping[str, SourceFile],
    name: str,
    meant: str | None,
    places: Iterable[Span],
) -> Fix | None:
    """Return the fix that writes another name at some places, or None.

    A name with too many other letters (`is_slip`) may be a question, but is not a fix.

    Args:
        files: the files of the library.
        name: the name that stands there.
        meant: the name that may be meant; None if there is none.
        places: the names themselves, or stretches in which the name stands once.
    """
    if not meant or not is_slip(name, meant):
        return None
    edits = []
    for place in places:
        word = _word(files.get(place.file), name, place)
        if word is None:
            return None
        edits.append(Edit(word, meant))
    return Fix(Applicability.UNSAFE, f"write `{meant}`", tuple(edits))


def _word(source: SourceFile | None, name: str, place: Span) -> Span | None:
    """Return where a name stands at a place; None if that is not certain."""
    if source is None:
        return None
    whole = rf"(?<!{_WORD}){re.escape(name)}(?!{_WORD})"
    text = source.text[place.start : place.end]
    found = [match.span() for match in re.finditer(whole, text, re.IGNORECASE)]
    if len(found) != 1:
        return None
    ((start, end),) = found
    return source.span(place.start + start, place.start + end)
