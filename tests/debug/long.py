"""A session that lasts: how much memory it takes, and how long the way back is.

    python -m tests.debug.long --cycles 1000000

lets a robot patrol for that many cycles under a session, goes back 10,000 of them, and
prints the largest size that the process had and the processor time of the way back.
"""

from __future__ import annotations

import argparse
import resource
from time import process_time

import msgspec

import rapc
from rapc.debug.history import History
from rapc.runtime.settings import Settings
from rapc.worlds.scripted import ScriptedWorld
from tests.debug.sessions import row

BACK = 10_000
"""How many cycles are gone back."""

PATROL = """
(declare-primitive walk (?place) (okay blocked))
(declare-memory-property at (?robot ?place) unknown)
(declare-memory-proposition off-duty)
(define-rap (patrol)
  (succeed (off-duty))
  (method (task-net (t1 (go-to east) (for t2)) (t2 (go-to west)))))
(define-rap (go-to ?place)
  (succeed (at robot ?place))
  (method (primitive (walk ?place))))
"""


class Measured(msgspec.Struct):
    """What a long session took."""

    cycles: int
    #: The largest size of the process, in millions of bytes.
    megabytes: float
    #: The processor time of all cycles, and of going back, in seconds.
    forth: float
    back: float
    #: How many states are kept, and how many bytes they take.
    states: int
    bytes_kept: int


def patrol() -> History:
    """Return a session with a robot that walks to and fro for ever."""
    walks = (
        row("(walk ?place)", "blocked", 1, times=1),
        row("(walk ?place)", "okay", 1, asserts=(("at", "robot", "?place"),)),
    )
    library = rapc.loads(PATROL, "patrol.rap")
    world = ScriptedWorld(list(walks), declared=library.program.library)
    forever = Settings(futile_limit=10**9)
    return History.open(library, world, tasks=["(patrol)"], settings=forever)


def measured(session: History, cycles: int) -> Measured:
    """Let a session run for some cycles, go back, and say what that took."""
    start = process_time()
    session.goto(cycles)
    forth = process_time() - start
    assert session.cycle == cycles, session.stand()
    start = process_time()
    session.goto(cycles - BACK)
    back = process_time() - start
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000
    saves = session.branch.saves
    kept = sum(len(save.state) for save in saves.values())
    return Measured(cycles, size, forth, back, len(saves), kept)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cycles", type=int, default=1_000_000)
    found = measured(patrol(), parser.parse_args().cycles)
    print(
        f"{found.cycles:,} cycles: {found.megabytes:.0f} MB at most, "
        f"{found.forth:.0f} s of CPU; {BACK:,} cycles back: {found.back:.2f} s; "
        f"{found.states} states of {found.bytes_kept / 1e6:.1f} MB"
    )


if __name__ == "__main__":
    main()
