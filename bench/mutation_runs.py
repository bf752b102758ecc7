"""Whether a slip changes what a library does in its own tests, told by their traces."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator, Sequence
from os.path import commonpath
from pathlib import Path

import msgspec

from rapc.base.source import SourceFile
from rapc.cli.check_options import nearest_config
from rapc.events import Event, RunStarted, TaskCreated
from rapc.testing.discover import find
from rapc.testing.run import Case, run_case
from rapc.worlds.registry import importing_from


class Runs:
    """The tests of one library, and the traces they had before any slip.

    Args:
        paths: the files and folders of the library and of its tests; without tests
            nothing is told.
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        self._paths = [path.resolve() for path in paths]
        config = nearest_config(str(self._paths[0]))
        #: The modules of which the tests may name worlds, and their folder.
        self._modules = config.config.world_modules
        self._home = Path.cwd() if config.file is None else config.file.parent
        #: The traces by the file, relative to the copy, and the name of the test.
        self._before: dict[tuple[str, str], list[str]] = {}
        #: The goals of the tasks of each test.
        self._goals: dict[tuple[str, str], set[str]] = {}
        with tempfile.TemporaryDirectory() as place, importing_from(self._home):
            for case in _cases(self._paths, Path(place), None):
                key = _key(case, place)
                goals: set[str] = set()
                self._before[key] = _trace(case, place, self._modules, goals=goals)
                self._goals[key] = goals

    def are_the_same(self, changed: SourceFile, rap: str = "") -> bool | None:
        """Return whether all traces stay the same; None if there is no test.

        Each test is run up to the first event that differs, those first whose file is
        called as the changed one.

        Args:
            changed: the file with the slip.
            rap: the RAP that has the slip: only its tests are run.
        """
        if not self._before:
            return None
        keys = [key for key, goals in self._goals.items() if not rap or rap in goals]
        stem = Path(changed.name).name.removesuffix(".rap")
        with tempfile.TemporaryDirectory() as place, importing_from(self._home):
            try:
                files = sorted({file for file, _ in keys})
                cases = list(_cases(self._paths, Path(place), changed, files))
                cases.sort(key=lambda case: f"/{stem}." not in case.test.span.file)
                for case in cases:
                    key = _key(case, place)
                    if key not in keys:
                        continue
                    before = self._before[key]
                    after = _trace(case, place, self._modules, before)
                    if len(after) != len(before):
                        return False
            except _DiffersError:
                return False
        return True


def _key(case: Case, place: str) -> tuple[str, str]:
    file = Path(case.test.span.file).relative_to(Path(place) / "library")
    return str(file), case.test.name


class _DiffersError(Exception):
    """A trace is not what it was."""


def _cases(
    paths: Sequence[Path],
    place: Path,
    changed: SourceFile | None,
    files: Sequence[str] | None = None,
) -> Iterator[Case]:
    """Yield the tests of a copy of some paths, with one file changed.

    Args:
        paths: the files and folders.
        place: the folder of the copy.
        changed: the file with the slip.
        files: the files whose tests are wanted, relative to the copy; None for all.
    """
    root = Path(commonpath([path.parent for path in paths]))
    copies = [place / "library" / path.relative_to(root) for path in paths]
    for path, copy in zip(paths, copies, strict=True):
        copy.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            shutil.copytree(path, copy)
        else:
            shutil.copy(path, copy)
    if changed is not None:
        name = Path(changed.name).resolve().relative_to(root)
        (place / "library" / name).write_text(changed.text, encoding="utf-8")
    named = None if files is None else [place / "library" / name for name in files]
    found = find(copies if named is None else named)
    if found.reports:
        raise _DiffersError(found.reports)
    yield from found.cases


def _trace(
    case: Case,
    place: str,
    modules: Sequence[str],
    before: list[str] | None = None,
    goals: set[str] | None = None,
) -> list[str]:
    """Run a test and return its events as text, without the place of the copy.

    The names of the goals of its tasks are added to `goals`.

    Raises:
        _DiffersError: at the first event that is not the one of `before`.
    """
    events: list[str] = []

    def note(event: Event) -> None:
        if goals is not None and isinstance(event, TaskCreated):
            goals.add(str(event.goal).strip("()").split()[0])
        events.append(repr(_done(event)).replace(place, ""))
        if before is not None and events[-1:] != before[len(events) - 1 : len(events)]:
            raise _DiffersError

    run_case(case, listener=note, modules=modules)
    return events


def _done(event: Event) -> Event:
    """Return an event without its reasons, and what tells of the library's text."""
    other: dict[str, object] = {"at": ""} if hasattr(event, "at") else {}
    if isinstance(event, RunStarted):
        other["spec"] = msgspec.structs.replace(event.spec, digest="")
    if getattr(event, "because", None) is not None:
        other["because"] = None
    return msgspec.structs.replace(event, **other) if other else event
