"""`rapc fmt` as a user meets it."""

from __future__ import annotations

from pathlib import Path

from .command import rapc

ROUGH = "(define-rap (a)(succeed (b)))\n"
FINE = "(define-rap (a)\n  (succeed (b)))\n"


def test_files_and_tests_below_a_folder_are_laid_out_in_place(tmp_path: Path) -> None:
    for name in ("one.rap", "two.test.rap", "fine.rap", "other.txt"):
        (tmp_path / name).write_text(FINE if name == "fine.rap" else ROUGH)
    done = rapc("fmt", ".", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "2 files reformatted, 1 file unchanged\n"
    assert (tmp_path / "one.rap").read_text() == FINE
    assert (tmp_path / "two.test.rap").read_text() == FINE
    assert (tmp_path / "other.txt").read_text() == ROUGH
    assert rapc("fmt", ".", cwd=tmp_path).stdout == "3 files unchanged\n"


def test_check_and_diff_change_nothing(tmp_path: Path) -> None:
    file = tmp_path / "one.rap"
    file.write_text(ROUGH)
    done = rapc("fmt", "--check", "one.rap", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout == "would reformat one.rap\n1 file would be reformatted\n"
    done = rapc("fmt", "--diff", "one.rap", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "1 file would be reformatted\n")
    assert done.stdout == (
        "--- one.rap\n+++ one.rap\n@@ -1 +1,2 @@\n"
        "-(define-rap (a)(succeed (b)))\n+(define-rap (a)\n+  (succeed (b)))\n"
    )
    assert file.read_text() == ROUGH
    file.write_text(FINE)
    assert rapc("fmt", "--check", "-q", "one.rap", cwd=tmp_path).stdout == ""


def test_a_faulty_file_is_left_and_the_others_are_laid_out(tmp_path: Path) -> None:
    (tmp_path / "faulty.rap").write_text("(define-rap (a)")
    (tmp_path / "one.rap").write_text(ROUGH)
    done = rapc("fmt", ".", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (2, "")
    assert "error[RAP001 missing-parenthesis]" in done.stdout
    assert done.stdout.endswith("1 file reformatted, 1 file cannot be formatted\n")
    assert (tmp_path / "faulty.rap").read_text() == "(define-rap (a)"
    assert (tmp_path / "one.rap").read_text() == FINE


def test_standard_input_goes_to_standard_output() -> None:
    done = rapc("fmt", "-", stdin=ROUGH)
    assert (done.returncode, done.stdout, done.stderr) == (0, FINE, "")
    done = rapc("fmt", "--check", "-", stdin=ROUGH)
    assert (done.returncode, done.stdout) == (1, "would reformat <stdin>\n")


def test_missing_file_is_refused(tmp_path: Path) -> None:
    done = rapc("fmt", "none.rap", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: `none.rap` does not exist\n"


def test_line_ends_stay(tmp_path: Path) -> None:
    file = tmp_path / "one.rap"
    file.write_bytes(ROUGH.replace("\n", "\r\n").encode())
    assert rapc("fmt", "one.rap", cwd=tmp_path).returncode == 0
    assert file.read_bytes() == FINE.replace("\n", "\r\n").encode()
