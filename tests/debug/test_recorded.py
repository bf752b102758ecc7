"""Recorded runs are opened by running them again, and compared."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.debug import recorded
from rapc.debug.tape import Tape
from rapc.errors import LoadError
from rapc.repl.commands.table import commands
from rapc.repl.complete import candidates
from rapc.repl.shell import Shell
from tests.cli.command import rapc
from tests.debug.sessions import truck
from tests.repl.shells import rows, said, truck_shell

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


@pytest.mark.parametrize(
    "folder", ["/an/old place/stdlib/truck/", "C:\\\\rapc\\\\truck\\\\"]
)
def test_a_trace_from_elsewhere_is_the_same_run(folder: str, tmp_path: Path) -> None:
    mine, other = tmp_path / "mine.jsonl", tmp_path / "other.jsonl"
    options = {"arm1-drops": 90, "arm2-drops": 90}
    shell = Shell(truck(options=options), commands())
    shell.answer(":to at 300")
    said(shell, f":record {mine}", width=200)
    told = mine.read_text()
    assert told.count("rapc:truck/") > 1
    other.write_text(told.replace("rapc:truck/", folder))
    assert recorded.parting(shell.session, other) is None
    other.write_text(told.replace("rapc:truck/grasping", "rapc:truck/moving"))
    assert recorded.parting(shell.session, other) is not None


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
    recorded.write_trace(truck(facts=["(truck-fuel 3)"]), trace)
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
    recorded.write_trace(other, trace)
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
    for given in (("--world", "truck"), ("--task", "(a)"), ("--fact", "(a)")):
        done = rapc("repl", *given)
        assert (done.returncode, "a library is missing" in done.stderr) == (2, True)


def test_a_trace_has_the_digest_of_its_library(tmp_path: Path) -> None:
    trace, library = tmp_path / "run.jsonl", tmp_path / "say.rap"
    library.write_text(SAY)
    run = ("run", str(library), "--world", "truck", "--task", "(look-about)")
    rapc(*run, "-q", "--trace", str(trace))
    library.write_text(f"{SAY}; more is said\n")
    done = rapc("repl", str(trace), "-c", ":back")
    assert done.stderr == (
        "the library is not the one that was recorded: its text is another\n"
    )
    library.unlink()
    done = rapc("repl", str(trace), "-c", ":run", "-c", ":tree")
    assert done.returncode == 0
    assert done.stderr == f"only to look at: `{library}` does not exist\n"
    assert "run over (done)" in done.stdout


SAY = """
(require "truck")
(define-rap (look-about) (method (primitive (eye-scan external))))
"""


def test_a_run_that_was_broken_off_is_opened_where_it_was(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    rapc("run", *RUN, "-q", "--seed", "7", "--until", "90", "--trace", str(trace))
    done = rapc("repl", str(trace), "-c", ":show none", "-c", ":step")
    assert (done.returncode, done.stderr) == (0, "")
    assert "cycle 42, time " in done.stdout


def _looked_at(tmp_path: Path) -> tuple[Shell, Shell]:
    """Return a shell with a run and one with its trace, only to look at."""
    trace = tmp_path / "run.jsonl"
    shell = truck_shell("(rock-order red 1) :deadline 200")
    shell.answer(":run")
    shell.answer(f":record {trace}")
    shell.answer(":goto 0")
    return shell, Shell(Tape.open(trace), commands())


def test_what_is_only_looked_at_tells_what_the_run_tells(tmp_path: Path) -> None:
    shell, tape = _looked_at(tmp_path)
    for text in (
        ":show all",
        ":step 20",
        ":trace 3",
        ":to at 100",
        ":primitive",
        ":find fact-asserted bay2",
        ":find back method-chosen task=12",
        ":goto 150",
        ":timeline",
        ":timeline 20 90",
        ":history (truck-location ?where)",
        ":history item-1 location",
        ":retries",
        ":run",
        ":deadlines",
        ":back",
        ":back 3",
        ":goto at 60",
        ":goto end",
    ):
        assert said(tape, text) == said(shell, text), text
    shell.answer(":goto 60")
    tape.answer(":goto 60")
    trees = [rows(one, ":tree") for one in (shell, tape)]
    assert [(row[0], row[2]) for row in trees[0]] == [
        (row[0], row[2]) for row in trees[1]
    ]


def test_what_needs_the_run_is_refused_in_a_line(tmp_path: Path) -> None:
    _, tape = _looked_at(tmp_path)
    told = {":help", ":show requests"}
    for command in commands():
        for text in command.examples:
            answer = tape.answer(text)
            if answer.failed and text not in told:
                assert len(answer.lines) == 1, text
    for text in (":why", ":agenda", "(place ?x ?y)", "(rock-order red 1)", ":break"):
        assert "a recorded run without what it ran" in said(tape, text, width=200)
    assert [one.text for one in candidates(tape, "(plac")] == []
    assert ":step" in [one.text for one in candidates(tape, ":st")]
    assert candidates(tape, ":source ") == []


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ('{"event":"frob","n":1}', "line 2 is an event `frob`, which is not known"),
        ('{"event":"task-selected","n":1}', "line 2 has no `cycle`"),
        ('{"event":"task-removed","n":7,"cycle":1,"time":0}', "line 2 has no `task`"),
    ],
)
def test_a_trace_that_makes_no_sense_is_not_looked_at(
    line: str, why: str, tmp_path: Path
) -> None:
    trace = tmp_path / "run.jsonl"
    recorded.write_trace(truck(), trace)
    first = trace.read_text().splitlines()[0]
    trace.write_text(f"{first}\n{line}\n")
    with pytest.raises(LoadError, match=why):
        Tape.open(trace)
