"""Running tasks: trees of tasks that do next to nothing, tasks per second.

Every task has one method with a context that holds; an inner one spawns its steps, a
leaf is a primitive that a scripted world answers at once. In the deep tree steps are
in order, so that few tasks are eligible; in the broad one they are not, so that most
of the tree stands on the agenda together.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator

from bench.common import Figure, compiled, seconds
from rapc.compiler.program import Program
from rapc.library import loader
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

LIBRARY = """\
(declare-primitive nothing () (okay))
(declare-memory-property ready (?state) unknown)
(define-rap (inner ?depth)
  (method go-on
    (context (and (ready yes) (> ?depth 1)))
    (task-net {steps}))
  (method last
    (context (and (ready yes) (<= ?depth 1)))
    (task-net {leaves})))
(define-rap (leaf)
  (method
    (context (ready yes))
    (primitive (nothing))))
"""


def _library(branching: int, in_order: bool) -> Program:
    tags = range(1, branching + 1)
    order = [f"(for t{n + 1})" if in_order and n < branching else "" for n in tags]
    steps = (f"(t{n} (inner (- ?depth 1)) {order[n - 1]})" for n in tags)
    leaves = (f"(t{n} (leaf) {order[n - 1]})" for n in tags)
    text = LIBRARY.format(steps=" ".join(steps), leaves=" ".join(leaves))
    return compiled(loader.load_text(text))


def _run(library: Program, depth: int, traced: bool = False) -> None:
    """One run of a tree; raises if it did not succeed."""
    world = ScriptedWorld([Row(("nothing",))], declared=library.library)
    interpreter = Interpreter(library, world)
    if traced:
        interpreter.listen(JsonTrace(io.StringIO()))
    interpreter.start()
    interpreter.assert_fact("ready", "yes")
    interpreter.submit(TaskRequest(("inner", depth)))
    interpreter.run()
    [result] = interpreter.results()
    if result.outcome != "succeeded":
        raise ValueError(result)


def figures(quick: bool = False) -> Iterator[Figure]:
    """A deep tree in order, the same with a trace, and a broad one without order."""
    deep, broad = (3, 2) if quick else (8, 4)
    in_order = _library(3, in_order=True)
    tasks = _tasks(3, deep)
    yield _figure("steps in order", tasks, lambda: _run(in_order, deep))
    what = "the same, traced as JSON"
    yield _figure(what, tasks, lambda: _run(in_order, deep, traced=True))
    free, tasks = _library(10, in_order=False), _tasks(10, broad)
    yield _figure("steps in any order", tasks, lambda: _run(free, broad))


def _tasks(branching: int, depth: int) -> int:
    return sum(branching**level for level in range(depth + 1))


def _figure(what: str, tasks: int, work: Callable[[], None]) -> Figure:
    rate = tasks / seconds(work, rounds=3)
    return Figure("agenda", what, f"{tasks:,} tasks", rate, "tasks/s")
