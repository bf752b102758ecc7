"""Peak memory of standing tasks that choose with a new binding in each cycle.

    python -m bench.standing --cycles 1000000

Two tasks are never done and never blocked. Before each cycle the host asserts another
number, which the context of their method binds, so that no two choices are the same.
The peak is printed after each tenth of the cycles, and the growth after the first.
"""

from __future__ import annotations

import argparse
import resource
from collections.abc import Iterator

from bench.common import compiled
from rapc.library import loader
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import TaskRequest
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

LIBRARY = """\
(declare-primitive tick (?name ?turn) (okay))
(declare-memory-proposition done (?name))
(declare-memory-property turn (?turn) unknown)
(define-rap (follow ?name)
  (succeed (done ?name))
  (method
    (context (turn ?turn))
    (primitive (tick ?name ?turn))))
"""


def peaks(cycles: int) -> Iterator[float]:
    """Yield the peak memory of the process in MB after each tenth of `cycles`."""
    library = compiled(loader.load_text(LIBRARY))
    world = ScriptedWorld([Row(("tick", "?", "?"))], declared=library.library)
    run = Interpreter(library, world, settings=Settings(idle_cycles=10 * cycles))
    for name in ("a", "b"):
        run.submit(TaskRequest(("follow", name)))
    for part in range(10):
        for turn in range(cycles // 10):
            run.assert_fact("turn", part * cycles // 10 + turn)
            run.step()
        yield resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> None:
    """Print the peaks and the growth after the first tenth."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cycles", type=int, default=1_000_000)
    cycles = parser.parse_args().cycles
    found = []
    for part, peak in enumerate(peaks(cycles), 1):
        print(f"{part * cycles // 10:>10,} cycles {peak:8.1f} MB", flush=True)
        found.append(peak)
    print(f"growth after the first tenth: {found[-1] - found[0]:.1f} MB")


if __name__ == "__main__":
    main()
