"""The digest of a library, by which a saved run knows its own."""

from __future__ import annotations

import hashlib

from rapc.library.library import Library


def digest(library: Library) -> str:
    """Return what tells a library from others: a digest of its texts, in order.

    It is the same wherever the sources lie.
    """
    found = hashlib.sha256()
    for source in library.files.values():
        text = source.text.encode("utf-8", "surrogatepass")
        found.update(b"%d\n" % len(text))
        found.update(text)
    found.update(" ".join(library.raps).encode("utf-8", "surrogatepass"))
    return found.hexdigest()
