"""`rapc compare`: two runs, a run and a library, two libraries over seeds."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.command import rapc

COURIER = "examples/courier"
SHIFT = ("--world", "courier", "--agenda", "shift", "--until", "3000")


@pytest.fixture
def slow(tmp_path: Path) -> str:
    """Return a courier library whose robot waits for a battery that is never full."""
    for file in Path(COURIER).glob("*.rap"):
        text = file.read_text().replace("(>= ?level 90)", "(> ?level 100)")
        (tmp_path / file.name).write_text(text)
    return str(tmp_path)


def _recorded(library: str, file: Path) -> str:
    run = ("run", library, *SHIFT, "--seed", "1", "-q", "--trace", str(file))
    assert rapc(*run).returncode == 0
    return str(file)


def test_two_recorded_runs_are_compared(slow: str, tmp_path: Path) -> None:
    good = _recorded(COURIER, tmp_path / "good.jsonl")
    bad = _recorded(slow, tmp_path / "bad.jsonl")
    done = rapc("compare", good, bad)
    assert (done.returncode, done.stderr) == (1, "")
    lines = done.stdout.splitlines()
    assert lines[0] == "time: before 831, after 1118 (+34.5 %)"
    assert lines[1] == "first different decision, in cycle 24:"
    assert rapc("compare", bad, good).returncode == 0
    assert rapc("compare", good, bad, "--threshold", "35").returncode == 0
    assert rapc("compare", good, good).returncode == 0
    [record] = rapc("compare", good, bad, "--json").stdout.splitlines()
    found = json.loads(record)
    assert found["worse"]
    assert found["rows"][0] == {
        "of": "run",
        "what": "time",
        "before": 831,
        "after": 1118,
        "difference": "+287",
        "± 95 %": None,
        "": "+35 %",
    }


def test_recorded_run_is_compared_with_a_library(slow: str, tmp_path: Path) -> None:
    good = _recorded(COURIER, tmp_path / "good.jsonl")
    done = rapc("compare", good, slow)
    assert done.returncode == 1
    assert done.stdout.startswith("time: before 831, after 1118 (+34.5 %)\n")
    told = " ".join(done.stdout.split())
    assert told.endswith("charging.rap:11:1: query `charged` changed")
    assert rapc("compare", good, COURIER).stdout.splitlines() == [
        "no difference in time and successes",
        "no difference in decisions",
        "no difference in times",
    ]


def test_report_of_a_run_is_compared(slow: str, tmp_path: Path) -> None:
    report, good = str(tmp_path / "run.bug"), tmp_path / "good.jsonl"
    assert rapc("bug", slow, *SHIFT, "--seed", "1", "-o", report).returncode == 0
    done = rapc("compare", report, COURIER)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("time: before 1118, after 831 (-25.7 %)\n")
    assert "charging.rap:11:1: query `charged` changed" in done.stdout
    found = rapc("compare", _recorded(COURIER, good), report)
    assert found.stdout.startswith("time: before 831, after 1118 (+34.5 %)\n")
    diff = rapc("repl", str(good), "-c", f":diff {report}")
    assert "here; use `rapc compare`" in " ".join(diff.stdout.split())


def test_library_beside_a_recorded_run_is_stopped(tmp_path: Path) -> None:
    trace = tmp_path / "good.jsonl"
    run = ("run", COURIER, "--world", "courier", "--agenda", "shift", "--seed", "1")
    assert rapc(*run, "-q", "--trace", str(trace)).returncode == 0
    for file in Path(COURIER).glob("*.rap"):
        text = file.read_text().replace("(< ?level 48)", "(< ?level 85)")
        (tmp_path / file.name).write_text(text)
    done = rapc("compare", str(trace), str(tmp_path))
    assert done.stdout.startswith("time: before 831, after 8310 (+900.0 %)\n")
    assert done.returncode == 1


def test_libraries_are_compared_over_seeds(slow: str) -> None:
    run = ("compare", COURIER, slow, *SHIFT, "--seeds", "4")
    done = rapc(*run, "--seed", "1")
    assert done.stdout.splitlines()[:3] == [
        "no difference in time and successes",
        "slower in 3 of 4 seeds, faster in 1, equal in all figures in 0",
        "seed 1: first different decision, in cycle 24:",
    ]
    assert done.returncode == 0  # 4 seeds are too few for the confidence interval
    assert "± 95 %" in done.stdout
    same = rapc("compare", COURIER, COURIER, *SHIFT, "--seeds", "2", "--jobs", "1")
    assert same.stdout.splitlines() == [
        "no difference in time and successes",
        "slower in 0 of 2 seeds, faster in 0, equal in all figures in 2",
        "seed 0: no difference in decisions",
        "no difference in times",
    ]
    assert same.returncode == 0


def test_fewer_successes_are_worse_than_more_time(tmp_path: Path) -> None:
    for file in Path(COURIER).glob("*.rap"):
        text = file.read_text().replace("(< ?level 48)", "(< ?level 18)")
        (tmp_path / file.name).write_text(text)
    done = rapc("compare", COURIER, str(tmp_path), *SHIFT, "--seed", "1")
    assert done.returncode == 1
    assert "tasks succeeded: before 3, after 1" in done.stdout
    assert rapc("compare", str(tmp_path), COURIER, *SHIFT).returncode == 0


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ((COURIER, COURIER), "missing --world"),
        ((COURIER, COURIER, "--world", "courier"), "missing --task or --agenda"),
        ((COURIER, COURIER, *SHIFT, "--jobs", "2"), "--jobs requires --seeds"),
        (
            (COURIER, COURIER, *SHIFT, "--seeds", "2", "--fault", "(dock) stuck"),
            "cannot combine --seeds and --fault",
        ),
        (("a.jsonl", "b.jsonl", "--seeds", "2"), "start of a recorded run"),
        (("a.jsonl", "b.jsonl", "--seed", "2"), "start of a recorded run"),
        (("a.jsonl", "b.jsonl"), "cannot read `a.jsonl`"),
        (("nowhere", COURIER), "does not exist"),
    ],
)
def test_invalid_comparisons_are_refused(given: tuple[str, ...], why: str) -> None:
    done = rapc("compare", *given)
    assert (done.returncode, done.stdout) == (2, "")
    assert why in done.stderr
