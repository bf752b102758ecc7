"""`rapc fmt` and `check --fix`: which files they replace, and what stays of them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rapc.analysis import fixes
from rapc.base import writing
from rapc.cli import fmt
from rapc.cli.main import main

from .command import rapc

ROUGH = "(define-rap (a)(succeed t))\n"
FINE = "(define-rap (a)\n  (succeed t))\n"
UNUSED = "; rapc: ignore[unknown-rap] nothing to ignore\n(define-rap (wait))\n"
FIXED = "\n(define-rap (wait))\n"
SAVED = "(define-rap (b))\n"

CHANGED = "error: cannot write `one.rap`: the file changed after rapc read it\n"


def _saves(file: Path, module: object, name: str, patch: pytest.MonkeyPatch) -> None:
    """Have another program save a file when a function of a module returns."""
    function: Callable[..., Any] = getattr(module, name)

    def saved(*args: Any, **more: Any) -> Any:
        result = function(*args, **more)
        new = file.with_name("new")
        new.write_text(SAVED)
        new.replace(file)
        return result

    patch.setattr(module, name, saved)


def _status(*args: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(args)
    assert isinstance(end.value.code, int)
    return end.value.code


@pytest.mark.parametrize(("module", "function"), [(fmt, "formatted"), (os, "fsync")])
def test_fmt_keeps_a_file_saved_meanwhile(
    module: object,
    function: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Saved while the layout is made, or while it is written beside the file."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "one.rap"
    file.write_text(ROUGH)
    _saves(file, module, function, monkeypatch)
    assert _status("fmt", "one.rap") == 2
    assert capsys.readouterr() == ("1 file cannot be written\n", CHANGED)
    assert file.read_text() == SAVED
    assert os.listdir(tmp_path) == ["one.rap"]


@pytest.mark.parametrize(("module", "function"), [(fixes, "mend"), (os, "fsync")])
def test_fix_keeps_a_file_saved_meanwhile(
    module: object,
    function: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The findings printed are those of the text that was saved."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "one.rap"
    file.write_text(UNUSED)
    _saves(file, module, function, monkeypatch)
    assert _status("check", "--fix", "one.rap") == 2
    out, err = capsys.readouterr()
    assert (out, err) == ("checked 1 file, 1 RAP: no findings\n", CHANGED)
    assert file.read_text() == SAVED
    assert os.listdir(tmp_path) == ["one.rap"]


def test_the_other_files_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("one.rap", "two.rap"):
        (tmp_path / name).write_text(ROUGH)
    _saves(tmp_path / "one.rap", os, "fsync", monkeypatch)
    assert _status("fmt", ".") == 2
    assert (tmp_path / "one.rap").read_text() == SAVED
    assert (tmp_path / "two.rap").read_text() == FINE


def test_a_file_removed_meanwhile_stays_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "one.rap"
    file.write_text(ROUGH)
    monkeypatch.setattr(os, "fsync", lambda _: file.unlink())
    assert _status("fmt", "one.rap") == 2
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("command", [("fmt",), ("check", "--fix")])
def test_a_read_only_file_and_one_with_two_names_are_left(
    command: tuple[str, ...], tmp_path: Path
) -> None:
    text = ROUGH if command == ("fmt",) else UNUSED
    for name in ("locked.rap", "linked.rap", "free.rap"):
        (tmp_path / name).write_text(text.replace("(a)", f"({name[:-4]})"))
    (tmp_path / "locked.rap").chmod(0o444)
    os.link(tmp_path / "linked.rap", tmp_path / "other")
    before = {p.name: p.read_text() for p in tmp_path.iterdir()}
    done = rapc(*command, *sorted(before.keys() - {"other"}), cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr == (
        "error: cannot write `linked.rap`: it has 2 hard links\n"
        "error: cannot write `locked.rap`: it is read-only\n"
    )
    after = {p.name: p.read_text() for p in tmp_path.iterdir()}
    assert [name for name in before if after[name] != before[name]] == ["free.rap"]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may give a file away")
def test_owner_and_mode_stay(tmp_path: Path) -> None:
    file = tmp_path / "one.rap"
    file.write_text(ROUGH)
    file.chmod(0o640)
    os.chown(file, 1234, 2345)
    assert rapc("fmt", "one.rap", cwd=tmp_path).returncode == 0
    assert file.read_text() == FINE
    status = file.stat()
    assert (status.st_uid, status.st_gid) == (1234, 2345)
    assert status.st_mode & 0o777 == 0o640


def test_file_is_unchanged_when_its_owner_cannot_be_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As a file of another user in a folder that both may write."""
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "one.rap"
    file.write_text(ROUGH)

    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(writing, "_owner", lambda status: status.st_ino)
    monkeypatch.setattr(os, "chown", refuse)
    assert _status("fmt", "one.rap") == 2
    said = "error: cannot write `one.rap`: the owner and group cannot be preserved\n"
    assert capsys.readouterr().err == said
    assert file.read_text() == ROUGH
    assert os.listdir(tmp_path) == ["one.rap"]


