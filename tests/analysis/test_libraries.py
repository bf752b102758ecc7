"""The libraries of a workspace."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rapc.analysis.config_file import nearest_config
from rapc.analysis.libraries import check_workspace, libraries_of
from rapc.errors import LoadError
from rapc.library import loader
from tests.cli.command import rapc

GO = "(define-rap (go ?where) (method (primitive (drive ?where))))\n"
WORLD = '(declare-primitive drive (?to) (okay) "Drive to a place.")\n'


def written(folder: Path, **files: str) -> None:
    """Write files: `a_test` is `a.test.rap`, `lib__a` is `lib/a.rap`."""
    for name, text in files.items():
        path = name.replace("__", "/").replace("_test", ".test")
        file = folder / f"{path}.rap"
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)


def libraries(folder: str) -> list[tuple[str, ...]]:
    found = libraries_of(folder, nearest_config(folder))
    return [one.paths for one in found]


def test_each_file_without_requiring_file_is_a_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    one = '(require "world")\n' + GO
    written(tmp_path, world=WORLD, one=one, two=one)
    written(tmp_path, two_test='(require "two")\n', alone_test="")
    assert libraries(".") == [
        ("one.rap",),
        ("two.rap", "two.test.rap"),
        ("alone.test.rap",),
    ]
    assert check_workspace(".", nearest_config(".")).findings == ()


def test_files_that_require_each_other_are_one_library(tmp_path: Path) -> None:
    written(tmp_path, a='(require "b")', b='(require "c")', c='(require "a")')
    names = tuple(str(tmp_path / f"{name}.rap") for name in "abc")
    assert libraries(str(tmp_path)) == [names]


def test_configuration_names_the_libraries(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(tmp_path, one__a=GO, one__world=WORLD, two__a=GO, other=GO)
    (tmp_path / "rapc.toml").write_text('libraries = ["one", "two/a.rap"]')
    monkeypatch.chdir(tmp_path / "one")
    assert libraries(str(tmp_path)) == [
        (str(tmp_path / "one"),),
        (str(tmp_path / "two/a.rap"),),
    ]
    monkeypatch.chdir(tmp_path)
    assert libraries(".") == [("one",), ("two/a.rap",)]
    found = check_workspace(".", nearest_config(".")).findings
    assert {one.diagnostic.span.file for one in found} == {"two/a.rap"}


def test_missing_library_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "rapc.toml").write_text('libraries = ["gone"]')
    where = str(tmp_path)
    with pytest.raises(LoadError, match="gone` does not exist"):
        check_workspace(where, nearest_config(where))


def test_unreadable_file_is_a_library_of_its_own(tmp_path: Path) -> None:
    written(tmp_path, a=GO)
    (tmp_path / "b.rap").write_bytes(b"\0")
    found = libraries(str(tmp_path))
    assert found == [(str(tmp_path / "a.rap"),), (str(tmp_path / "b.rap"),)]


def test_standard_library_in_a_workspace_has_a_name_below_it() -> None:
    folder = os.fspath(Path(loader.__file__).parents[1] / "stdlib")
    report = check_workspace(folder, nearest_config(folder))
    assert all(name.startswith(f"{folder}/") for name in report.files)


def test_unused_suppression_of_a_shared_file_is_reported_once(tmp_path: Path) -> None:
    shared = "; rapc: file-ignore[misspelt-variable] none\n" + WORLD
    written(tmp_path, shared=shared, one='(require "shared")', two='(require "shared")')
    where = str(tmp_path)
    found = check_workspace(where, nearest_config(where)).findings
    assert [one.rule.name for one in found] == ["unused-suppression"]


def test_check_without_path_checks_and_fixes_the_libraries(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    one = WORLD + "(define-rap (go) (success (= 1 1)) (method (primitive (drive a))))\n"
    written(tmp_path, one=one, two=one)
    assert rapc("check").returncode == 1
    rapc("check", "--fix")
    assert "(succeed " in (tmp_path / "one.rap").read_text()
    assert "(succeed " in (tmp_path / "two.rap").read_text()
