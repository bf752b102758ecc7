"""Compiled libraries: the time from a file to a library ready to be run, both ways.

Both are timed as the commands do it, with the search for reference cycles held back.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from bench.common import Figure, inputs, seconds
from bench.parse import library
from rapc import host
from rapc.base.gc_paused import gc_paused
from rapc.library.saved import encode

TRUCK = inputs() / "stdlib" / "truck"


def figures(quick: bool = False) -> Iterator[Figure]:
    """A generated library, then that of the truck."""
    size = 100 if quick else 5000
    with tempfile.TemporaryDirectory() as folder:
        text = Path(folder, "generated.rap")
        text.write_text(library(size), encoding="utf-8")
        yield from _both(text, f"{size} RAPs", folder)
        yield from _both(TRUCK, "stdlib/truck", folder)


def _both(sources: Path, size: str, folder: str) -> Iterator[Figure]:
    file = Path(folder, "compiled")
    file.write_bytes(encode(host.load(sources).program.library, str(sources)))
    works: tuple[tuple[str, Callable[[], object]], ...] = (
        ("read and check sources", lambda: host.load(sources).program),
        ("read a compiled library", lambda: host.load(file).program),
        ("the same, and each RAP", lambda: _read_all(file)),
    )
    for what, work in works:
        with gc_paused():
            taken = seconds(work, rounds=3)
        yield Figure("compiled", what, size, taken * 1e3, "ms")


def _read_all(file: Path) -> None:
    raps = host.load(file).program.library.raps
    for name in raps:
        raps[name]
