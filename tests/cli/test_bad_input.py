"""Whatever `rapc check` is given ends in findings or one line, and writes nothing."""

from __future__ import annotations

import io
import os
import subprocess
from pathlib import Path

import pytest

from rapc.errors import LoadError
from rapc.library.loader import load

from .command import COMMAND, HOME, rapc


def _files(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}


@pytest.mark.parametrize(
    ("data", "rule"),
    [
        (b"(" * 100_000, "nested-too-deeply"),
        (b")" * 100_000, "surplus-parenthesis"),
        (b"(a " * 100_000 + b")" * 100_000, "nested-too-deeply"),
        (b"a" * 10_000_000, "too-long"),
        (b'"' + b"a" * 1_000_000, ""),
        (b"#|" * 50_000, ""),
        (b"'()[]{}`,@\\ \x1b[31m", ""),
        (b"(define-rap (wait) (contexts nil))", "unknown-clause"),
        (b"(define-rap (wait) (succeed (= 1 2 3)) (method 7 8 9))", ""),
        (b"; rapc: ignore[\n(define-rap)", ""),
        ("(define-rup (n\u0303\u202e ?\u65e5))".encode(), "unknown-form"),
    ],
    ids=range(11),
)
def test_bad_text_is_found_fault_with(data: bytes, rule: str, tmp_path: Path) -> None:
    (tmp_path / "bad.rap").write_bytes(data)
    before = _files(tmp_path)
    for output_format in ("full", "concise", "json"):
        done = rapc("check", "bad.rap", "--output-format", output_format, cwd=tmp_path)
        assert (done.returncode, done.stderr) == (1, "")
        assert "bad.rap" in done.stdout
        assert rule in done.stdout
        assert "\x1b" not in done.stdout
        assert len(done.stdout) < 100_000
    assert _files(tmp_path) == before


