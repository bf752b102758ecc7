"""`rapc check --fix`, `--diff` and `--unsafe-fixes`: what they change, and what not."""

from __future__ import annotations

import signal
import subprocess
from pathlib import Path

import pytest

from .command import COMMAND, HOME, PATIENCE, rapc

UNUSED = "; rapc: ignore[unknown-rap] nothing to ignore\n(define-rap (wait))\n"
FIXED = "(define-rap (wait))\n"

UNSAFE = """\
(define-rap (walk ?place)
  (method (task-net (t1 (wait ?place))))

(define-rap (wait ?place))
"""


def test_safe_fixes_are_carried_out_and_reported(tmp_path: Path) -> None:
    file = tmp_path / "one.rap"
    file.write_text(UNUSED)
    done = rapc("check", "one.rap", cwd=tmp_path)
    assert done.stdout.endswith("1 warning; 1 fixable with --fix\n")
    done = rapc("check", "--fix", "one.rap", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "checked 1 file, 1 RAP: no findings, 1 fix applied\n"
    assert file.read_text() == FIXED


def test_a_difference_is_shown_and_nothing_written(tmp_path: Path) -> None:
    file = tmp_path / "one.rap"
    file.write_text(UNUSED)
    done = rapc("check", "--diff", "one.rap", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "1 fix would be applied\n")
    assert done.stdout == (
        "--- one.rap\n+++ one.rap\n@@ -1,2 +1 @@\n"
        "-; rapc: ignore[unknown-rap] nothing to ignore\n (define-rap (wait))\n"
    )
    assert file.read_text() == UNUSED
    file.write_text(FIXED)
    done = rapc("check", "--diff", "one.rap", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "")


def test_unsafe_fixes_only_if_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "one.rap"
    file.write_text(UNSAFE)
    before = rapc("check", "one.rap", cwd=tmp_path)
    assert "fixable with --fix --unsafe-fixes" in before.stdout
    rapc("check", "--fix", "one.rap", cwd=tmp_path)
    assert file.read_text() == UNSAFE
    done = rapc("check", "--fix", "--unsafe-fixes", "one.rap", cwd=tmp_path)
    assert done.returncode == 0
    assert file.read_text() == UNSAFE.replace("))))", ")))))")


def test_useless_fixes_are_counted_and_not_offered(
    tmp_path: Path,
) -> None:
    """The parenthesis hides a misplaced clause, an unknown fact and a primitive."""
    file = tmp_path / "one.rap"
    text = "(define-rap (go ?place)\n  (succeed (at ?place))\n  (context (at home))\n"
    text += "  (method\n    (primitive (drive ?place)))\n"
    file.write_text(text)
    done = rapc("check", "--fix", "--unsafe-fixes", "one.rap", cwd=tmp_path)
    assert done.stdout.endswith(": 1 error, 1 fix rejected\n")
    assert (done.returncode, file.read_text()) == (1, text)


def test_line_ends_mark_and_mode_of_a_file_stay(tmp_path: Path) -> None:
    file = tmp_path / "one.rap"
    file.write_bytes(b"\xef\xbb\xbf" + UNUSED.replace("\n", "\r\n").encode())
    file.chmod(0o640)
    assert rapc("check", "--fix", "one.rap", cwd=tmp_path).returncode == 0
    assert file.read_bytes() == b"\xef\xbb\xbf" + FIXED.replace("\n", "\r\n").encode()
    assert file.stat().st_mode & 0o777 == 0o640


def test_unnamed_files_are_unchanged(tmp_path: Path) -> None:
    other = tmp_path / "other.rap"
    other.write_text(UNSAFE)
    (tmp_path / "one.rap").write_text('(require "other")\n')
    done = rapc("check", "--fix", "--unsafe-fixes", "one.rap", cwd=tmp_path)
    assert done.returncode == 1
    assert other.read_text() == UNSAFE


def test_a_text_on_standard_input_is_mended_on_standard_output(tmp_path: Path) -> None:
    done = rapc("check", "--fix", "-", cwd=tmp_path, stdin=UNUSED)
    assert (done.returncode, done.stdout) == (0, FIXED)
    assert done.stderr.startswith("checked 1 file")
    done = rapc("check", "--fix", "-", cwd=tmp_path, stdin="(define-rap (a ")
    assert done.returncode == 1
    assert done.stdout == "(define-rap (a "


def test_a_text_on_standard_input_may_have_a_name(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "walk.rap").write_text("(define-rap (walk))\n")
    text = '(require "walk")\n(define-rap (go) (method (task-net (t1 (walk)))))\n'
    named = ("check", "-", "--stdin-filename", "lib/new.rap")
    done = rapc(*named, cwd=tmp_path, stdin=text)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "checked 2 files, 2 RAPs: no findings\n"
    done = rapc(*named, cwd=tmp_path, stdin=text.replace("(walk)", "(wolk)"))
    assert "--> lib/new.rap:2:" in done.stdout


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("--unsafe-fixes",), "--unsafe-fixes requires --fix or --diff"),
        (("--stdin-filename", "a"), "--stdin-filename requires the path `-`"),
        (
            ("--isolated", "--config", "rapc.toml"),
            "cannot combine --config and --isolated",
        ),
        (
            ("--fix", "--write-baseline", "b"),
            "cannot combine --write-baseline with --fix or --diff",
        ),
        (
            ("--per-file-ignores", "a.rap"),
            "--per-file-ignores: `a.rap` is not PATTERN:RULES",
        ),
        (
            ("--per-file-ignores", "a.rap:unused-clam"),
            "unknown rule `unused-clam`; did you mean `unused-claim`?",
        ),
    ],
)
def test_incompatible_options(args: tuple[str, ...], said: str, tmp_path: Path) -> None:
    (tmp_path / "one.rap").write_text(UNUSED)
    done = rapc("check", "one.rap", *args, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"error: {said}\n"
    assert (tmp_path / "one.rap").read_text() == UNUSED


def _put(file: Path, text: str) -> None:
    """Write a file so that nobody finds it empty or half written."""
    file.with_suffix(".new").write_text(text)
    file.with_suffix(".new").replace(file)


def test_a_library_is_watched_until_ctrl_c(tmp_path: Path) -> None:
    file = tmp_path / "one.rap"
    file.write_text("(define-rap (go))\n")
    child = subprocess.Popen(
        [COMMAND, "check", "--watch", "."],
        cwd=tmp_path,
        env={"PATH": "", **HOME},
        stdout=subprocess.PIPE,
        encoding="utf-8",
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "checked 1 file, 1 RAP: no findings\n"
    _put(file, "(define-rap (go) (succeed (there)))\n")
    assert "error[RAP015 undeclared-predicate]" in child.stdout.readline()
    while not child.stdout.readline().startswith("checked"):
        pass
    _put(tmp_path / "two.rap", "(declare-memory-proposition there ())\n")
    assert child.stdout.readline() == "checked 2 files, 1 RAP: no findings\n"
    child.send_signal(signal.SIGINT)
    assert child.wait(PATIENCE) == 0
    child.stdout.close()
