"""The libraries of a workspace: a folder with several libraries and their tests.

The key `libraries` of the configuration names them. Without the key, each file that no
other file requires is a library, with the files that it requires; files that require
each other are one library. A test file belongs to the first library with the files that
the test file requires.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

from rapc.analysis.check_files import loaded_libraries
from rapc.analysis.config import Configured
from rapc.analysis.driver import CheckReport, check_libraries, merged_reports
from rapc.analysis.selection import Selection
from rapc.base.files import TEST_SUFFIX
from rapc.base.graph import components, reachable
from rapc.library.loader import Parse, Units, names_below, required_files


class LibrarySpec(msgspec.Struct, frozen=True):
    """A library of a workspace."""

    #: The files and folders of the library and its tests, as for `rapc check`.
    paths: tuple[str, ...]


def libraries_of(
    workspace: str,
    configured: Configured,
    texts: Mapping[str, str] | None = None,
    parser: Parse | None = None,
) -> list[LibrarySpec]:
    """Return the libraries of a workspace; paths begin with that of the workspace.

    Args:
        workspace: the path of the folder.
        configured: the configuration of the workspace.
        texts: by file name, a text that replaces the text of the file.
        parser: the parser of files.

    Raises:
        LoadError: if the workspace cannot be read.
    """
    named = configured.config.libraries
    if named is not None and configured.file is not None:
        folder = configured.file.parent
        if not os.path.isabs(workspace):
            folder = Path(os.path.relpath(folder))
        return [LibrarySpec((str(folder / name),)) for name in named]
    names = names_below(workspace)
    required = required_files(workspace, texts, parser or Units(), dict(names))
    return list(_by_roots(sorted(names.values()), required))


def _by_roots(
    names: Sequence[str], required: Mapping[str, tuple[str, ...]]
) -> Iterator[LibrarySpec]:
    """Yield a library for each group of files that no other file requires.

    Args:
        names: the files of the workspace, in order.
        required: the files that each file requires.
    """
    tests = [name for name in names if name.endswith(TEST_SUFFIX)]
    files = [name for name in names if not name.endswith(TEST_SUFFIX)]
    groups = list(components(files, lambda name: required.get(name, ())))
    wanted = {
        one
        for group in groups
        for name in group
        for one in required.get(name, ())
        if one not in group
    }
    roots = [group for group in groups if wanted.isdisjoint(group)]
    found = [
        (group, {*reachable(group, lambda name: required.get(name, ()))})
        for group in sorted(map(sorted, roots))
    ]
    for test in tests:
        needed = {*required.get(test, ())}
        held = max(found, key=lambda one: len(needed & one[1]), default=None)
        if held is not None and needed & held[1]:
            held[0].append(test)
        else:
            found.append(([test], set()))
    yield from (LibrarySpec(tuple(paths)) for paths, _ in found)


def check_workspace(
    workspace: str,
    configured: Configured,
    selection: Selection | None = None,
    texts: Mapping[str, str] | None = None,
    *,
    parser: Parse | None = None,
) -> CheckReport:
    """Check the libraries of a workspace; see `merged_reports`.

    Args:
        workspace: the path of the folder.
        configured: the configuration of the workspace.
        selection: the rules that may report; None for all rules that are not opt-in.
        texts: by file name, a text that replaces the text of the file.
        parser: the parser of files; None to parse each file once.

    Raises:
        LoadError: if a path cannot be read.
    """
    units = parser or Units()
    names = names_below(workspace)
    reports = []
    for spec in libraries_of(workspace, configured, texts, units):
        loads = loaded_libraries(spec.paths, texts, units, names)
        reports.append(check_libraries(loads, selection, [workspace]))
    return merged_reports(reports)
