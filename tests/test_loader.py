"""Finding and reading files, following `require`, and what cannot be read."""

from __future__ import annotations

import io
import os
import shutil
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

import pytest

from rapc.base.diagnostics import Diagnostic
from rapc.errors import LoadError
from rapc.library.loader import load, load_text, standard_libraries


def _write(folder: Path, **files: str) -> Path:
    """Write files; `a__b="..."` is the file `a/b.rap`."""
    for name, text in files.items():
        path = folder / f"{name.replace('__', '/')}.rap"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


def _rap(name: str, *requires: str) -> str:
    rows = [f'(require "{required}")' for required in requires]
    return "\n".join([*rows, f"(define-rap ({name}))"])


@pytest.fixture(autouse=True)
def _in_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def _unresolved(paths: list[str]) -> Diagnostic:
    (diagnostic,) = load(paths).diagnostics
    assert diagnostic.rule == "unresolved-require"
    return diagnostic


def test_folder_is_read_sorted_with_what_lies_below(tmp_path: Path) -> None:
    _write(tmp_path, b=_rap("b"), a__z=_rap("z"), a__c__d=_rap("d"), c=_rap("c"))
    _write(tmp_path, b__e=_rap("e"))
    (tmp_path / "notes.txt").write_text("(not read")
    loaded = load(["."])
    assert list(loaded.files) == ["a/c/d.rap", "a/z.rap", "b/e.rap", "b.rap", "c.rap"]
    assert list(loaded.library.raps) == ["d", "z", "e", "b", "c"]


def test_hidden_folders_below_a_folder_are_left_out(tmp_path: Path) -> None:
    _write(tmp_path, **{".venv__a": _rap("a"), "b": _rap("b")})
    assert list(load(["."]).files) == ["b.rap"]
    assert list(load([".venv"]).files) == [".venv/a.rap"]


def test_tests_are_read_when_named_or_asked_for(tmp_path: Path) -> None:
    _write(tmp_path, **{"a": _rap("a"), "a.test": _rap("b")})
    assert list(load(["."]).files) == ["a.rap"]
    assert list(load(["."], tests=True).files) == ["a.rap", "a.test.rap"]
    assert list(load(["a.test.rap"]).files) == ["a.test.rap"]


def test_file_is_read_once_under_all_its_names(tmp_path: Path) -> None:
    _write(tmp_path, real__a=_rap("a"), b=_rap("b", "real"))
    (tmp_path / "link").symlink_to("real", target_is_directory=True)
    loaded = load(["real/a.rap", ".", "link", tmp_path])
    assert list(loaded.files) == ["real/a.rap", "b.rap"]
    assert loaded.diagnostics == ()


def test_require_takes_file_then_folder_beside(tmp_path: Path) -> None:
    _write(tmp_path, main=_rap("main", "arms", "legs"), arms=_rap("arm"))
    _write(tmp_path, arms__unread=_rap("other"), legs__one=_rap("leg"))
    _write(tmp_path, **{"legs__two.test": "(nonsense)"})
    loaded = load(["main.rap"])
    assert loaded.diagnostics == ()
    assert list(loaded.library.raps) == ["arm", "leg", "main"]


def test_required_files_come_first_and_may_require_each_other(tmp_path: Path) -> None:
    _write(tmp_path, a=_rap("a", "b"), b=_rap("b", "c", "a"), c=_rap("c", "a"))
    loaded = load(["a.rap"])
    assert loaded.diagnostics == ()
    assert list(loaded.files) == ["c.rap", "b.rap", "a.rap"]


def test_long_chain_of_requires(tmp_path: Path) -> None:
    count = 2000
    for at in range(count):
        _write(tmp_path, **{f"f{at}": _rap(f"r{at}", f"f{(at + 1) % count}")})
    loaded = load(["f0.rap"])
    assert len(loaded.library.raps) == count
    assert loaded.diagnostics == ()


def test_require_falls_back_on_the_standard_library(tmp_path: Path) -> None:
    assert "truck" in standard_libraries()
    _write(tmp_path, truck=_rap("mine", "truck"))
    loaded = load(["truck.rap"])
    assert loaded.diagnostics == ()
    assert len(loaded.library.raps) > 10
    assert "rapc:truck/world.rap" in loaded.files


