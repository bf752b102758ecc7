"""Journals of runs in simulators: the resumed trace is that of a whole run."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import rapc
from bench import kills
from bench.journal import LIMITS, RUNS, row
from rapc.durable import folder as files
from rapc.durable import journal
from rapc.durable.folder import Lock
from rapc.errors import LoadError, StateError, WriteError
from rapc.spec import RunSpec
from tests.cli.command import rapc as command
from tests.durable.helpers import Run

ROOT = Path(__file__).parents[2]
ORDER = ("--world", "truck", "--task", "(fill-order red 4 factory-1)", "--seed", "7")
ROCKS = str(ROOT / "examples" / "rock-order.rap")


@pytest.fixture
def courier(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Return a run of the courier, with a snapshot every 20 cycles."""
    monkeypatch.setattr(journal, "CYCLES", 20)
    monkeypatch.setattr(journal, "PAUSE", 0)
    library = rapc.load(ROOT / "examples" / "courier").program
    spec = RunSpec(agenda="shift", seed=3, until=1500)
    return Run(tmp_path, library, spec, lambda: rapc.open_world("courier", seed=3))


def test_run_with_journal_has_the_same_trace(courier: Run) -> None:
    durable = courier.begin()
    durable.go()
    durable.close()
    assert courier.trace.read_text() == courier.whole()


@pytest.mark.parametrize("cycles", [0, 1, 19, 20, 21, 70, 151])
def test_resumed_trace_is_that_of_a_whole_run(courier: Run, cycles: int) -> None:
    durable = courier.begin()
    durable.reach(cycles)
    shutil.copytree(courier.journal, courier.journal.with_name("copy"))
    durable.close()
    shutil.rmtree(courier.journal)
    courier.journal.with_name("copy").rename(courier.journal)
    resumed = courier.resume()
    assert cycles - 20 <= resumed.run.cycle <= cycles
    resumed.go()
    resumed.close()
    assert courier.trace.read_text() == courier.whole()


def test_resumed_run_resumes_again_and_after_its_end(courier: Run) -> None:
    durable = courier.begin()
    durable.reach(50)
    durable.close()
    for cycle in (90, 130):
        durable = courier.resume()
        durable.reach(cycle)
        durable.close()
    for _ in range(2):
        durable = courier.resume()
        assert durable.go() == "done"
        durable.close()
        assert courier.trace.read_text() == courier.whole()


def test_journal_within_its_limit_has_no_old_parts(courier: Run) -> None:
    courier.options = files.Options(sync="off", limit=0)
    durable = courier.begin()
    durable.reach(100)
    durable.close()
    parts, snapshots = files.numbers(courier.journal)
    assert parts == snapshots == [6]
    resumed = courier.resume()
    resumed.go()
    resumed.close()
    assert courier.trace.read_text() == courier.whole()


@pytest.mark.parametrize("cut", [1, 7, 8, 20])
def test_incomplete_record_is_cut_off(courier: Run, cut: int) -> None:
    durable = courier.begin()
    durable.reach(30)
    durable.close()
    part = files.part_file(courier.journal, 2)
    part.write_bytes(part.read_bytes()[:-cut])
    resumed = courier.resume()
    resumed.go()
    resumed.close()
    assert courier.trace.read_text() == courier.whole()


@pytest.mark.parametrize("left", [0, 5])
def test_run_killed_before_its_first_record_is_begun_again(
    courier: Run, left: int
) -> None:
    courier.begin().close()
    part = files.part_file(courier.journal, 1)
    head = part.read_bytes()[:left]
    part.unlink()
    if head:
        part.write_bytes(head)
    resumed = courier.resume()
    resumed.go()
    resumed.close()
    assert courier.trace.read_text() == courier.whole()


def test_damaged_snapshot_is_replaced_by_the_one_before(courier: Run) -> None:
    durable = courier.begin()
    durable.reach(65)
    durable.close()
    snapshot = files.snapshot_file(courier.journal, 4)
    snapshot.write_bytes(snapshot.read_bytes()[:-1])
    resumed = courier.resume()
    assert resumed.run.cycle == 40
    resumed.go()
    resumed.close()
    assert courier.trace.read_text() == courier.whole()


def test_missing_part_between_two_others_is_refused(courier: Run) -> None:
    durable = courier.begin()
    durable.reach(65)
    durable.close()
    for number in (2, 3, 4):
        files.snapshot_file(courier.journal, number).unlink()
    files.part_file(courier.journal, 2).unlink()
    with pytest.raises(LoadError, match=r"`.*journal-000002` is missing"):
        courier.resume()


def test_too_short_trace_is_refused(courier: Run) -> None:
    durable = courier.begin()
    durable.reach(65)
    durable.close()
    courier.trace.write_text("")
    with pytest.raises(WriteError, match=r"cannot continue the trace .* too short"):
        courier.resume()


def test_second_process_is_refused(courier: Run) -> None:
    durable = courier.begin()
    with pytest.raises(StateError, match="another process runs it"):
        Lock(courier.journal)
    with pytest.raises(StateError, match="another process runs it"):
        courier.resume()
    durable.close()
    courier.resume().close()


def test_folder_with_files_is_refused(courier: Run) -> None:
    courier.journal.mkdir()
    (courier.journal / "notes").touch()
    with pytest.raises(WriteError, match="the folder is not empty"):
        courier.begin()


