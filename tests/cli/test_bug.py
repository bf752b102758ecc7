"""`rapc bug`: a run in one file, which `rapc repl` repeats."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from tests.cli.command import rapc

CHECKOUT = Path(__file__).parents[2]
RUN = ("--world", "courier", "--agenda", "shift", "--seed", "4")


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A report of a shift of the courier."""
    folder = tmp_path_factory.mktemp("bug")
    shutil.copytree(CHECKOUT / "examples" / "courier", folder / "courier")
    done = rapc("bug", "courier", *RUN, "-o", "shift.bug", cwd=folder)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    return (folder / "shift.bug").read_bytes()


def test_a_report_is_repeated_without_the_library(
    report: bytes, tmp_path: Path
) -> None:
    (tmp_path / "shift.bug").write_bytes(report)
    done = rapc("repl", "shift.bug", "-c", ":goto 100", "-c", ":goto end", cwd=tmp_path)
    assert done.stdout.splitlines() == [
        "cycle 100, time 615",
        "cycle 225, time 1236, run ended (done)",
    ]
    assert (done.returncode, done.stderr) == (0, "")


def test_a_report_of_a_recorded_run_is_the_same(report: bytes, tmp_path: Path) -> None:
    shutil.copytree(CHECKOUT / "examples" / "courier", tmp_path / "courier")
    rapc("run", "courier", *RUN, "--trace", "shift.jsonl", cwd=tmp_path)
    done = rapc("bug", "shift.jsonl", "-o", "again.bug", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "again.bug").read_bytes() == report


def test_a_report_from_the_debugger_has_the_acts(tmp_path: Path) -> None:
    library = str(CHECKOUT / "examples" / "courier")
    inputs = (":step 20", ":assert (call ward-3)", ":step 10", ":bug x.bug", ":world")
    commands = [part for one in inputs for part in ("-c", one)]
    first = rapc("repl", library, *RUN, *commands, cwd=tmp_path)
    assert "report written to x.bug; repeat the run with `rapc repl x.bug`" in (
        first.stdout
    )
    done = rapc("repl", "x.bug", "-c", ":world", "-c", ":branches", cwd=tmp_path)
    world, branches = done.stdout.split("    branch")
    assert first.stdout.endswith(world)
    assert "20: asserted (call ward-3)" in branches


def test_differences_from_a_report_are_warnings(report: bytes, tmp_path: Path) -> None:
    head, *lines = report.decode().splitlines()
    told = json.loads(head)
    told["versions"]["rapc"] = "0.0.9"
    told["spec"]["seed"] = 5
    changed = "\n".join([json.dumps(told), *lines])
    (tmp_path / "x.bug").write_text(changed)
    done = rapc("repl", "x.bug", "-c", ":agenda", cwd=tmp_path)
    versions, run = done.stderr.splitlines()
    assert versions.startswith("warning: the report was written by rapc 0.0.9 and ")
    assert run.startswith("warning: the run differs from the report: cycle ")
    assert run.endswith("not cycle 225, time 1236, 1809 events, run ended (done)")
    assert done.returncode == 0


def test_a_report_imports_no_module(report: bytes, tmp_path: Path) -> None:
    (tmp_path / "evil.py").write_text("raise SystemExit('imported')")
    named = report.replace(b'"world-class":""', b'"world-class":"evil:World"', 1)
    assert named != report
    (tmp_path / "x.bug").write_bytes(named)
    done = rapc("repl", "x.bug", "-c", ":agenda", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr == (
        "error: cannot repeat `x.bug`: the code of the world `evil:World` is run "
        "only with `--world evil:World`\n"
    )


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("bug", "courier", *RUN), "error: missing -o / --output"),
        (("bug", "courier", *RUN, "-o", "x"), "-o: the file name must end with `.bug`"),
        (("bug", "courier", "-o", "x.bug"), "error: missing --world"),
        (("bug", "none", *RUN, "-o", "x.bug"), "error: `none` does not exist"),
        (("bug", "courier", *RUN, "-o", "notes.bug"), "the file is not a bug report"),
        (("repl", "none.bug"), "error: cannot read `none.bug`"),
        (("repl", "notes.bug"), "error: `notes.bug` is not a bug report of rapc"),
        (("repl", "notes.bug", "--seed", "3"), "cannot change the start of a recorded"),
    ],
)
def test_impossible_reports_are_refused(
    args: tuple[str, ...], said: str, tmp_path: Path
) -> None:
    shutil.copytree(CHECKOUT / "examples" / "courier", tmp_path / "courier")
    (tmp_path / "notes.bug").write_text("my notes")
    done = rapc(*args, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert (tmp_path / "notes.bug").read_text() == "my notes"
    assert not (tmp_path / "x.bug").exists()
