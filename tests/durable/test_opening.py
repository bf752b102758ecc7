"""Journals in the debugger, of simulators and of worlds that cannot be saved."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from random import Random
from typing import Any

import pytest
from msgspec.structs import replace

import rapc
from rapc.debug.history import History
from rapc.debug.questions.ends import why_end
from rapc.debug.recorded import write_trace
from rapc.durable import folder as files
from rapc.durable import journal
from rapc.durable.folder import Options
from rapc.durable.opening import Opened
from rapc.errors import LoadError
from rapc.events import RunStarted
from rapc.runtime.events.trace import record
from rapc.runtime.interpreter import Interpreter
from rapc.spec import RunSpec
from rapc.world import World
from tests.cli.command import rapc as command
from tests.durable.helpers import Run
from tests.durable.peer import Peer, ResumablePeer, library, of

ROOT = Path(__file__).parents[2]
ROCKS = str(ROOT / "examples" / "rock-order.rap")
ORDER = ("--world", "truck", "--task", "(fill-order red 4 factory-1)", "--seed", "7")


def _history(opened: Opened, kind: type[World], seed: int = 0) -> History:
    world = opened.build(kind, seed, {})
    run = Interpreter.prepared(opened.program(), world, opened.spec)
    return opened.history(run)


@pytest.fixture
def live(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Return a run with a robot, and a snapshot every 5 cycles."""
    monkeypatch.setattr(journal, "CYCLES", 5)
    monkeypatch.setattr(journal, "PAUSE", 0)
    monkeypatch.setattr(journal, "_PROGRESS", 0)
    peer = Peer()
    program = rapc.loads(library(8)).program
    spec = RunSpec(tasks=("(all)",))
    return Run(tmp_path, program, spec, lambda: ResumablePeer(of(peer)))


def _state(run: Interpreter) -> object:
    return run.now, set(run.memory), run.goals()


def _states(run: Run, cycles: int) -> dict[int, object]:
    """Begin a run; return what the robot believed after each cycle."""
    durable = run.begin()
    found: dict[int, object] = {}
    while durable.run.cycle < cycles and durable.step():
        found[durable.run.cycle] = _state(durable.run)
    durable.close()
    return found


def test_live_run_is_stepped_back_and_forth(live: Run) -> None:
    states = _states(live, 30)
    opened = Opened(live.journal)
    history = _history(opened, ResumablePeer)
    opened.go_to_end(history)
    assert history.cycle == max(states) == 30
    chance = Random(1)
    for cycle in [chance.choice([*states]) for _ in range(40)]:
        history.goto(cycle)
        assert _state(history.run) == states[cycle]
    stop = history.go()
    assert (stop.kind, stop.said) == ("broken", "end of the journal")
    write_trace(history, live.trace.with_suffix(".copy"))
    whole = live.trace.with_suffix(".copy").read_text()
    assert whole.startswith(live.trace.read_text())


def test_live_run_is_followed_while_it_goes_on(live: Run) -> None:
    durable = live.begin()
    durable.reach(12)
    opened = Opened(live.journal)
    history = _history(opened, ResumablePeer)
    opened.go_to_end(history)
    assert history.cycle == 12
    assert str(opened).endswith("the run goes on")
    durable.go()
    durable.close()
    assert history.go().kind == "over"
    assert (history.cycle, history.reason) == (durable.run.cycle, "done")
    history.goto(3)
    assert history.cycle == 3


def test_journal_without_its_first_parts_begins_later(live: Run) -> None:
    live.options = Options(sync="off", limit=0)
    states = _states(live, 33)
    opened = Opened(live.journal)
    history = _history(opened, ResumablePeer)
    assert history.cycle == 30
    opened.go_to_end(history)
    assert history.cycle == 33
    history.goto(31)
    assert _state(history.run) == states[31]
    history.goto(33)
    told = [one.event() for one in history.scan()]
    assert isinstance(told[0], RunStarted)
    written = [json.loads(line) for line in live.trace.read_text().splitlines()]
    known = [event.n for event in told]
    assert known == [*range(known[0], history.serial)]
    begun = next(at for at, event in enumerate(told) if event.cycle)
    ours = [json.loads(json.dumps(record(event))) for event in told[begun:]]
    assert ours == written[known[begun] :][: len(ours)]
    assert why_end(history).lines[0].startswith("the run")


