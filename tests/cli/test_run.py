"""`rapc run`: what it refuses, what it blames on whom, and its exit status."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest

from tests.cli.command import rapc
from tests.debug.planted import FAULTS

TRUCK = Path(__file__).parents[2] / "stdlib" / "truck"
ROCKS = Path(__file__).parents[2] / "examples" / "rock-order.rap"

LIBRARY = """\
(declare-primitive nap () (okay))
(declare-memory-proposition rested)
(define-rap (doze) (method (primitive (nap))))
(define-rap (spin)
  (succeed (rested))
  (resources (counter ?turns))
  (method (task-net (t1 (turn) (counter-add ?turns 1)))))
(define-rap (turn) (method (task-net)))
(define-rap (wait) (method (context (rested)) (task-net)))
"""

WORLD = """\
from rapc.world import Handlers, Kit, Offer, Reply, World

def napped(memory, request, result):
    raise KeyError("pillow")

class Bed(World):
    "A bed."
    name = "bed"
    def __init__(self, rng, options): pass
    kit = Kit(Offer({"nap": (0, ("okay",))}), Handlers({"nap": napped}))
    def facts(self): return []
    def now(self): return 0
    def perform(self, ticket, request): return Reply("okay")
    def next_time(self): return None
    def advance(self, to): pass
    def messages(self): return []

class Broken(Bed):
    def __init__(self): pass

class Hasty(Bed):
    asked = 0
    def facts(self):
        import os, signal
        self.asked += 1
        if self.asked == 1: return []  # it is asked before the run, too
        os.kill(os.getpid(), signal.SIGINT)
        return []

class Stubborn(Bed):
    asked = 0
    def messages(self):
        import os, signal
        self.asked += 1
        if self.asked == 2:
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)
        return []

class Resent(Bed):
    at, lost = 0, False
    def now(self): return self.at
    def advance(self, to):
        import os, signal
        self.at = to
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            self.lost = True
    def messages(self):
        import os, signal
        if self.lost:
            self.lost = False
            os.kill(os.getpid(), signal.SIGINT)
        return []

class Garish(Bed):
    "A bed\\x1b[31m."
    name = "bed"
    kit = Kit(Offer({"nap": (0, ("okay",)), "glow": (0, ("okay", "red\\x1b[31m"))}))
    over = None
    def ended(self): return self.over
    def perform(self, ticket, request):
        self.over = "red\\x1b[31m"
        return Reply("okay")

class Telling(Bed):
    def facts(self): return [("rested", "well"), ("rested", "badly")]