COPIES = {
    "both folders named": ("clone", ["stdlib", "examples"]),
    "the library itself named": ("clone/stdlib", ["truck", "../examples"]),
    "one file of the library": ("clone", ["stdlib/truck/inner.rap"]),
    "inside of the library": ("clone/stdlib/truck", ["inner.rap"]),
    "from afar": (".", ["clone/examples", "clone/stdlib/truck"]),
}


@pytest.mark.parametrize("case", COPIES)
def test_a_copy_of_a_standard_library_stands_for_the_installed_one(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    installed = Path(str(resources.files("rapc"))) / "stdlib" / "truck"
    copy = tmp_path / "clone" / "stdlib" / "truck"
    shutil.copytree(installed, copy)
    (copy / "inner.rap").write_text(_rap("inner", "truck"))
    (tmp_path / "clone" / "examples").mkdir()
    (tmp_path / "clone" / "examples" / "mine.rap").write_text(_rap("mine", "truck"))
    one_file = _rap("other", "truck/world")
    (tmp_path / "clone" / "examples" / "other.rap").write_text(one_file)
    folder, paths = COPIES[case]
    monkeypatch.chdir(tmp_path / folder)
    loaded = load(paths)
    assert loaded.diagnostics == ()
    read = {Path(name).resolve() for name in loaded.files}
    assert {copy / "world.rap", copy / "inner.rap"} <= read
    assert not any(path.is_relative_to(installed.resolve()) for path in read)
    assert not any(name.startswith("rapc:") for name in loaded.files)
    assert not any(Path(name).is_absolute() for name in loaded.files)


def test_a_folder_that_only_has_the_name_of_a_standard_library_is_not_it(
    tmp_path: Path,
) -> None:
    (tmp_path / "truck").mkdir()
    _write(tmp_path, truck__mine=_rap("mine", "truck"))
    loaded = load(["truck"])
    assert loaded.diagnostics == ()
    assert len(loaded.library.raps) > 10


def test_a_require_names_no_absolute_path(tmp_path: Path) -> None:
    _write(tmp_path, arms=_rap("arm"), main=_rap("main", str(tmp_path / "arms")))
    assert _unresolved(["main.rap"]).message.startswith("cannot find `/")


def test_a_require_with_an_ending_is_told_to_leave_it_out(tmp_path: Path) -> None:
    _write(tmp_path, base=_rap("arm"), main=_rap("main", "base.rap"))
    assert _unresolved(["main.rap"]).help == "omit the suffix: `base`"


def test_line_break_in_a_required_name_is_visible(tmp_path: Path) -> None:
    _write(tmp_path, main=_rap("main", "a\nb"))
    assert (
        _unresolved(["main.rap"]).message == "cannot find `a\N{REPLACEMENT CHARACTER}b`"
    )


def test_folders_met_again_through_links_are_walked_once(tmp_path: Path) -> None:
    levels = 30  # two ways on each level: 2 to the 29 ways in all
    for level in range(levels):
        (tmp_path / f"f{level}").mkdir()
    for level in range(levels - 1):
        for way in "ab":
            link = tmp_path / f"f{level}" / way
            link.symlink_to(f"../f{level + 1}", target_is_directory=True)
    (tmp_path / f"f{levels - 1}" / "last.rap").write_text(_rap("last"))
    assert list(load(["f0"]).library.raps) == ["last"]


def test_require_that_finds_nothing_names_what_is_near(tmp_path: Path) -> None:
    _write(tmp_path, main=_rap("main", "armz"), arms=_rap("arm"))
    diagnostic = _unresolved(["main.rap"])
    assert diagnostic.span.start == 0
    assert diagnostic.help == "did you mean `arms`?"
    _write(tmp_path, main=_rap("main", "truk"))
    assert _unresolved(["main.rap"]).help == "did you mean `truck`?"
    _write(tmp_path, main=_rap("main", "quite-something-else"))
    assert _unresolved(["main.rap"]).help == ""


@pytest.mark.parametrize("name", ["", ".", "..", "main", "a" * 5000, "empty"])
def test_odd_requires_find_nothing_or_read_once(name: str, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    _write(tmp_path, program__main=f'(require "{name}")')
    loaded = load(["program/main.rap"])
    assert len(loaded.files) == 1


def test_standard_input(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    _write(tmp_path, arms=_rap("arm"))
    text = io.BytesIO(_rap("main", "arms").encode())
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(text))
    loaded = load(["-"])
    assert list(loaded.files) == ["arms.rap", "<stdin>"]


def test_line_ends_and_byte_order_mark_are_folded_away(tmp_path: Path) -> None:
    (tmp_path / "a.rap").write_bytes(
        b"\xef\xbb\xbf(define-rap\r\n(a))\r(define-rap (b))"
    )
    loaded = load(["a.rap"])
    assert loaded.files["a.rap"].text == "(define-rap\n(a))\n(define-rap (b))"
    assert list(loaded.library.raps) == ["a", "b"]


def test_text_may_come_from_a_program(tmp_path: Path) -> None:
    _write(tmp_path, arms=_rap("arm"))
    loaded = load_text(_rap("main", "arms"), "main.rap")
    assert list(loaded.files) == ["arms.rap", "main.rap"]


def test_missing_path_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(LoadError, match="`nowhere` does not exist"):
        load(["nowhere"])


def test_text_that_is_none_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "a.rap").write_bytes(b"(a)\n\xff")
    with pytest.raises(LoadError, match=r"`a.rap` is not UTF-8: byte 0xff in line 2"):
        load(["."])
    (tmp_path / "a.rap").write_bytes(b"(a)\0")
    with pytest.raises(LoadError, match=r"`a.rap` is a binary file"):
        load(["."])


def test_replaced_text_of_a_required_file_is_read_once(tmp_path: Path) -> None:
    folder = _write(tmp_path, a=_rap("a", "b"), b=_rap("b"))
    paths = [str(folder / "a.rap"), str(folder / "b.rap")]
    loaded = load(paths, texts={paths[0]: _rap("a", "b"), paths[1]: _rap("c")})
    assert list(loaded.library.raps) == ["c", "a"]
    assert loaded.diagnostics == ()


def test_required_file_that_cannot_be_read_is_an_error(tmp_path: Path) -> None:
    _write(tmp_path, a=_rap("a", "b"))
    (tmp_path / "b.rap").write_bytes(b"\xff")
    with pytest.raises(LoadError, match=r"`b.rap` is not UTF-8"):
        load(["a.rap"])


def test_link_that_leads_nowhere_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "a.rap").symlink_to("b.rap")
    with pytest.raises(LoadError, match=r"cannot read `a.rap`: missing file"):
        load(["."])


