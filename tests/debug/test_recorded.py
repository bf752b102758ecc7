"""Recorded runs are opened by running them again, and compared."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.debug import recorded
from rapc.errors import LoadError
from tests.cli.command import rapc
from tests.debug.sessions import truck
from tests.repl.shells import said, truck_shell

RUN = ("examples/rock-order.rap", "--world", "truck", "--task", "(rock-order red 1)")


def test_a_trace_is_that_of_rapc_run(tmp_path: Path) -> None:
    mine, other = tmp_path / "mine.jsonl", tmp_path / "other.jsonl"
    rapc("run", *RUN, "-q", "--seed", "7", "--trace", str(other))
    shell = truck_shell()
    shell.answer(":run")
    assert " events in " in said(shell, f":record {mine}", width=200)
    told, expected = mine.read_text().splitlines(), other.read_text().splitlines()
    assert told[1:] == expected[1:]
    assert recorded.parting(shell.session, mine) is None


def test_a_recorded_run_is_opened_and_can_be_taken_back(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    rapc(
        "run",
        *RUN,
        *("-q", "--seed", "7", "--set", "truck.fuel=20"),
        *("--set", "rapc.futile-limit=3", "--trace", str(trace)),
    )
    done = rapc("repl", str(trace), "-c", ":back 5", "-c", "(truck-location ?x)")
    assert (done.returncode, done.stderr) == (0, "")
    assert "factory-1" in done.stdout


def test_facts_that_were_given_are_given_again(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    fact = ("--fact", "(truck-fuel 3)")
    rapc("run", *RUN, *fact, "-q", "--seed", "7", "--trace", str(trace))
    assert '"facts":["(truck-fuel 3)"]' in trace.read_text().splitlines()[0]
    done = rapc("repl", str(trace), "-c", ":goto 0", "-c", "(truck-fuel ?x)")
    assert (done.returncode, done.stderr) == (0, "")
    assert "3" in done.stdout


def test_facts_that_a_program_gave_are_told_too(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    recorded.write(truck(facts=["(truck-fuel 3)"]), trace)
    assert recorded.beginnings(trace).facts == ("(truck-fuel 3)",)


def test_a_run_that_parts_from_the_recorded_one_says_where(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    rapc("run", *RUN, "-q", "--seed", "7", "--trace", str(trace))
    lines = trace.read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if '"cycle":30,' in line)
    lines[at] = lines[at].replace('"event":"', '"event":"x-')
    trace.write_text("\n".join(lines) + "\n")
    done = rapc("repl", str(trace), "-c", ":show")
    assert "is not the one that was recorded, from cycle 30 on" in done.stderr


def test_the_first_decision_that_differs_is_told(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    other = truck(seed=8)
    other.go()
    recorded.write(other, trace)
    shell = truck_shell()
    shell.answer(":run")
    text = said(shell, f":diff {trace}", width=200)
    assert text.startswith("the first decision that differs, in cycle ")
    assert "  here:  " in text
    assert "  there: " in text


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("hello", "is no trace"),
        ("[]", "line 1 is no event"),
        ('{"event":"signal"}', "no trace of a run from its beginning"),
        ('{"event":"run-started"}', "is no trace"),
        ("", "no trace of a run from its beginning"),
    ],
)
def test_what_is_no_trace_is_said(text: str, why: str, tmp_path: Path) -> None:
    file = tmp_path / "run.jsonl"
    file.write_text(text)
    with pytest.raises(LoadError, match=why):
        recorded.beginnings(file)


def test_what_cannot_be_begun_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "run.jsonl"
    file.write_text("hello")
    done = rapc("repl", str(file))
    assert done.returncode == 2
    assert "is no trace" in done.stderr
    assert rapc("repl", str(tmp_path / "none.jsonl")).returncode == 2
    assert "a world is missing" in rapc("repl", "examples/rock-order.rap").stderr
