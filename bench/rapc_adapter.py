"""rapc in benchmarks beside its peers, through what it offers to anyone.

That is what `import rapc` has, and for the world's side the port that every world is
written against, `rapc.world`. Only the reader by itself, which no program that
runs RAPs calls, is taken from inside, for w1.

The script that measures the peers runs this file with its `Peer` and `peer` as
globals, and asks it for five workloads: a library read (w1), a memory queried (w2),
monitors that sleep until a fact comes (w3, and what each takes of memory: w5), and a
tree of tasks expanded and carried out (w4). Nothing is left out that a user's program
would have: source text goes through reader and checker, facts get their time stamps,
tasks their history, families and deadlines, and the world is a class of its own
behind the port, with handlers, whose primitives call Python functions.
"""

# mypy: disable-error-code="name-defined,misc"
# ruff: noqa: F821

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import rapc
from rapc.base.source import SourceFile
from rapc.base.values import Atom, Fact
from rapc.parser.parse import parse
from rapc.parser.reader import read
from rapc.world import (
    Handlers,
    Kit,
    Message,
    Offer,
    Reply,
    Time,
    World,
)

MONITORS = """\
(declare-primitive reset (?sensor) (okay))
(declare-memory-proposition sensor (?sensor ?state))
(define-rap (watch ?sensor)
  (succeed nil)
  (monitor-state (sensor ?sensor on))
  (method
    (primitive (reset ?sensor))))
"""

READY = """\
(declare-primitive nothing () (okay))
(declare-memory-property ready (?state) unknown)
(define-rap (level-0)
  (method
    (context (ready yes))
    (primitive (nothing))))
"""

LEVEL = """\
(define-rap (level-{level})
  (method
    (context (ready yes))
    (task-net {steps})))
"""

INPUTS = """\
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

ITEMS = """\
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property class (?item ?class ?value) unknown)
(declare-memory-property color (?item ?color) unknown)
(declare-memory-property size (?item ?size) unknown)
"""

QUERY = "(and (location ?x ?p) (class ?x rock true) (size ?x ?k) (> ?k 3))"

WORDS = """\
(declare-memory-property location (?thing ?place) unknown)
(declare-memory-property size (?thing ?size) unknown)
(declare-memory-proposition at (?place))
"""

DEFINITION = """\
(declare-memory-proposition arm-holding-{i} (?arm ?thing))
(define-rap (goto-{i} ?place))
(define-rap (grasp-{i} ?arm ?thing))
(define-rap
  (index (pickup-{i} ?arm ?thing))
  (succeed (arm-holding-{i} ?arm ?thing))
  (method m{i}
    (context (and (location ?thing ?p{k}) (not (= ?p{k} unknown))
                  (size ?thing ?size) (> ?size {k})))
    (task-net
      (t1 (goto-{i} ?p{k}) ((at ?p{k}) for t2))
      (t2 (grasp-{i} ?arm ?thing)))))
"""


class Functions(World):
    """A world in this process: each of its primitives is a Python function.

    `reset` erases what it is asked to; the clock stands still.
    """

    name = "functions"

    def __init__(
        self,
        rng: random.Random | None = None,
        options: Mapping[str, Atom | bool] | None = None,
        *,
        primitives: Mapping[str, tuple[int, Callable[..., None]]] | None = None,
    ) -> None:
        given = primitives or {}
        self._calls = {name: call for name, (_, call) in given.items()}
        arity = {name: (arity, ("okay",)) for name, (arity, _) in given.items()}
        # After a `reset` the robot believes the sensor's state no longer.
        self.kit = Kit(Offer(arity), Handlers({"reset": _forget}))

    def now(self) -> Time:
        """Always the beginning."""
        return 0

    def perform(self, ticket: int, request: Fact) -> Reply:
        """Call the function at once."""
        self._calls[str(request[0])](*request[1:])
        return Reply("okay")

    def next_time(self) -> None:
        """Never: nothing comes unasked."""
        return

    def advance(self, to: Time) -> None:
        """The clock stands still."""

    def messages(self) -> Sequence[Message]:
        """None."""
        return ()


def _forget(memory: Any, request: Fact, result: str) -> None:
    memory.erase("sensor", request[1], "on")


def _compiled(text: str) -> Any:
    """A library from a file of source text: read, checked and compiled."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "library.rap"
        path.write_text(text, encoding="utf-8")
        return rapc.load(path).program


def _in_order(goals: Sequence[str]) -> str:
    """Steps one after the other."""
    count = len(goals)
    orders = [f" (for t{n + 1})" if n < count else "" for n in range(1, count + 1)]
    return " ".join(
        f"(t{n} {goal}{order})"
        for n, (goal, order) in enumerate(zip(goals, orders, strict=True), 1)
    )


def _levels(b: int, d: int) -> str:
    """One RAP for each level of the tree, each with one method."""
    levels = range(1, d + 1)
    return READY + "".join(
        LEVEL.format(level=n, steps=_in_order([f"(level-{n - 1})"] * b)) for n in levels
    )


