"""The main job: one order of four rocks, filled by the truck.

Once inside this process, for the time that the run itself takes, and once as a command
of its own, for what a person waits: till the first line of the trace, and in all.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator

from bench.common import Figure, compiled
from rapc.compiler.program import Program
from rapc.events import Event
from rapc.library import loader
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest
from rapc.worlds import registry

LIBRARY = '(require "truck")\n'
GOAL = ("fill-order", "red", 4, "factory-1")
COMMAND = (
    *("-c", "from rapc.cli.start import main; main()"),
    *("run", "-", "--world", "truck", "--task", "(fill-order red 4 factory-1)"),
)


def _fill(library: Program, seed: int) -> tuple[float, float, Event]:
    """Wall and CPU seconds of one run, and its last event; raises if it fails."""
    world = registry.build_world(registry.find_world("truck"), seed, {})
    interpreter = Interpreter(library, world, seed)
    last: deque[Event] = deque(maxlen=1)
    interpreter.listen(last.append)
    wall, cpu = time.perf_counter(), time.process_time()
    interpreter.submit(TaskRequest(GOAL))
    interpreter.run()
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    [result] = interpreter.results()
    if result.outcome != "succeeded":
        raise ValueError(result)
    return wall, cpu, last[0]


def _command() -> tuple[float, float]:
    """Seconds till `rapc run` prints a line, and till its end; raises if it fails."""
    start = time.perf_counter()
    with subprocess.Popen(
        [sys.executable, *COMMAND],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(LIBRARY)
        process.stdin.close()
        process.stdout.readline()
        first = time.perf_counter() - start
        process.stdout.read()
    if process.returncode != 0:
        raise ValueError(f"the main job ended with status {process.returncode}")
    return first, time.perf_counter() - start


def figures(quick: bool = False) -> Iterator[Figure]:
    """Medians over seeds, and of a few commands."""
    library = compiled(loader.load_text(LIBRARY))
    seeds = range(1 if quick else 20)
    runs = [_fill(library, seed) for seed in seeds]
    size = f"{len(runs)} seeds, median"
    walls, cpus, ends = zip(*runs, strict=True)
    wall, cpu = statistics.median(walls), statistics.median(cpus)
    cycles = statistics.median(end.cycle for end in ends)
    units = statistics.median(end.time for end in ends)
    yield Figure("order", "wall time of a run", size, wall * 1e3, "ms")
    yield Figure("order", "CPU time of a run", size, cpu * 1e3, "ms")
    yield Figure("order", "cycles of a run", size, cycles, "cycles")
    yield Figure("order", "simulated time of a run", size, units, "time units")
    yield Figure("order", "cycles a CPU second", size, cycles / cpu, "cycles/s")
    commands = [_command() for _ in range(1 if quick else 5)]
    first, whole = (statistics.median(times) for times in zip(*commands, strict=True))
    yield Figure("order", "`rapc run`: first line", "seed 0", first, "s")
    yield Figure("order", "`rapc run`: all of it", "seed 0", whole, "s")
