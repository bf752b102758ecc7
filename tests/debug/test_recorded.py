"""Recorded runs are opened by running them again, and compared."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from rapc.debug import recorded
from rapc.debug.history import History
from rapc.debug.recorded import Replay
from rapc.debug.recording import Playback, Recording
from rapc.errors import LoadError
from rapc.repl.commands.table import commands
from rapc.repl.complete import candidates
from rapc.repl.shell import Shell
from tests.cli.command import rapc
from tests.debug.sessions import truck
from tests.repl.shells import rows, said, truck_shell

RUN = ("examples/rock-order.rap", "--world", "truck", "--task", "(rock-order red 1)")


def test_trace_equals_the_trace_of_rapc_run(tmp_path: Path) -> None:
    mine, other = tmp_path / "mine.jsonl", tmp_path / "other.jsonl"
    rapc("run", *RUN, "-q", "--seed", "7", "--trace", str(other))
    shell = truck_shell()
    shell.answer(":run")
    assert " events written to " in said(shell, f":record {mine}", width=200)
    told, expected = mine.read_text().splitlines(), other.read_text().splitlines()
    assert told[1:] == expected[1:]
    assert _parted(mine) is None


def _parted(trace: Path) -> int | None:
    """Return the first cycle in which a truck's run differs from its recording."""
    recording = Recording(trace)
    options = dict(recording.begun.options)
    replay = Replay(truck(options=options), recording)
    session = replay._history
    session.go(heed=False)
    assert session.over
    return replay.parted


@pytest.mark.parametrize(
    "folder", ["/an/old place/stdlib/truck/", "C:\\\\rapc\\\\truck\\\\"]
)
def test_a_trace_from_elsewhere_is_the_same_run(folder: str, tmp_path: Path) -> None:
    mine, other = tmp_path / "mine.jsonl", tmp_path / "other.jsonl"
    options = {"arm1-drops": 90, "arm2-drops": 90}
    shell = Shell(truck(options=options), commands())
    shell.answer(":run")
    said(shell, f":record {mine}", width=200)
    told = mine.read_text().replace(
        '"options":{}', '"options":{"arm1-drops":90,"arm2-drops":90}'
    )
    assert told.count("rapc:truck/") > 1
    other.write_text(told.replace("rapc:truck/", folder))
    assert _parted(other) is None
    other.write_text(told.replace("rapc:truck/grasping", "rapc:truck/moving"))
    assert _parted(other) is not None


def test_a_recorded_run_begins_at_its_beginning_and_goes_to_its_end(
    tmp_path: Path,
) -> None:
    trace = tmp_path / "run.jsonl"
    rapc(
        "run",
        *RUN,
        *("-q", "--seed", "7", "--set", "truck.fuel=20"),
        *("--set", "rapc.futile-limit=3", "--trace", str(trace)),
    )
    typed = (":show none", ":step", ":goto end", ":back 5", "(truck-location ?x)")
    inputs = [part for text in typed for part in ("-c", text)]
    done = rapc("repl", str(trace), *inputs)
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[1] == "cycle 1, time 0"
    last = Recording(trace).last_cycle
    assert lines[2].startswith(f"cycle {last},")
    assert lines[2].endswith("run ended (done)")
    assert lines[3].startswith(f"cycle {last - 4},")
    assert "factory-1" in done.stdout