def test_empty_file_is_clean(tmp_path: Path) -> None:
    (tmp_path / "empty.rap").touch()
    done = rapc("check", "empty.rap", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "checked 1 file, 0 RAPs: no findings\n"


def test_folder_without_programs_is_clean(tmp_path: Path) -> None:
    done = rapc("check", ".", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (
        0,
        "checked 0 files, 0 RAPs: no findings\n",
    )


def _binary(folder: Path) -> None:
    (folder / "bad.rap").write_bytes(b"\x7fELF\x02\x01\x00\x00(define-rap (a))")


def _not_utf8(folder: Path) -> None:
    (folder / "bad.rap").write_bytes(b"; fine\n; not: \xe4\n(define-rap (a))")


def _loop(folder: Path) -> None:
    (folder / "bad.rap").mkdir()
    (folder / "bad.rap" / "back").symlink_to("..", target_is_directory=True)


def _link_to_itself(folder: Path) -> None:
    (folder / "bad.rap").symlink_to("bad.rap")


def _nothing(folder: Path) -> None:
    assert not any(folder.iterdir())


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (_binary, "is a binary file"),
        (_not_utf8, "is not UTF-8: byte 0xe4 in line 2"),
        (_loop, "is a link to a folder that contains the link"),
        (_link_to_itself, "cannot read `bad.rap`"),
        (_nothing, "does not exist"),
    ],
)
def test_unreadable_input_is_reported_on_one_line(
    make: object, words: str, tmp_path: Path
) -> None:
    assert callable(make)
    make(tmp_path)
    done = rapc("check", "bad.rap", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: ")
    assert words in done.stderr
    assert done.stderr.count("\n") == 1


def test_nothing_to_check_is_a_usage_error(tmp_path: Path) -> None:
    done = rapc("check", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "error: missing PATH: the working directory has no RAP files\n"
    )


def test_standard_input_named_twice_is_read_once() -> None:
    done = rapc("check", "-", "-", stdin="(define-rup (a))\n")
    assert done.returncode == 1
    assert "1 | (define-rup (a))" in done.stdout


def test_no_path_is_not_the_working_folder(tmp_path: Path) -> None:
    for command in ("check", "test"):
        done = rapc(command, "", cwd=tmp_path)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == "error: `` does not exist\n"


def test_closed_standard_input_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.stdin", None)
    with pytest.raises(
        LoadError, match="cannot read `<stdin>`: standard input is closed"
    ):
        load(["-"])


def test_closed_output_is_as_good_as_none(tmp_path: Path) -> None:
    (tmp_path / "go.rap").write_text("(define-rap (go) (method (task-net)))")
    for args in ("check go.rap", "compile go.rap --explain go", "worlds"):
        done = subprocess.run(
            ["/bin/sh", "-c", f"exec {COMMAND} {args} >&- 2>told"],
            cwd=tmp_path,
            env={"LANG": "C.UTF-8", **HOME},
            check=False,
        )
        told = (tmp_path / "told").read_text()
        assert (done.returncode, told) == (0, "")


def test_a_full_standard_error_leaves_the_status(tmp_path: Path) -> None:
    for args in ("check nope", "nonsense", "worlds nope", "check --nonsense"):
        done = subprocess.run(
            ["/bin/sh", "-c", f"exec {COMMAND} {args} 2>/dev/full"],
            cwd=tmp_path,
            env={"LANG": "C.UTF-8", **HOME},
            check=False,
            capture_output=True,
        )
        assert (done.returncode, done.stdout) == (2, b""), args


@pytest.mark.parametrize("command", ["check", "test", "compile"])
def test_special_file_is_not_read(command: str, tmp_path: Path) -> None:
    """It may never end, as a device, or never begin, as a pipe."""
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "folder" / "pipe.test.rap")
    os.mkfifo(tmp_path / "folder" / "pipe.rap")
    more = ("-o", "out") if command == "compile" else ()
    for path in ("pipe", "/dev/zero", "folder"):
        done = rapc(command, path, *more, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith("error: `")
        said = "is neither a file nor a folder; use `-` for standard input\n"
        assert done.stderr.endswith(said)


def test_experiments_and_options_are_not_read_from_there_either(
    tmp_path: Path,
) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "go.rap").write_text("(define-rap (go) (method (task-net)))")
    run = ("run", "go.rap", "--world", "truck", "--task", "(go)")
    no_file = "`{}` is neither a file nor a folder; use `-` for standard input"
    for args, path, said in (
        (("experiment", "pipe.toml"), "pipe.toml", no_file),
        (
            ("experiment", "folder.toml"),
            "folder.toml",
            "cannot read `{}`: it is a folder",
        ),
        ((*run, "--set", "truck.map=@pipe.toml"), "pipe.toml", no_file),
        ((*run, "--set", "truck.map=@/dev/zero"), "/dev/zero", no_file),
        ((*run, "--set", "truck.map=@"), "", "`{}` does not exist"),
    ):
        done = rapc(*args, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith(f"error: {said.format(path)}")
        assert done.stderr.count("\n") == 1


def test_counts_beyond_measure_are_refused(tmp_path: Path) -> None:
    for args, said in (
        (("experiment", "chapter6", "--seeds", "9" * 20), "1<=x<=100000"),
        (("experiment", "chapter6", "--jobs", "9" * 20), "1<=x<=1000"),
        (("experiment", "chapter6", "--seeds", "1.5"), "not a valid whole number"),
        (("test", ".", "--seeds", "9" * 20), "1<=x<=100000"),
    ):
        done = rapc(*args, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (2, "")
        assert said in done.stderr


def test_a_file_beyond_measure_is_not_read(tmp_path: Path) -> None:
    for begin in (b"", b"rapc-library 1 "):
        with (tmp_path / "huge.rap").open("wb") as file:
            file.write(begin)
            file.truncate(2**34)
        done = rapc("check", "huge.rap", cwd=tmp_path)
        assert (done.returncode, done.stdout) == (2, "")
        said = "error: `huge.rap` is too large: more than 200 MB\n"
        assert done.stderr == said


def test_standard_input_beyond_measure_is_not_read(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rapc.base.files.MAX_BYTES", 10)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b";" * 11)))
    with pytest.raises(LoadError, match="`<stdin>` is too large"):
        load(["-"])
