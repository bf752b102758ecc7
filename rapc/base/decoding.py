"""The errors of decoders: data of files and of other processes is not trusted."""

from __future__ import annotations

import msgspec

UNREADABLE = (msgspec.DecodeError, UnicodeError, RecursionError)
"""The exceptions of a decoder of msgspec for data that it cannot read."""


def flaw(error: Exception) -> str:
    """Return the reason of an exception in `UNREADABLE`, beginning in lower case."""
    text = "nested too deeply" if isinstance(error, RecursionError) else str(error)
    return text if text[1:2].isupper() else text[:1].lower() + text[1:]
