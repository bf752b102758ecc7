"""Waiting: what it costs to wake one of many monitors, and to leave the others alone.

n tasks sleep, each on a fact of its own. One firing asserts such a fact; its task wakes
up, has the fact erased by a primitive, and sleeps again. The long run lets five
monitors wake by time and go through two steps each, a million cycles in all, and looks
at how much memory the process has come to take.
"""

from __future__ import annotations

import resource
from collections.abc import Iterator

from bench.common import Figure, compiled, seconds
from rapc.library import loader
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import TaskRequest
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

SLEEPERS = """\
(declare-primitive reset (?sensor) (okay))
(declare-memory-proposition sensor (?sensor ?state))
(define-rap (watch ?sensor)
  (succeed nil)
  (monitor-state (sensor ?sensor on))
  (method
    (primitive (reset ?sensor))))
"""

CLOCKS = """\
(declare-primitive tick (?name) (okay))
(declare-memory-proposition busy (?name))
(define-rap (clock ?name)
  (resources (counter ?ticks 0))
  (succeed nil)
  (monitor-time now 1 5)
  (method
    (notations (busy ?name))
    (task-net
      (t1 (tick-once ?name)
          (counter-add ?ticks 1)
          (for t2))
      (t2 (tick-once ?name)))))
(define-rap (tick-once ?name)
  (method
    (primitive (tick ?name))))
"""

PATIENCE = Settings(idle_cycles=10**9)


def _asleep(count: int) -> Interpreter:
    """An interpreter in which so many tasks sleep."""
    library = compiled(loader.load_text(SLEEPERS))
    row = Row(("reset", "?sensor"), erases=(("sensor", "?sensor"),))
    world = ScriptedWorld([row], declared=library.library)
    interpreter = Interpreter(library, world, settings=PATIENCE)
    for number in range(count):
        interpreter.submit(TaskRequest(("watch", f"s{number}")))
    _until_quiet(interpreter)
    return interpreter


def _until_quiet(interpreter: Interpreter) -> None:
    while interpreter.step(wait=False):
        pass


def _fire(interpreter: Interpreter, count: int) -> None:
    for number in range(count):
        interpreter.assert_fact("sensor", f"s{number}", "on")
        _until_quiet(interpreter)


def _growth(cycles: int) -> tuple[float, float]:
    """Peak memory in MB after a tenth of so many cycles and after all of them."""
    library = compiled(loader.load_text(CLOCKS))
    world = ScriptedWorld([Row(("tick", "?name"))], declared=library.library)
    interpreter = Interpreter(library, world)
    for number in range(5):
        interpreter.submit(TaskRequest(("clock", f"c{number}")))
    found = []
    for part in (cycles // 10, cycles - cycles // 10):
        for _ in range(part):
            interpreter.step()
        found.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    return found[0], found[1]


def figures(quick: bool = False) -> Iterator[Figure]:
    """One firing among ever more sleepers, and a long run's growth."""
    cycles = 10_000 if quick else 1_000_000
    early, late = _growth(cycles)
    what = "peak memory gained after the first tenth"
    yield Figure("monitors", what, f"{cycles:,} cycles", late - early, "MB")
    for count in (10, 100) if quick else (10, 1_000, 10_000, 100_000):
        interpreter = _asleep(count)
        fired = min(count, 1_000)
        each = seconds(lambda i=interpreter, n=fired: _fire(i, n)) / fired  # type: ignore[misc]
        yield Figure("monitors", "one firing", f"{count:,} asleep", each * 1e6, "us")