@pytest.mark.parametrize("command", [("fmt",), ("check", "--fix")])
@pytest.mark.parametrize("usual", [b"\n", b"\r\n"])
def test_line_ends_in_strings_stay(
    command: tuple[str, ...], usual: bytes, tmp_path: Path
) -> None:
    """Whatever the line ends elsewhere are; two strings may say the same."""
    file = tmp_path / "one.rap"
    strings = (
        b'"one\r\ntwo\nthree"',
        b'"four\nfive"',
        b'"four\r\nfive"',
        b'"four\nfive"',
    )
    forms = [
        usual + b"(declare-memory-proposition %s () %s)" % (name, string)
        for name, string in zip((b"a", b"b", b"c", b"d"), strings, strict=True)
    ]
    unused, _, rest = UNUSED.encode().partition(b"\n")
    rough = b'  ; "no\n; string\n(define-rap (e)(succeed (and (a)(b)(c)(d))))\n'
    file.write_bytes(unused + b"".join(forms) + (rough + rest).replace(b"\n", usual))
    assert rapc(*command, "one.rap", cwd=tmp_path).returncode == 0
    left = file.read_bytes()
    assert left.count(b'"') == 9
    assert tuple(b'"%s"' % one for one in left.split(b'"')[1:8:2]) == strings
    for string in strings:
        left = left.replace(string, b"")
    assert left.count(b"\r\n") == (left.count(b"\n") if usual == b"\r\n" else 0)


def _dead() -> int:
    """Return the number of a process that has ended."""
    with subprocess.Popen([sys.executable, "-c", ""]) as child:
        child.wait()
    return child.pid


@pytest.mark.parametrize("command", [("fmt",), ("check", "--fix")])
def test_half_written_files_of_killed_processes_are_removed(
    command: tuple[str, ...], tmp_path: Path
) -> None:
    dead = f"one.rap.{_dead()}.rapc-part"
    kept = {
        f"one.rap.{os.getpid()}.rapc-part": "of a process that lives",
        "one.rap.rapc-part": "of nobody",
        "one.rap.0.rapc-part": "of no process",
        f"one.rap.{2**40}.rapc-part": "of no process either",
        f"one.rap.{_dead()}.part": "of another program",
        "one.rap": FINE,
    }
    for name, text in {**kept, dead: ""}.items():
        (tmp_path / name).write_text(text)
    (tmp_path / f"folder.{_dead()}.rapc-part").mkdir()
    checked = command if command == ("fmt",) else ("check",)
    looked = (*checked, "--diff", "one.rap")
    assert rapc(*looked, cwd=tmp_path).returncode == 0
    assert dead in os.listdir(tmp_path)
    assert rapc(*command, "one.rap", cwd=tmp_path).returncode == 0
    left = {p.name: p.read_text() for p in tmp_path.iterdir() if p.is_file()}
    assert left == kept


def test_next_fmt_removes_files_of_a_killed_fmt(tmp_path: Path) -> None:
    (tmp_path / "one.rap").write_text(ROUGH)
    killed = (
        "import os, signal; from rapc.cli.main import main\n"
        "os.fsync = lambda _: os.kill(os.getpid(), signal.SIGKILL)\n"
        "main(['fmt', 'one.rap'])\n"
    )
    done = subprocess.run([sys.executable, "-c", killed], cwd=tmp_path, check=False)
    assert done.returncode == -signal.SIGKILL
    assert len(os.listdir(tmp_path)) == 2
    assert (tmp_path / "one.rap").read_text() == ROUGH
    assert rapc("fmt", "one.rap", cwd=tmp_path).returncode == 0
    assert os.listdir(tmp_path) == ["one.rap"]
    assert (tmp_path / "one.rap").read_text() == FINE