@peer
class Rapc(Peer):
    """All that rapc does, nobody listening."""

    name = "rapc"
    note = "everything real; no trace"

    def available(self) -> str:
        for name in ("Interpreter", "JsonTrace", "TaskRequest", "load"):
            getattr(rapc, name)  # each is imported when it is first asked for
        return rapc.__version__

    def w1(self, text: str) -> int:
        """Text to the tree of lists and atoms that everything after works on.

        It is what the peers' readers make too: each list and atom knows its kind, its
        value and where it begins and ends; comments are kept with their places, and
        whatever is wrong with the text has been found. `rapc-ir` goes on from here.
        """
        return len(read(SourceFile("library.rap", text)).forms)

    def w2_setup(self, data: Sequence[tuple[str, str, str, str, int]]) -> None:
        self.run = rapc.Interpreter(_compiled(ITEMS), Functions())
        believe = self.run.assert_fact
        for item, place, kind, color, size in data:
            believe("location", item, place)
            believe("class", item, kind, "true")
            believe("color", item, color)
            believe("size", item, size)
        self.question = self.run.question(QUERY, "?p")

    def w2_first(self, place: str) -> str | None:
        found = self.question.first(place)
        return None if found is None else str(found["?x"])

    def w2_all(self, place: str) -> int:
        return len(self.question.all(place))

    def w3_setup(self, n: int) -> None:
        world = Functions(primitives={"reset": (1, self.woken)})
        self.run = rapc.Interpreter(_compiled(MONITORS), world)
        self.record()
        self.sensors = [f"s_{i}" for i in range(n)]
        for sensor in self.sensors:
            self.run.submit(rapc.TaskRequest(("watch", sensor)))
        self.run.run_ready()

    def woken(self, sensor: str) -> None:
        """What the primitive `reset` calls."""
        self.fired += 1

    def w3_fire(self, i: int) -> None:
        self.run.assert_fact("sensor", self.sensors[i], "on")
        self.run.run_ready()

    def w4_setup(self, b: int, d: int) -> None:
        self.library = _compiled(_levels(b, d))
        self.goal = rapc.TaskRequest((f"level-{d}",))

    def nothing(self) -> None:
        """What the primitive `nothing` calls."""

    def w4_run(self) -> int:
        world = Functions(primitives={"nothing": (0, self.nothing)})
        self.run = rapc.Interpreter(self.library, world)
        self.record()
        self.run.assert_fact("ready", "yes")
        self.run.submit(self.goal)
        self.run.run()
        assert self.run.results()[0].outcome == "succeeded"
        return self.run.succeeded

    def record(self) -> None:
        """Nobody listens."""


@peer
class RapcTraced(Rapc):
    """The same, and every event of the run is kept, complete and in order."""

    name = "rapc-traced"
    note = "everything real, all events kept"

    w1 = w2_first = property()

    def does(self, w: str) -> bool:
        return w in ("W3", "W4")

    def record(self) -> None:
        self.recording = self.run.record()


@peer
class RapcWritten(RapcTraced):
    """The same, and every event is made and written to a file as a line of JSON."""

    name = "rapc-written"
    note = "everything real, the trace written"

    def record(self) -> None:
        self.trace = tempfile.TemporaryFile("w", encoding="utf-8")  # noqa: SIM115
        self.run.listen(rapc.JsonTrace(self.trace))


@peer
class RapcInputs(Rapc):
    """W4 with one RAP for all levels: the depth is an input, a method for each case.

    Twice as much is asked and computed for a task as the workload wants.
    """

    name = "rapc-inputs"
    note = "W4: the depth as an input, two methods"

    def does(self, w: str) -> bool:
        return w == "W4"

    def w4_setup(self, b: int, d: int) -> None:
        steps = _in_order(["(inner (- ?depth 1))"] * b)
        text = INPUTS.format(steps=steps, leaves=_in_order(["(leaf)"] * b))
        self.library = _compiled(text)
        self.goal = rapc.TaskRequest(("inner", d))


@peer
class RapcIr(Peer):
    """Reading further: what each form says, as typed nodes with their places."""

    name = "rapc-ir"
    note = "W1: to the nodes that checker and compiler work on"

    def available(self) -> str:
        return rapc.__version__

    def w1(self, text: str) -> int:
        return len(parse(SourceFile("library.rap", text)).forms)


@peer
class RapcLoad(Peer):
    """Reading, checking and compiling together.

    The text is written to a file, for that is what is compiled. The definitions ask for
    two RAPs and a fact of their own each: these are declared, but not counted. All that
    a task needs of a definition is compiled, but for the queries, each of which becomes
    code when it is first asked.
    """

    name = "rapc-load"
    note = "W1: read, check, compile"

    def available(self) -> str:
        return rapc.__version__

    def w1_text(self, n: int) -> str:
        return WORDS + "".join(DEFINITION.format(i=i, k=i % 10) for i in range(n))

    def w1(self, text: str) -> int:
        library = _compiled(text)
        names = (name for name in library.library.raps if name.startswith("pickup-"))
        return sum(1 for name in names if library.rap(name) is not None)
