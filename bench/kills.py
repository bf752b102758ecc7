"""Runs with a journal, killed and cut: the resumed trace is that of a whole run.

    python -m bench.kills [--kills N] [--cuts N] [--live N] [--seed N]

Each run is a process of its own, and is ended with SIGKILL after a random time, then
resumed and killed again until it ends. The last journal of each run is then cut off at
random bytes: a resumed run has the same trace, or is refused in one line. Before that,
two robots in processes of their own, one of them with a driver, get 150 requests from
runs that are killed at least 10 times each. Each request must be done exactly once, and
each datum be taken in exactly once.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from rapc.base import watchdog
from rapc.cli.main import main as rapc
from rapc.durable import journal
from rapc.durable.runs import begin, resume
from rapc.host import CheckedLibrary, load, loads
from rapc.world import World
from tests.durable import peer as live

SCANS = """
(define-rap (see ?parcel)
  (succeed (scanned ?parcel))
  (monitor-state (scanned ?parcel))
  (method (task-net)))
"""
"""A task for the conveyor that waits for the datum of a parcel."""

HERE = Path(__file__).parents[1]

RUNS = {
    "nine orders": (
        *("stdlib/truck", "--world", "truck", "--agenda", "nine-orders"),
        *("--set", "truck.shuffle-interval=15"),
    ),
    "courier": ("examples/courier", "--world", "courier", "--agenda", "shift"),
    "hallway": ("stdlib/hallway", "--world", "hallway", "--agenda", "errand"),
}

CYCLES = (10, 100, 1000)
"""The numbers of cycles between two snapshots, in turn."""

REFUSED = 2

JOBS = 75
"""The number of jobs of a robot in a process of its own, each with two requests."""

KILLS = 12
"""The number of kills of such a run."""


class Counts(NamedTuple):
    """What was done, and how often."""

    same: int = 0
    refused: int = 0


def started(args: Sequence[str], errors: Path, cycles: int) -> int:
    """Start `rapc` in a process of its own; return its number."""
    process = os.fork()
    if process:
        return process
    journal.CYCLES, journal.PAUSE = cycles, 0
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.dup2(os.open(errors, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), 2)
    # those of a test write elsewhere
    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
    status = 99
    try:
        rapc([*args, "-q"])
    except SystemExit as error:
        status = error.code if isinstance(error.code, int) else 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def ended(process: int) -> int:
    """Wait for a process; return its status, -9 if it was killed."""
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def run_whole(args: Sequence[str], trace: Path) -> float:
    """Write the trace of a run without a journal; return the seconds it took."""
    begun = time.monotonic()
    ended(started(("run", *args, "--trace", str(trace)), trace.with_suffix(".err"), 1))
    return time.monotonic() - begun


class Killed:
    """A run that is killed again and again.

    Args:
        folder: a folder for its files.
        args: the arguments of `rapc run`.
        whole: the trace of the run without a journal.
        rng: the source of all chance.
    """

    def __init__(
        self, folder: Path, args: Sequence[str], whole: Path, rng: random.Random
    ) -> None:
        self.journal, self.trace = folder / "journal", folder / "trace.jsonl"
        self.errors = folder / "errors"
        self.rng = rng
        self._args, self._whole = args, whole.read_bytes()

    def start(self, cycles: int) -> int:
        """Begin the run, or resume it if it has a journal."""
        resume = (self.journal / "meta").exists()
        args: Sequence[str] = ("run", "--resume", str(self.journal))
        if not resume:
            shutil.rmtree(self.journal, ignore_errors=True)
            files = ("--trace", str(self.trace), "--journal", str(self.journal))
            args = ("run", *self._args, *files, "--journal-limit", "1")
        return started(args, self.errors, cycles)

    def kill(self, seconds: float, after: Callable[[], None]) -> int:
        """Kill the run until it ends; return the number of kills.

        Args:
            seconds: the longest time before a kill.
            after: called after each kill.
        """
        kills, cycles = 0, self.rng.choice(CYCLES)
        while True:
            process = self.start(cycles)
            time.sleep(self.rng.uniform(0, seconds))
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)
            status = ended(process)
            if status != -signal.SIGKILL:
                self.check(status)
                return kills
            kills += 1
            seconds *= 1.05  # a run gets to its end
            after()

    def check(self, status: int) -> None:
        """Raise AssertionError if the trace is not that of the whole run."""
        if status not in (0, 1):
            raise AssertionError(f"status {status}: {self.errors.read_text()}")
        if self.trace.read_bytes() != self._whole:
            raise AssertionError(f"another trace: {self.trace}")

    def cut(self) -> bool:
        """Cut a file at a random byte, resume; return whether the run was resumed."""
        files = sorted(one for one in self.journal.iterdir() if one.stat().st_size)
        parts = [one for one in files if one.name.startswith("journal")]
        last = parts[-1:] if self.rng.random() < 0.7 else []
        file = self.rng.choice(last or files)
        os.truncate(file, self.rng.randrange(file.stat().st_size))
        if self.rng.random() < 0.2 and self.trace.exists():
            os.truncate(self.trace, self.rng.randint(0, self.trace.stat().st_size))
        if not (self.journal / "meta").exists():
            raise AssertionError("the journal has no meta")
        status = ended(self.start(1000))
        if status == REFUSED:
            lines = self.errors.read_text().splitlines()
            if not lines[0].startswith("error: ") or "internal" in lines[0]:
                raise AssertionError("\n".join(lines))
            return False
        self.check(status)
        return True


class Robot(NamedTuple):
    """A robot that goes on when the interpreter dies, in a process of its own."""

    #: The Python program of the robot; the last argument is its socket.
    program: Sequence[str]
    library: CheckedLibrary
    tasks: Sequence[str]
    #: Returns the world, by the socket.
    world: Callable[[str], World]
    #: Whether the robot has done each request once, by its counts.
    once: Callable[[Any], bool]
    #: Whether a run has taken in each datum once, by all its data in order.
    exact: Callable[[Sequence[str]], bool]

    def run(self, socket: str, folder: Path) -> None:
        """Begin or resume the run, and bring it to its end."""
        library, world = self.library, self.world(socket)
        journalled, trace = folder / "journal", folder / "trace.jsonl"
        if (journalled / "meta").exists():
            durable = resume(journalled, library.program, world, trace=trace)
        else:
            shutil.rmtree(journalled, ignore_errors=True)
            run = library.start(world, tasks=self.tasks, begin=False)
            durable = begin(journalled, run, trace=trace)
        assert durable.go() == "done"
        durable.close()


def peer() -> Robot:
    """Return a robot whose world is resumable."""
    wanted = {(name, n): 1 for name in ("look", "work") for n in range(1, JOBS + 1)}
    return Robot(
        ("-m", "tests.durable.peer"),
        loads(live.library(JOBS)),
        ["(all)"],
        lambda socket: live.ResumablePeer(live.at(socket)),
        lambda counts: dict(counts[0]) == dict(counts[1]) == wanted,
        lambda data: data == [f"(beat {1 + n * live.PACE})" for n in range(len(data))],
    )


def conveyor() -> Robot:
    """Return the conveyor of the examples, with its driver; several jobs at once."""
    folder = HERE / "examples" / "conveyor"
    sys.path.insert(0, str(folder))
    watchdog.PERIOD = 60.0  # a loaded machine stops no body
    driver = importlib.import_module("conveyor").Conveyor
    wanted = {f"p{n}": 1 for n in range(1, JOBS + 1)}
    return Robot(
        (str(folder / "controller.py"),),
        load(folder / "conveyor.rap").extend(SCANS),
        [
            *(f"(dispatch {one}) :at {n * 0.05}" for n, one in enumerate(wanted)),
            *(f"(see {one})" for one in wanted),
        ],
        lambda socket: driver(options={"socket": socket}),
        lambda counts: all(one == wanted for one in counts),
        lambda data: sorted(data) == sorted(f"(scanned {one})" for one in wanted),
    )


def killed_live(robot: Robot, kills: int, rng: random.Random, folder: Path) -> int:
    """Kill a run with a robot some times, at least; return how often it was killed.

    Raises:
        AssertionError: if a request or a datum did not happen exactly once.
    """
    socket, done = str(folder / "socket"), 0
    command = [sys.executable, *robot.program, socket]
    with subprocess.Popen(command, cwd=HERE, stdout=subprocess.PIPE) as machine:
        assert machine.stdout is not None
        machine.stdout.readline()
        while True:
            process = os.fork()
            if not process:
                try:
                    robot.run(socket, folder)
                    if done < kills:
                        signal.pause()  # the kill comes late on a slow machine
                    os._exit(0)
                except BaseException:
                    traceback.print_exc()
                    os._exit(1)
            if done < kills:
                time.sleep(rng.uniform(0.05, 0.35))
                os.kill(process, signal.SIGKILL)
            status = ended(process)
            if status != -signal.SIGKILL:
                break
            done += 1
        counts = live.at(socket)("counts")
        machine.terminate()
    if status:
        raise AssertionError(f"status {status}")
    if not robot.once(counts):
        raise AssertionError(counts)
    data = data_in(folder / "trace.jsonl")
    if not robot.exact(data):
        raise AssertionError(data)
    return done


def data_in(trace: Path) -> list[str]:
    """Return the data of a trace, in order."""
    events = map(json.loads, trace.read_text().splitlines())
    return [one["data"] for one in events if one["event"] == "data-received"]


def measured(
    names: Sequence[str], kills: int, cuts: int, seed: int, folder: Path
) -> dict[str, Counts]:
    """Kill and cut some of `RUNS`; return how many were resumed and refused, by run.

    The runs share the numbers of kills and of cuts.
    """
    rng, found = random.Random(seed), {}
    os.chdir(HERE)
    for name in names:
        args = (*RUNS[name], "--seed", str(seed))
        whole = folder / f"{name}.jsonl"
        seconds = run_whole(args, whole)
        done, cut, refused = 0, 0, 0
        while done < kills // len(names) or cut < cuts // len(names):
            one = folder / "one"
            shutil.rmtree(one, ignore_errors=True)
            one.mkdir()
            run = Killed(one, args, whole, rng)
            copies: list[Path] = []

            def keep(one: Path = one, copies: list[Path] = copies) -> None:
                if (one / "journal" / "meta").exists():
                    copy = folder / f"copy-{len(copies)}"
                    shutil.rmtree(copy, ignore_errors=True)
                    shutil.copytree(one, copy)
                    copies.append(copy)

            done += run.kill(seconds * 0.4, keep)
            for copy in copies:
                if cut < cuts // len(names):
                    # the journal names its trace, so the copy goes to its place
                    shutil.rmtree(one)
                    shutil.copytree(copy, one)
                    refused += not run.cut()
                    cut += 1
            counts = f"{done} kills, {cut} cuts ({refused} refused)"
            print(f"{name}: {counts}", file=sys.stderr, flush=True)
        found[f"{name}: kills"] = Counts(done)
        found[f"{name}: cuts"] = Counts(cut - refused, refused)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--cuts", type=int, default=1000)
    parser.add_argument("--live", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rng = random.Random(given.seed)
    for robot in (peer, conveyor):
        done = 0
        while done < given.live:
            with tempfile.TemporaryDirectory() as folder:
                done += killed_live(robot(), KILLS, rng, Path(folder))
            print(f"{robot.__name__}: {done} kills", file=sys.stderr, flush=True)
        print(f"{done} kills with a {robot.__name__}: each request and datum once")
    scratch = Path(tempfile.mkdtemp())
    found = measured([*RUNS], given.kills, given.cuts, given.seed, scratch)
    shutil.rmtree(scratch)  # not after an error: its message names a file in there
    for name, counts in found.items():
        print(f"{name:<22} {counts.same:>6} same {counts.refused:>6} refused")


if __name__ == "__main__":
    main()