def test_act_before_the_end_of_a_recording_begins_a_branch(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    rapc("run", *RUN, "-q", "--seed", "7", "--trace", str(trace))
    recording = Recording(trace)
    replay = Replay(truck(), recording)
    shell = Shell(replay._history, commands())
    shell.answer(":show none")
    assert "on branch-1" in said(shell, ":step 5", ":assert (truck-fuel 1)")
    assert "run ended" in said(shell, ":run")
    assert said(shell, ":branch main", ":goto end").startswith(
        f"cycle {recording.last_cycle},"
    )
    assert replay.parted is None


def test_initial_facts_are_exported(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    fact = ("--fact", "(truck-fuel 3)")
    rapc("run", *RUN, *fact, "-q", "--seed", "7", "--trace", str(trace))
    assert '"facts":["(truck-fuel 3)"]' in trace.read_text().splitlines()[0]
    done = rapc("repl", str(trace), "-c", ":goto 0", "-c", "(truck-fuel ?x)")
    assert (done.returncode, done.stderr) == (0, "")
    assert "3" in done.stdout


def test_facts_of_a_program_are_shown(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    recorded.write_trace(truck(facts=["(truck-fuel 3)"]), trace)
    assert Recording(trace).begun.facts == ("(truck-fuel 3)",)


def test_first_difference_from_the_recording_is_named(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    rapc("run", *RUN, "-q", "--seed", "7", "--trace", str(trace))
    lines = trace.read_text().splitlines()
    at = next(i for i, line in enumerate(lines) if '"cycle":30,' in line)
    lines[at] = lines[at].replace('"event":"', '"event":"x-')
    trace.write_text("\n".join(lines) + "\n")
    where = "the run differs from the recording from cycle 30 on (line"
    run = ("-c", ":show none", "-c", ":run", "-c", ":run")
    told = rapc("repl", str(trace), *run).stdout.splitlines()
    assert told[1].startswith(f"stopped: {where}")
    assert told[-2].startswith("cycle 30,")
    assert told[-1].endswith("run ended (done)")
    told = rapc(
        "repl", str(trace), "-c", ":goto end", "-c", ":back"
    ).stdout.splitlines()
    assert [line.startswith(where) for line in told] == [True, False, False]


def test_first_different_decision_is_reported(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    other = truck(seed=8)
    other.go()
    recorded.write_trace(other, trace)
    shell = truck_shell()
    shell.answer(":run")
    text = said(shell, f":diff {trace}", width=200)
    assert text.startswith("time: here 274.77, there 261.22 (-4.9 %)\n")
    assert "\nfirst different decision, in cycle 11:\n  here: " in text
    assert "\n  there: " in text


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("hello", "is not a trace: line 1: "),
        ("[]", "is not a trace: line 1: expected `object`, got `array`"),
        ('{"event":"signal"}', "not a trace from the start of a run"),
        ('{"event":"run-started"}', "line 1: object missing required field `spec`"),
        (
            '{"event":"run-started","format":1,"library":"a.rap"}',
            "was written by another version of rapc: trace format 1, not 2",
        ),
        ("", "not a trace from the start of a run"),
        ("[" * 100_000, "line 1: "),
        (
            '{"event":"run-started","x":' + "[" * 100_000,
            "line 1: nested too deeply",
        ),
    ],
)
def test_invalid_trace_is_reported(text: str, why: str, tmp_path: Path) -> None:
    file = tmp_path / "run.jsonl"
    file.write_text(text)
    with pytest.raises(LoadError, match=why):
        Recording(file)


def test_invalid_start_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "run.jsonl"
    file.write_text("hello")
    done = rapc("repl", str(file))
    assert done.returncode == 2
    assert "is not a trace" in done.stderr
    assert rapc("repl", str(tmp_path / "none.jsonl")).returncode == 2
    assert "missing --world" in rapc("repl", "examples/rock-order.rap").stderr
    for given in (("--world", "truck"), ("--task", "(a)"), ("--fact", "(a)")):
        done = rapc("repl", *given)
        assert (done.returncode, "missing PATH of a library" in done.stderr) == (
            2,
            True,
        )


def test_a_trace_has_the_digest_of_its_library(tmp_path: Path) -> None:
    trace, library = tmp_path / "run.jsonl", tmp_path / "say.rap"
    library.write_text(SAY)
    run = ("run", str(library), "--world", "truck", "--task", "(look-about)")
    rapc(*run, "-q", "--trace", str(trace))
    library.write_text(f"{SAY}; more is said\n")
    done = rapc("repl", str(trace), "-c", ":back")
    assert done.stderr == ("warning: the library has changed since the recording\n")
    library.unlink()
    done = rapc("repl", str(trace), "-c", ":run", "-c", ":tree")
    assert done.returncode == 0
    assert done.stderr == f"opened read-only: `{library}` does not exist\n"
    assert "run ended (done)" in done.stdout


SAY = """
(require "truck")
(define-rap (look-about) (method (primitive (eye-scan external))))
"""


def test_interrupted_recording_opens_at_its_end(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    rapc("run", *RUN, "-q", "--seed", "7", "--until", "90", "--trace", str(trace))
    done = rapc("repl", str(trace), "-c", ":show none", "-c", ":run", "-c", ":step")
    assert (done.returncode, done.stderr) == (0, "")
    assert "stopped: end of the recording (until)\ncycle 41, time 70" in done.stdout
    assert "cycle 42, time " in done.stdout


@pytest.fixture
def lamps(tmp_path: Path) -> Path:
    """A folder with the lamps of the manual, and a recording of them."""
    for file in (*Path("tests/worlds/lamps").glob("lamps.*"),):
        shutil.copy(file, tmp_path)
    run = ("run", "lamps.rap", "--world", "lamps:LampWorld", "--task", "(light-all)")
    rapc(*run, "-q", "--trace", "l.jsonl", cwd=tmp_path)
    return tmp_path


def test_world_of_a_module_is_imported_only_if_the_user_names_it(lamps: Path) -> None:
    assert '"world-class":"lamps:LampWorld"' in (lamps / "l.jsonl").read_text()
    done = rapc("repl", "l.jsonl", "-c", ":step", "-c", "(room ?x)", cwd=lamps)
    assert done.stderr == (
        "opened read-only: the code of the world `lamps:LampWorld` is run only with "
        "`--world lamps:LampWorld`\n"
    )
    assert (done.returncode, "cycle 1, time 0" in done.stdout) == (1, True)
    again = ("repl", "l.jsonl", "--world", "lamps:LampWorld")
    done = rapc(*again, "-c", ":goto end", "-c", "(room ?x)", cwd=lamps)
    assert (done.returncode, done.stderr) == (0, "")
    assert "room-3" in done.stdout


@pytest.mark.parametrize("declared", ["", "(declare-primitive shine () (okay))\n"])
def test_recorded_run_without_a_world_is_run_again(
    declared: str, tmp_path: Path
) -> None:
    library, trace = tmp_path / "signs.rap", tmp_path / "signs.jsonl"
    text = "(declare-memory-proposition lit (?lamp))\n"
    text += "(define-rap (wait ?lamp) (succeed (lit ?lamp)))\n"
    library.write_text(text)
    run = ("repl", str(library), "--task", "(wait hall)", "--fact", "(lit hall)")
    rapc(*run, "-c", ":run", "-c", f":record {trace}")
    library.write_text(text + declared)
    done = rapc("repl", str(trace), "-c", ":goto end", "-c", "(lit ?x)")
    assert ("opened read-only: the script of its world" in done.stderr) == bool(
        declared
    )
    assert ("hall" in done.stdout) != bool(declared)


def test_recorded_run_of_a_module_becomes_a_test(lamps: Path) -> None:
    again = ("repl", "l.jsonl", "--world", "lamps:LampWorld", "-c", ":goto end")
    done = rapc(*again, "-c", ":export-test x.test.rap", cwd=lamps)
    assert done.stdout.splitlines()[1:] == [
        "test x written to x.test.rap; the test passes now",
        "`rapc test` requires `--world-module lamps`",
    ]
    assert '(world "lamps:LampWorld")' in (lamps / "x.test.rap").read_text()
    done = rapc("test", "x.test.rap", "--world-module", "lamps", cwd=lamps)
    assert done.returncode == 0


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            ("--world", "truck"),
            "was recorded in the world `lamps:LampWorld`, not in `tr",
        ),
        (("--world", "lamps:Lamp"), "the world `lamps:Lamp` cannot be loaded"),
        (("--task", "(light-all)"), "cannot change the start of a recorded run"),
        (("--seed", "3"), "cannot change the start of a recorded run"),
    ],
)
def test_recording_with_other_options_is_refused(
    lamps: Path, given: tuple[str, ...], message: str
) -> None:
    done = rapc("repl", "l.jsonl", *given, "-c", ":step", cwd=lamps)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr


def _looked_at(tmp_path: Path) -> tuple[Shell, Shell]:
    """Return a shell with a run and one with its trace, only to look at."""
    trace = tmp_path / "run.jsonl"
    shell = truck_shell("(rock-order red 1) :deadline 200")
    shell.answer(":run")
    shell.answer(f":record {trace}")
    shell.answer(":goto 0")
    return shell, Shell(History(Playback(Recording(trace))), commands())


def test_temporary_history_reports_like_the_run(tmp_path: Path) -> None:
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


def test_command_needing_a_run_is_refused_in_one_line(tmp_path: Path) -> None:
    _, tape = _looked_at(tmp_path)
    told = {":help", ":show requests"}
    for command in commands():
        for text in command.examples:
            answer = tape.answer(text)
            if answer.failed and text not in told:
                assert len(answer.lines) == 1, text
    for text in (":why", ":agenda", "(place ?x ?y)", "(rock-order red 1)", ":break"):
        assert "not available in a read-only recording" in said(tape, text, width=200)
    assert [one.text for one in candidates(tape, "(plac")] == []
    assert ":step" in [one.text for one in candidates(tape, ":st")]
    assert candidates(tape, ":source ") == []


def _all(recording: Recording) -> list[object]:
    return list(recording.scan(0, recording.rows))


@pytest.mark.parametrize(
    ("line", "why"),
    [
        (
            '{"event":"frob","n":1,"cycle":1,"time":0}',
            "the unknown event `frob`",
        ),
        (
            '{"event":"task-selected","n":1}',
            "line 2: object missing required field `cy",
        ),
        ('{"event":"task-removed","n":7,"cycle":1,"time":0}', "line 2 is out of order"),
        (
            '{"event":"task-removed","n":1,"cycle":"x","time":0}',
            "got `str` - at `$.cycle`",
        ),
        (
            '{"event":"task-removed","n":1,"cycle":1,"time":0}',
            "missing required field `tas",
        ),
        (
            '{"event":"run-started","n":1,"cycle":1,"time":0,"x":' + "[" * 99_999,
            "line 2: ",
        ),
    ],
)
def test_a_damaged_line_is_told_once_it_is_read(
    line: str, why: str, tmp_path: Path
) -> None:
    trace = tmp_path / "run.jsonl"
    recorded.write_trace(truck(), trace)
    first = trace.read_text().splitlines()[0]
    end = '{"event":"run-ended","n":2,"cycle":1,"time":0,"reason":"done","results":[],'
    end += '"waiting":[],"because":null}'
    trace.write_text(f"{first}\n{line}\n{end}\n")
    with pytest.raises(LoadError, match=re.escape(why)):
        _all(Recording(trace))


def test_a_recording_is_read_as_far_as_is_asked(tmp_path: Path) -> None:
    """What stands far behind a damaged line or in front of it can be looked at."""
    trace = tmp_path / "run.jsonl"
    run = truck("(rock-order red 4)")
    run.go()
    count = recorded.write_trace(run, trace)
    lines = trace.read_text().splitlines(keepends=True)
    damaged = count // 2
    lines[damaged] = "damaged\n"
    trace.write_text("".join(lines).replace('"world":"truck"', '"world":"gone"', 1))
    done = rapc("repl", str(trace), "-c", ":goto 100", "-c", ":tree", "-c", ":goto end")
    told = done.stdout.splitlines()
    assert told[0].startswith("cycle 100, time ")
    assert "rock-order red 4" in done.stdout
    assert f"is not a trace: line {damaged + 1}: " in " ".join(told[-2:])
    assert done.returncode == 1


def test_truncated_recording_ends_before_the_broken_line(tmp_path: Path) -> None:
    trace = tmp_path / "run.jsonl"
    run = truck()
    run.go()
    recorded.write_trace(run, trace)
    text = trace.read_text()
    trace.write_text(text[: len(text) * 2 // 3])
    done = rapc("repl", str(trace), "-c", ":show none", "-c", ":run")
    last = Recording(trace).last_cycle
    assert "stopped: end of the recording (cut off)" in done.stdout
    assert f"cycle {last - 1}, " in done.stdout
    tape = Shell(History(Playback(Recording(trace))), commands())
    assert f"cycle {last}, time " in said(tape, ":show none", ":run")
    assert said(tape, ":step").endswith("run ended (end of the recording)\n")