def test_simulator_is_run_up_to_the_last_known_cycle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal, "_PROGRESS", 0)
    courier = rapc.load(ROOT / "examples" / "courier").program
    spec = RunSpec(agenda="shift", seed=3, until=1500)
    run = Run(tmp_path, courier, spec, lambda: rapc.open_world("courier", seed=3))
    states = _states(run, 40)
    opened = Opened(run.journal)
    history = _history(opened, type(rapc.open_world("courier")), 3)
    opened.go_to_end(history)
    assert history.cycle == 40
    assert _state(history.run) == states[40]
    resumed = run.resume()
    resumed.reach(60)
    assert history.go().said == "end of the journal"
    assert history.cycle == 60
    resumed.close()


# --- the commands -------------------------------------------------------------------


@pytest.fixture
def ended(tmp_path: Path) -> Path:
    """Return the journal of an order that has ended."""
    args = ("--journal", "j", "--trace", "t.jsonl", "-q")
    assert command("run", ROCKS, *ORDER, *args, cwd=tmp_path).returncode == 0
    return tmp_path


def test_info_describes_a_journal(ended: Path) -> None:
    done = command("journal", "info", "j", cwd=ended)
    lines = dict(line.split(None, 1) for line in done.stdout.splitlines())
    assert (lines["world"], lines["seed"]) == ("truck", "7")
    assert lines["task"] == "(fill-order red 4 factory-1)"
    assert lines["state"] == "ended (done)"
    assert lines["trace"] == "t.jsonl"


def test_verify_finds_damaged_files(ended: Path) -> None:
    done = command("journal", "verify", "j", cwd=ended)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith("0 damaged\n")
    part = files.part_file(ended / "j", 1)
    part.write_bytes(part.read_bytes()[:-1])
    done = command("journal", "verify", "j", cwd=ended)
    assert done.returncode == 0
    assert "incomplete bytes" in done.stdout
    part.write_bytes(b"x" + part.read_bytes())
    done = command("journal", "verify", "j", cwd=ended)
    assert done.returncode == 1
    assert "is not a part of a journal" in done.stderr


def _damage(file: Path) -> None:
    data = bytearray(file.read_bytes())
    data[40] ^= 1
    file.write_bytes(data)


def test_damage_before_the_last_snapshot_is_reported(live: Run) -> None:
    _states(live, 30)
    folder = live.journal
    part, snapshot = files.part_file(folder, 2), files.snapshot_file(folder, 4)
    whole = command("journal", "info", str(folder)).stdout
    assert "cycles    0 to 30" in whole
    assert "\ndamage" not in whole
    _damage(part)
    _damage(snapshot)
    told = f"`{part}` is damaged at byte 15"
    info = command("journal", "info", str(folder)).stdout
    assert "cycles    10 to 30" in info
    assert f"damage    {told}\ndamage    `{snapshot}` is damaged\n" in info
    done = command("journal", "verify", str(folder))
    assert done.returncode == 1
    assert done.stderr.splitlines() == [
        f"error: `{snapshot}` is damaged",
        f"error: {told}",
    ]
    assert done.stdout.endswith("2 damaged\n")
    done = command("repl", str(folder), "--world", "tests.durable.peer:ResumablePeer")
    assert done.stderr == f"note: {told}; the history begins at cycle 10\n"
    # a damaged snapshot is no obstacle to the other ones
    done = command("journal", "cut", str(folder), "--cycle", "19")
    assert done.stdout == "the run resumes from cycle 10\n"


def test_damage_amid_the_last_part_is_refused(live: Run) -> None:
    live.options = Options(sync="off", limit=1)
    durable = live.begin()
    durable.reach(3)
    durable.close()
    part = files.part_file(live.journal, 1)
    _damage(part)
    with pytest.raises(LoadError, match="is damaged at byte 15"):
        live.resume()
    assert command("journal", "verify", str(live.journal)).returncode == 1