# --- the command --------------------------------------------------------------------


def _killed(folder: Path) -> None:
    """Leave a journal of an order as if the process had been killed."""
    trace = ("--trace", str(folder / "trace.jsonl"))
    code = (
        "import os, rapc.durable.runs as runs, rapc.durable.journal as journal\n"
        "from rapc.cli.main import main\n"
        "journal.CYCLES, journal.PAUSE = 30, 0\n"
        "step = runs.DurableRun.step\n"
        "def stop(self):\n"
        "    if self.run.cycle == 100: os._exit(9)\n"
        "    return step(self)\n"
        "runs.DurableRun.step = stop\n"
        f"main({['run', ROCKS, *ORDER, '-q', '--journal', str(folder / 'j'), *trace]})"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 9


def test_command_resumes_with_the_same_trace_and_report(tmp_path: Path) -> None:
    whole = tmp_path / "whole.jsonl"
    first = command("run", ROCKS, *ORDER, "-q", "--trace", str(whole))
    _killed(tmp_path)
    done = command("run", "--resume", str(tmp_path / "j"), "-q")
    assert done.stdout == first.stdout
    assert (done.stderr, done.returncode) == ("", 0)
    assert (tmp_path / "trace.jsonl").read_bytes() == whole.read_bytes()


def test_command_refuses_a_changed_library_without_take_up(tmp_path: Path) -> None:
    text = Path(ROCKS).read_text()
    rocks = tmp_path / "rocks.rap"
    rocks.write_text(text)
    args = (str(rocks), *ORDER, "-q", "--journal", str(tmp_path / "j"))
    done = command("run", *args, "--until", "50")
    assert done.returncode == 1
    rocks.write_text(text + "\n(define-rap (nothing) (method (task-net)))\n")
    done = command("run", "--resume", str(tmp_path / "j"), "-q")
    assert done.returncode == 2
    assert f"cannot resume: the library `{rocks}` has changed" in done.stderr
    done = command("run", "--resume", str(tmp_path / "j"), "-q", "--take-up")
    assert done.returncode == 1
    assert "Run over (until)" in done.stdout


@pytest.mark.parametrize(
    ("args", "said"),
    [
        ((ROCKS, "--journal", "j", "--trace-format", "text"), "--trace-format text"),
        (("--resume", "j", "--seed", "3"), "cannot change the start of a resumed run"),
        (("--resume", "missing"), "`missing` is not a journal"),
        (("--resume", ROCKS), f"`{ROCKS}` is not a journal"),
        (
            (ROCKS, *ORDER, "--journal", ROCKS),
            f"cannot write `{ROCKS}`: the file exists",
        ),
        (("--resume", "j", "--journal", "k"), "--journal cannot be used with --resume"),
        ((), "missing PATH"),
        ((ROCKS,), "missing --world"),
        (
            (ROCKS, *ORDER, "--journal", "j", "--after-crash", "x"),
            "expected PRIMITIVE=repeat, fail or ask, not `x`",
        ),
    ],
)
def test_command_refuses_in_one_line(
    tmp_path: Path, args: tuple[str, ...], said: str
) -> None:
    done = command("run", *args, cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr.splitlines()[0]
    assert not (tmp_path / "missing").exists()


LIMITED = """
import resource, sys
from rapc.cli.main import main
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), -1))
main(sys.argv[2:])
"""


@pytest.mark.parametrize("size", [2_000, 40_000, 90_000])
def test_full_disk_ends_the_command_and_loses_nothing(
    tmp_path: Path, size: int
) -> None:
    whole, trace = tmp_path / "whole.jsonl", tmp_path / "trace.jsonl"
    first = command("run", ROCKS, *ORDER, "-q", "--trace", str(whole))
    args = [ROCKS, *ORDER, "-q", "--journal", str(tmp_path / "j"), "--trace", trace]
    full = [sys.executable, "-c", LIMITED, str(size), "run", *map(str, args)]
    done = subprocess.run(full, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert re.match(f"error: cannot write .*`{tmp_path}/", done.stderr)
    assert len(done.stderr.splitlines()) == 1
    again = ["run", "--resume", str(tmp_path / "j"), "-q"]
    if not (tmp_path / "j" / "meta").exists():
        shutil.rmtree(tmp_path / "j")
        again = ["run", *map(str, args)]
    done = command(*again)
    assert done.stdout == first.stdout
    assert trace.read_bytes() == whole.read_bytes()


@pytest.mark.long
@pytest.mark.slow
def test_killed_and_cut_runs_have_the_same_trace(tmp_path: Path) -> None:
    found = kills.measured(["courier"], 20, 20, 2, tmp_path)
    assert found["courier: kills"].same >= 20
    assert sum(found["courier: cuts"]) == 20


@pytest.mark.nightly
@pytest.mark.timeout(1800)
def test_killed_and_cut_runs_of_each_world_have_the_same_trace(tmp_path: Path) -> None:
    kills.measured([*kills.RUNS], 90, 90, 3, tmp_path)


@pytest.mark.nightly
@pytest.mark.parametrize("both", LIMITS)
@pytest.mark.parametrize("name", RUNS)
def test_processor_time_of_a_journal_is_within_its_limit(name: str, both: str) -> None:
    assert row(name, both, 9).ratio <= LIMITS[both]