"""


@pytest.fixture
def bed(tmp_path: Path) -> Path:
    (tmp_path / "doze.rap").write_text(LIBRARY)
    (tmp_path / "bed.py").write_text(WORLD)
    return tmp_path


def _run(
    folder: Path, *more: str, world: str = "bed:Bed", task: str = "(spin)"
) -> subprocess.CompletedProcess[str]:
    args = ("doze.rap", "--world", world, "--task", task, *more)
    return rapc("run", *args, cwd=folder)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--until", "-1"), "--until must not be negative"),
        (("--task", "(spin) :at -1"), "`:at` takes a time, and the clock begins at 0"),
        (("--task", "(spin) :deadline -0.5"), "`:deadline` takes a time, and the"),
        (("--until", "nan"), "--until must be finite"),
        (("--task", "(spin 1)"), "`spin` has no inputs, not 1"),
        (
            ("--trace", "doze.rap"),
            "--trace: `doze.rap` is a source file of the library",
        ),
        (
            ("--trace", "no/../doze.rap"),
            "--trace: `no/../doze.rap` is a source file of the",
        ),
        (("--trace", "bed.py"), "--trace: `bed.py` is the source file of the world"),
        (("--trace", "."), "--trace: cannot write `.`: it is a folder"),
        (("--trace", "no/x"), "cannot write `no/x`: missing file or folder"),
        (("--set", "rapc.cycle-cost=-1"), "`rapc.cycle-cost` takes 0 or more, not"),
        (
            ("--set", "rapc.futile-limit=0.5"),
            "--set: `rapc.futile-limit` takes a whole number, 1 or more, not `0.5`",
        ),
        (("--fault", "(nap) okay p=1 p=0"), "--fault: duplicate option `p`"),
        (("--fault", "(nap) okay from=2 until=1"), "--fault: `from` is later than"),
        (("--fault", "(nap 1) okay"), "--fault: `nap` takes no arguments, not 1"),
    ],
)
def test_slips_are_refused_in_one_line(
    more: tuple[str, ...], said: str, bed: Path
) -> None:
    done = _run(bed, *more)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1
    assert (bed / "doze.rap").read_text() == LIBRARY


def test_cancelled_run_has_not_succeeded(bed: Path) -> None:
    done = _run(bed, "-q", "--set", "rapc.idle-cycles=50")
    assert done.returncode == 1
    assert done.stdout.startswith("Run over (runaway: ")
    assert "(spin) unfinished" in done.stdout


def test_failed_background_task_sets_exit_status_1(bed: Path) -> None:
    done = _run(
        bed, "-q", "--task", "(wait) :priority 1 :background true", task="(turn)"
    )
    assert done.returncode == 1
    assert "[1] (turn) succeeded, 0 to 0" in done.stdout
    assert "[2] (wait) failed: no-method, 0 to 0 (background)" in done.stdout
    assert "context of method `#1` at doze.rap:9: (rested), does" in done.stdout
    assert _run(bed, "-q", task="(turn)").returncode == 0


def test_exception_of_a_world_names_the_world(bed: Path) -> None:
    done = _run(bed, "-q", task="(doze)")
    assert (done.returncode, done.stdout) == (2, "")
    said = "error: the handler of `nap` failed at bed.py:4: KeyError: 'pillow'\n"
    assert done.stderr == said


def test_unbuildable_world_is_named(bed: Path) -> None:
    done = _run(bed, world="bed:Broken")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: the world `bed` cannot be built: TypeError:")


def test_the_report_says_why_the_world_ended_a_run(tmp_path: Path) -> None:
    trace = tmp_path / "trace.jsonl"
    done = rapc(
        *("run", str(ROCKS), "--world", "truck", "--task", "(rock-order red 1)"),
        *("--set", "truck.fuel=0.1", "-q", "--trace", str(trace)),
    )
    assert done.returncode == 1
    assert re.match(r"Run over \(world: out of fuel on road-\d+\) at", done.stdout)
    end = json.loads(trace.read_text().splitlines()[-1])
    assert end["reason"] == "world"
    assert end["because"].startswith("out of fuel on road-")


def test_report_explains_the_end_and_what_kept_the_goals(tmp_path: Path) -> None:
    [fault] = [one for one in FAULTS if one.name == "charges-too-late"]
    fault.plant(tmp_path)
    args = ("run", ".", "--world", "courier", "--agenda", "shift", "--seed", "1")
    shown = rapc(*args, cwd=tmp_path)
    assert shown.returncode == 1
    out = shown.stdout
    before, goals = out.split("Before the end:\n")[1].split("What kept the goals:")
    assert re.search(r"108 .*chose method charge .*charging\.rap:25", before)
    assert re.search(r"108 .*woken by \(low\) .*charging\.rap:8", before)
    assert "(deliver linen" in goals
    assert "suspended by" in goals
    out = rapc(*args, "-q", cwd=tmp_path).stdout
    assert "Before the end:" in out
    assert "What kept the goals:" not in out


def test_a_word_of_the_world_declared_otherwise_is_refused(bed: Path) -> None:
    text = LIBRARY.replace("rested)", "rested ())", 1)
    (bed / "doze.rap").write_text(text)
    done = _run(bed, "--trace", "trace.jsonl", world="bed:Telling")
    assert done.returncode == 2
    assert done.stderr == (
        "error: doze.rap:2:1: `rested` takes no arguments, not 1: "
        "the world `bed` has the initial fact (rested well)\n"
    )
    assert not (bed / "trace.jsonl").exists()


def test_ctrl_c_before_the_first_cycle_ends_the_run(bed: Path) -> None:
    args = ("--world", "bed:Hasty", "--task", "(doze)", "--trace", "t.jsonl")
    done = rapc("run", "doze.rap", *args, cwd=bed)
    assert (done.returncode, done.stderr) == (1, "")
    assert "Run over (cancelled) at time 0 after 0 cycles." in done.stdout
    rows = [json.loads(row) for row in (bed / "t.jsonl").read_text().splitlines()]
    assert (rows[0]["event"], rows[-1]["event"]) == ("run-started", "run-ended")
    assert rows[-1]["reason"] == "cancelled"


def test_second_interrupt_in_a_cycle_ends_the_command(bed: Path) -> None:
    done = _run(bed, world="bed:Stubborn", task="(wait) :at 1")
    assert (done.returncode, done.stderr.strip()) == (130, "")
    assert "Run over" not in done.stdout


def test_interrupt_after_a_lost_one_ends_the_run_in_order(bed: Path) -> None:
    """Python drops Ctrl-C in some callbacks, and rapc sends it again."""
    done = _run(bed, world="bed:Resent", task="(spin) :at 1")
    assert (done.returncode, done.stderr) == (1, "")
    assert "Run over (cancelled)" in done.stdout


def test_a_library_run_in_the_wrong_world_is_told_which_is_meant() -> None:
    done = rapc("run", str(TRUCK), "--world", "courier", "--task", "(wakeup)")
    assert done.returncode == 2
    assert done.stdout == ""
    first, second = done.stderr.splitlines()
    assert re.search(r"is not for the world `courier`: \d+ of its", first)
    assert second.strip() == "the world `truck` has them all"


def test_control_characters_of_a_world_are_escaped(bed: Path) -> None:
    args = ("--world", "bed:Garish", "--task", "(doze)")
    done = rapc("run", "doze.rap", *args, cwd=bed)
    assert "red\N{REPLACEMENT CHARACTER}[31m" in done.stdout
    told = rapc("worlds", "bed:Garish", cwd=bed)
    assert "red\N{REPLACEMENT CHARACTER}[31m" in told.stdout
    assert "\x1b" not in done.stdout + done.stderr + told.stdout + told.stderr


def test_endless_task_is_named_in_a_run_without_end(
    bed: Path,
) -> None:
    guard = "(define-rap (guard) (succeed nil) (monitor-state (rested)))"
    (bed / "doze.rap").write_text(f"{LIBRARY}{guard}\n")
    note = "note: (guard) never ends, so the run never ends: use --until, "
    assert note in _run(bed, task="(guard)").stderr
    for more in (("--until", "3"), ("--task", "(guard) :background true")):
        done = _run(bed, *more, task="(guard) :background true")
        assert "never done" not in done.stderr


def test_tasks_in_the_background_alone_are_noted_for_the_run_is_over(
    bed: Path,
) -> None:
    guard = "(define-rap (guard) (succeed nil) (monitor-state (rested)))"
    (bed / "doze.rap").write_text(f"{LIBRARY}{guard}\n")
    note = "note: the run ends at once: all tasks are in the background"
    alone = _run(bed, task="(guard) :background true")
    assert alone.stderr.startswith(note)
    assert "Run over (done) at time 0" in alone.stdout
    limited = _run(bed, "--until", "3", task="(guard) :background true")
    assert note not in limited.stderr
    assert "Run over (stuck) at time 0" in limited.stdout
    beside = _run(bed, "--task", "(guard) :background true", task="(turn)")
    assert note not in beside.stderr


def test_report_has_the_numbers_of_figure_6_7_where_sensors_are_known() -> None:
    asked = ("--task", "(rock-order red 1)", "--task", "(rock-order red 1) :at 5000")
    where = ("run", "examples/rock-order.rap", "--world", "truck", "-q")
    lines = rapc(*where, *asked, "--until", "400").stdout.splitlines()
    assert "Tasks: 1 completed, 0 given up, 0 pending." in lines
    [line] = [line for line in lines if line.startswith("Primitives: ")]
    found = re.match(r"Primitives: (\d+) \((\d+) effector, (\d+) sensor\), of", line)
    assert found is not None
    total, effector, sensor = map(int, found.groups())
    assert (effector + sensor, sensor > 0) == (total, True)


DEADLOCK = """\
(require "world")
(define-rap (go) (method (primitive (drive pharmacy))))
(define-rap (ab) (method (claims (lock a)) (task-net (t1 (go) (for t2)) (t2 (b)))))
(define-rap (ba) (method (claims (lock b)) (task-net (t1 (go) (for t2)) (t2 (a)))))
(define-rap (a) (method (claims (lock a)) (primitive (drive pharmacy))))
(define-rap (b) (method (claims (lock b)) (primitive (drive pharmacy))))
"""


def test_deadlock_in_a_living_world_is_reported_and_ends_the_run(
    tmp_path: Path,
) -> None:
    """The people of the courier's hospital go on walking for ever."""
    world = ROCKS.parent / "courier" / "world.rap"
    (tmp_path / "world.rap").write_text(world.read_text())
    (tmp_path / "locks.rap").write_text(DEADLOCK)
    tasks = ("--task", "(ab)", "--task", "(ba)", "--set", "rapc.idle-waits=50")
    done = rapc("run", "locks.rap", "--world", "courier", "-q", *tasks, cwd=tmp_path)
    circle = (
        "(b) [4] waits for (lock b), held by (ba) [2]; "
        "(a) [6] waits for (lock a), held by (ab) [1]"
    )
    assert done.returncode == 1
    assert done.stderr == f"note: deadlock at time 10: {circle}\n"
    assert done.stdout.startswith("Run over (stuck: no cycle in 50 waits (`rapc.idle-")
    assert f"Left over:\n  deadlock: {circle}\n" in done.stdout


