"""Renaming in the shipped libraries: no new finding, tests pass, equal traces."""

from __future__ import annotations

import random
import re
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path

import pytest

from rapc.analysis.check_files import loaded_libraries
from rapc.analysis.config import Configured
from rapc.analysis.libraries import check_workspace, libraries_of
from rapc.analysis.naming import Naming, NamingError
from rapc.base.diagnostics import Edit, edited
from rapc.library.loader import Units, names_below
from rapc.parser.names import Named
from rapc.worlds.source_names import names_in_code
from tests.cli.command import rapc

MARK = "-renamed"

REFUSED = r"\.py` uses it|is reserved|a class is a value"
"""The reasons against new names in the shipped libraries."""

FOLDERS = {
    "stdlib/truck": ("truck", "nine-orders"),
    "stdlib/truck-beyond": ("truck", "nine-orders-on-rounds"),
    "stdlib/hallway": ("hallway", "errand"),
    "examples/courier": ("courier", "shift"),
}
"""The shipped libraries with a world and an agenda."""


class Workspace:
    """A folder, read once, with all names that its files define."""

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.units = Units()
        names = names_below(folder)
        self.libraries = [
            loaded
            for spec in libraries_of(folder, Configured(), None, self.units)
            for loaded in loaded_libraries(spec.paths, None, self.units, names)
        ]
        worlds = [test.world for one in self.libraries for test in one.library.tests]
        self.code = names_in_code(filter(None, worlds), Path.cwd())
        self.naming = Naming(self.libraries)
        self.refused: list[str] = []
        self.texts = {
            name: source.text
            for one in self.libraries
            for name, source in one.files.items()
        }

    def defined(self) -> list[Named]:
        """Return each name once, at its definition."""
        found: dict[object, Named] = {}
        for file in names_below(self.folder).values():
            for one in self.naming.names(file):
                if one.defines:
                    key = (one.space, one.name, one.rap, one.scope)
                    found.setdefault(key, one)
        return list(found.values())

    def edits(self, named: Named) -> tuple[Edit, ...]:
        """Return the edits that rename a name; none if that is refused."""
        try:
            return self.naming.renamed(named, named.name + MARK, self.code)
        except NamingError as error:
            self.refused.append(error.message)
            return ()

    def edited(self, edits: Iterable[Edit]) -> Mapping[str, str]:
        """Return the texts of the files that edits change."""
        found: dict[str, set[Edit]] = {}
        for edit in edits:
            found.setdefault(edit.span.file, set()).add(edit)
        return {file: edited(self.texts[file], rows) for file, rows in found.items()}

    def findings(self, texts: Mapping[str, str]) -> list[str]:
        """Return the findings with these texts."""
        report = check_workspace(
            self.folder, Configured(), texts=texts, parser=self.units
        )
        return [f"{one.rule.name}: {one.diagnostic.message}" for one in report.findings]


def hold(folder: str, count: int) -> None:
    """Rename some names, one at a time; the findings stay the same."""
    workspace = Workspace(folder)
    names = workspace.defined()
    random.Random(folder).shuffle(names)
    before = workspace.findings({})
    for named in names[:count]:
        texts = workspace.edited(workspace.edits(named))
        after = [one.replace(MARK, "") for one in workspace.findings(texts)]
        assert after == before, named
    assert all(re.search(REFUSED, one) for one in workspace.refused)


def test_names_of_a_library_are_renamed_without_new_findings() -> None:
    hold("examples/courier", 5)


@pytest.mark.slow
@pytest.mark.parametrize("count", [10, pytest.param(50, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("folder", FOLDERS)
def test_names_are_renamed_without_new_findings(folder: str, count: int) -> None:
    hold(folder, count)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("folder", FOLDERS)
def test_names_of_a_kind_are_renamed_with_equal_runs(
    folder: str, tmp_path: Path
) -> None:
    """All names of a kind get new names at once, one kind after another."""
    workspace = Workspace(folder)
    world, agenda = FOLDERS[folder]
    names = workspace.defined()
    before = traced(Path(folder), world, agenda, tmp_path)
    for space in dict.fromkeys(one.space for one in names):
        every = [one for one in names if one.space == space]
        edits = [edit for one in every for edit in workspace.edits(one)]
        texts = workspace.edited(edits)
        if not texts:
            continue
        copy = tmp_path / space / Path(folder).name
        shutil.copytree(folder, copy)
        for name, text in texts.items():
            (copy / Path(name).relative_to(folder)).write_text(text)
        done = rapc("check", "--isolated", cwd=copy)
        assert done.returncode == 0, (space, done.stdout)
        done = rapc("test", ".", cwd=copy)
        assert done.returncode == 0, (space, done.stdout, done.stderr)
        begin = agenda + MARK if space == "agenda" else agenda
        assert traced(copy, world, begin, tmp_path) == before, space


def traced(folder: Path, world: str, agenda: str, into: Path) -> list[str]:
    """Return the events of a run after its first, with the former names."""
    file = into / "trace.jsonl"
    done = rapc(
        *("run", str(folder), "--world", world, "--agenda", agenda),
        *("--until", "3000", "--trace", str(file)),
    )
    assert done.returncode in (0, 1), done.stderr
    lines = file.read_text().replace(MARK, "").replace(f"{folder}/", "").splitlines()
    return lines[1:]
