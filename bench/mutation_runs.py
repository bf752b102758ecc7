"""Whether a slip changes what a library does in its own tests, told by their traces."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import msgspec

from rapc.base.source import SourceFile
from rapc.events import Event, RunStarted
from rapc.testing.discover import find
from rapc.testing.run import Case, run_case


class Runs:
    """The tests of one library folder, and the traces they had before any slip.

    Args:
        folder: the folder; a file, or a folder without tests, tells nothing.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._before: dict[str, list[str]] = {}
        if folder.is_dir():
            with tempfile.TemporaryDirectory() as place:
                for case in _cases(folder, Path(place), None):
                    self._before[case.test.name] = _trace(case, place)

    def are_the_same(self, changed: SourceFile) -> bool | None:
        """Return whether all traces stay the same; None if there is no test.

        Each test is run up to the first event that differs.
        """
        if not self._before:
            return None
        with tempfile.TemporaryDirectory() as place:
            try:
                for case in _cases(self._folder, Path(place), changed):
                    before = self._before[case.test.name]
                    if len(_trace(case, place, before)) != len(before):
                        return False
            except _DiffersError:
                return False
        return True


class _DiffersError(Exception):
    """A trace is not what it was."""


def _cases(folder: Path, place: Path, changed: SourceFile | None) -> Iterator[Case]:
    """Yield the tests of a copy of a folder, with one file changed."""
    copy = place / "library"
    shutil.copytree(folder, copy)
    if changed is not None:
        name = Path(changed.name).resolve().relative_to(folder.resolve())
        (copy / name).write_text(changed.text, encoding="utf-8")
    found = find([copy])
    if found.reports:
        raise _DiffersError(found.reports)
    yield from found.cases


def _trace(case: Case, place: str, before: list[str] | None = None) -> list[str]:
    """Run a test and return its events as text, without the place of the copy.

    Raises:
        _DiffersError: at the first event that is not the one of `before`.
    """
    events: list[str] = []

    def note(event: Event) -> None:
        events.append(repr(_done(event)).replace(place, ""))
        if before is not None and events[-1:] != before[len(events) - 1 : len(events)]:
            raise _DiffersError

    run_case(case, listener=note)
    return events


def _done(event: Event) -> Event:
    """Return an event without its reasons, and what tells of the library's text."""
    other: dict[str, object] = {"at": ""} if hasattr(event, "at") else {}
    if isinstance(event, RunStarted):
        other["spec"] = msgspec.structs.replace(event.spec, digest="")
    if getattr(event, "because", None) is not None:
        other["because"] = None
    return msgspec.structs.replace(event, **other) if other else event
