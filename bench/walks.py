"""Count the files and calls of three walks through the code.

    python -m bench.walks            # a line for each walk
    python -m bench.walks --files    # with the files in the order of the walk

- `datum`: from a message of the world to the agenda, by a monitor that it wakes.
- `submit`: from the text of a top-level task to the agenda.
- `why`: from the input `:why` to its answer; only files of debug and repl count.

A walk is made once before it is counted, so that everything is compiled and imported.
Comprehensions and lambdas are not counted as calls.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FrameType

import rapc
from rapc.debug.history import History
from rapc.repl.commands.table import commands
from rapc.repl.shell import Shell
from rapc.world import (
    Datum,
    Fact,
    HandlerMemory,
    Handlers,
    Kit,
    Message,
    Offer,
    Reply,
    Time,
    World,
)

LIBRARY = """
(declare-memory-proposition lit (?lamp))
(declare-primitive flash (?lamp) (okay))
(declare-sensor-datum seen (?lamp))
(define-rap (watch ?lamp)
  (monitor-state (lit ?lamp))
  (method (primitive (flash ?lamp))))
(define-rap (round ?lamp)
  (method (task-net (t1 (watch ?lamp)))))
"""

PACKAGE = str(Path(rapc.__file__).parent) + "/"


def _seen(memory: HandlerMemory, datum: Fact) -> None:
    memory.assert_fact("lit", datum[1])


class Lamps(World):
    """Lamps that are seen at the times 5 and 10."""

    name = "lamps"
    kit = Kit(
        offer=Offer(primitives={"flash": (1, ("okay",))}, data={"seen": 1}),
        handlers=Handlers(data={"seen": _seen}),
    )

    def __init__(self) -> None:
        self.clock: Time = 0
        self.left = {5: "d1", 10: "d2"}
        self.sent: Callable[[], None] = lambda: None

    def now(self) -> Time:
        return self.clock

    def perform(self, ticket: int, request: Fact) -> Reply:
        return Reply("okay")

    def next_time(self) -> Time | None:
        return min(self.left, default=None)

    def advance(self, to: Time) -> None:
        self.clock = to

    def messages(self) -> Sequence[Message]:
        due = [time for time in self.left if time <= self.clock]
        found = [Datum(("seen", self.left.pop(time))) for time in due]
        if found:
            self.sent()
        return found


class Walk:
    """The files and functions that were called, in order, until the agenda was met."""

    def __init__(self, only: tuple[str, ...] = ("",), end: str = "") -> None:
        self.calls: list[tuple[str, str]] = []
        self._only = tuple(PACKAGE + part for part in only)
        self._end = end
        self._over = False

    def __call__(self, frame: FrameType, event: str, arg: object) -> None:
        code = frame.f_code
        if event != "call" or self._over or not code.co_filename.startswith(self._only):
            return
        if code.co_name.startswith("<"):
            return
        self.calls.append((code.co_filename.removeprefix(PACKAGE), code.co_name))
        self._over = bool(self._end) and self.calls[-1] == tuple(self._end.split(":"))

    def files(self) -> list[str]:
        """Return the files in the order in which they were entered."""
        return list(dict.fromkeys(file for file, _ in self.calls))

    def changes(self) -> int:
        """Return how often a call came from another file than the call before."""
        return sum(
            one != two
            for (one, _), (two, _) in zip(self.calls, self.calls[1:], strict=False)
        )


AGENDA = "runtime/state/agenda.py:add"


def datum() -> Walk:
    """Walk from a message of the world to the agenda."""
    world = Lamps()
    run = rapc.loads(LIBRARY).start(world, tasks=["(watch d1)", "(watch d2)"])
    walk = Walk(end=AGENDA)
    while 10 in world.left:
        if 5 not in world.left:
            world.sent = lambda: sys.setprofile(walk)
        if not run.step():
            break
    sys.setprofile(None)
    return walk


def submit() -> Walk:
    """Walk from the text of a task to the agenda."""
    run = rapc.loads(LIBRARY).start(Lamps())
    run.submit("(round d1)")
    walk = Walk(end=AGENDA)
    sys.setprofile(walk)
    run.submit("(round d2)")
    sys.setprofile(None)
    return walk


def why() -> Walk:
    """Walk from the input `:why` to its answer."""
    library = rapc.load("rapc:truck")
    session = History.open(library, "truck", tasks=["(fill-order red 4 factory-1)"])
    for _ in range(300):
        session.step()
    shell = Shell(session, commands())
    shell.answer(":why")
    walk = Walk(only=("debug/", "repl/"))
    sys.setprofile(walk)
    shell.answer(":why")
    sys.setprofile(None)
    return walk


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", action="store_true", help="list the files")
    asked = parser.parse_args()
    for name, made in (("datum", datum), ("submit", submit), ("why", why)):
        walk = made()
        files = walk.files()
        print(
            f"{name}: {len(files)} files, {walk.changes()} changes of file, "
            f"{len(walk.calls)} calls"
        )
        if asked.files:
            print("  " + "\n  ".join(files))


if __name__ == "__main__":
    main()
