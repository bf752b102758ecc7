"""Whether a slip changes what a library does in its own tests, told by their traces."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from operator import eq
from pathlib import Path

from rapc.base.source import SourceFile
from rapc.runtime.events.events import Event
from rapc.testing.discover import find
from rapc.testing.run import run_case


class Runs:
    """The tests of one library folder, and the traces they had before any slip.

    Args:
        folder: the folder; one without tests tells nothing.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._before = list(self._traces(None)) if folder.is_dir() else []

    def are_the_same(self, changed: SourceFile) -> bool | None:
        """Return whether all traces stay the same; None if there is no test."""
        if not self._before:
            return None
        try:
            return all(map(eq, self._before, self._traces(changed)))
        except RuntimeError:
            return False

    def _traces(self, changed: SourceFile | None) -> Iterator[Sequence[str]]:
        """Yield the trace of each test, with one file changed."""
        with tempfile.TemporaryDirectory() as place:
            copy = Path(place, "library")
            shutil.copytree(self._folder, copy)
            if changed is not None:
                name = Path(changed.name).resolve().relative_to(self._folder.resolve())
                (copy / name).write_text(changed.text, encoding="utf-8")
            found = find([copy])
            if found.reports:
                raise RuntimeError("a slip that a check finds was to be run")
            for case in found.cases:
                events: list[str] = []

                def note(event: Event, events: list[str] = events) -> None:
                    events.append(repr(event).replace(place, ""))

                run_case(case, listener=note)
                yield events