@pytest.mark.parametrize("target", [".", ".."])
def test_folder_that_leads_back_into_itself_is_an_error(
    target: str, tmp_path: Path
) -> None:
    (tmp_path / "a" / "b").mkdir(parents=True)
    (tmp_path / "a" / "b" / "back").symlink_to(target, target_is_directory=True)
    with pytest.raises(LoadError, match="`a/b/back` is a link to"):
        load(["a"])


def test_two_links_to_one_folder_are_no_loop(tmp_path: Path) -> None:
    _write(tmp_path, real__a=_rap("a"))
    (tmp_path / "one").symlink_to("real", target_is_directory=True)
    (tmp_path / "two").symlink_to("real", target_is_directory=True)
    assert list(load(["."]).files) == ["one/a.rap"]


@pytest.fixture
def deep(tmp_path: Path) -> Iterator[Path]:
    """A file so far down that recursion would not reach it; taken away by loops."""
    (tmp_path / "kept").touch()
    folder = tmp_path
    for _ in range(11):
        folder = folder.joinpath(*["d"] * 100)
        folder.mkdir(parents=True)
    yield folder / "a.rap"
    (folder / "a.rap").unlink()
    os.removedirs(folder)


def test_deep_folders_are_no_limit(deep: Path) -> None:
    deep.write_text(_rap("a"))
    assert list(load(["."]).library.raps) == ["a"]