@pytest.mark.parametrize(
    "args",
    [
        ("journal", "info", "j"),
        ("journal", "verify", "j"),
        ("journal", "cut", "j", "--cycle", "3"),
        ("journal", "convert", "j", "--trace", "u.jsonl"),
        ("run", "--resume", "j"),
        ("repl", "j"),
        ("repl", "--attach", "j"),
        ("view", "j"),
    ],
)
def test_missing_meta_is_reported_in_one_line(tmp_path: Path, args: Any) -> None:
    (tmp_path / "j").mkdir()
    (tmp_path / "j" / "journal-000001").write_bytes(b"rapc-journal 1\n")
    done = command(*args, cwd=tmp_path)
    said = "error: the journal `j` has no file `meta`\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", said)


def test_folder_that_cannot_be_read_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("os.listdir", refuse)
    with pytest.raises(LoadError, match=f"cannot read `{tmp_path}`: permission denied"):
        files.read(tmp_path)


def test_files_of_killed_processes_are_removed(live: Run) -> None:
    live.journal.mkdir()
    process = subprocess.Popen(["true"])
    process.wait()
    left = live.journal / f"meta.{process.pid}.rapc-part"
    left.write_bytes(b"half")
    live.begin().close()
    assert not left.exists()


def test_convert_writes_the_trace(ended: Path) -> None:
    done = command("journal", "convert", "j", "--trace", "u.jsonl", cwd=ended)
    assert done.returncode == 0, done.stderr
    assert (ended / "u.jsonl").read_bytes() == (ended / "t.jsonl").read_bytes()


def test_convert_reports_a_missing_folder(ended: Path) -> None:
    done = command("journal", "convert", "j", "--trace", "no/t.jsonl", cwd=ended)
    said = "error: cannot write `no/t.jsonl`: missing file or folder\n"
    assert (done.returncode, done.stderr) == (2, said)


def test_cut_goes_back_to_a_snapshot(live: Run) -> None:
    _states(live, 30)
    done = command("journal", "cut", str(live.journal), "--cycle", "19")
    assert done.stdout == "the run resumes from cycle 15\n"
    parts, snapshots = files.numbers(live.journal)
    assert (max(snapshots), max(parts)) == (4, 3)


def test_under_way_requests_are_listed(live: Run) -> None:
    durable = live.begin()
    while not durable.run.requests():
        durable.step()
    durable.close()
    meta = files.read_meta(live.journal)
    assert meta.spec.tasks == ("(all)",)
    done = command("journal", "info", str(live.journal))
    assert "under way [2] (work 1)" in done.stdout


@pytest.mark.parametrize(
    "args",
    [
        ("cut", "j"),
        ("info", "j", "--cycle", "3"),
        ("convert", "j"),
        ("info", "nothing"),
        ("verify", "nothing"),
    ],
)
def test_wrong_use_is_refused_in_one_line(ended: Path, args: tuple[str, ...]) -> None:
    done = command("journal", *args, cwd=ended)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)


def test_debugger_opens_a_journal(ended: Path) -> None:
    script = ("-c", ":goto 20", "-c", ":tree")
    done = command("repl", "j", *script, cwd=ended)
    assert done.returncode == 0, done.stdout
    assert "cycle 20" in done.stdout
    done = command("repl", "--attach", "j", "-c", ":run", cwd=ended)
    assert "run ended (done)" in done.stdout


def test_journal_with_another_library_is_that_of_its_texts(ended: Path) -> None:
    meta = files.read_meta(ended / "j")
    files.write_meta(
        ended / "j", replace(meta, spec=replace(meta.spec, library="gone.rap"))
    )
    done = command("repl", "j", "-c", ":run", cwd=ended)
    assert "run ended (done)" in done.stdout


def test_journal_is_text_for_other_programs(ended: Path) -> None:
    meta = (ended / "j" / "meta").read_bytes().split(b"\n", 1)[1]
    assert json.loads(meta)["spec"]["world"] == "truck"