def test_pictures_in_a_trace_require_a_trace_and_a_picture(tmp_path: Path) -> None:
    given = ("run", str(ROCKS), "--world", "truck", "--task", "(rock-order red 1)")
    trace = tmp_path / "run.jsonl"
    done = rapc(*given, "-q", "--trace", str(trace), "--trace-pictures")
    assert done.returncode == 0
    told = [json.loads(line) for line in trace.read_text().splitlines()]
    assert told[0]["spec"]["settings"]["pictures"] is True
    pictured = [one["changed"] for one in told if one["event"] == "pictured"]
    assert len(pictured) > 5
    assert {"here", "spots", "roads", "gauges"} <= pictured[0].keys()
    assert rapc(*given, "--trace-pictures").returncode == 2
    text = ("--trace", str(trace), "--trace-format", "text", "--trace-pictures")
    assert "requires --trace, in jsonl" in rapc(*given, *text).stderr


def test_pictures_of_a_world_without_a_picture_are_refused(tmp_path: Path) -> None:
    (tmp_path / "beds.rap").write_text(LIBRARY)
    (tmp_path / "beds.py").write_text(WORLD)
    given = ("run", "beds.rap", "--world", "beds:Bed", "--task", "(doze)")
    more = ("--trace", "run.jsonl", "--trace-pictures")
    done = rapc(*given, *more, cwd=tmp_path)
    assert done.returncode == 2
    assert "it has no `picture` method" in done.stderr


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (("--sync", "off"), "--sync requires --journal or --resume"),
        (("--journal-limit", "5"), "--journal-limit requires --journal or --resume"),
        (("--take-up",), "--take-up requires --resume"),
    ],
)
def test_options_of_a_journal_require_a_journal(
    option: tuple[str, ...], said: str
) -> None:
    given = ("run", str(ROCKS), "--world", "truck", "--task", "(rock-order red 1)")
    done = rapc(*given, *option)
    assert (done.returncode, done.stderr) == (2, f"error: {said}\n")
