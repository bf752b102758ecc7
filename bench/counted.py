"""One piece of work, done so many times: what `bench.instructions` runs under valgrind.

    python -P bench/counted.py WORK TIMES

It is run in a checkout, which may be an older one, with the bench of that checkout: so
this file imports nothing of rapc, and speaks of what has been there from the first.
The work is set up and done once beforehand; the difference between two numbers of times
is what it takes itself.
"""

from __future__ import annotations

import gc
import importlib
import random
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

Work = Callable[[], object]

ITEMS, PLACES, MONITORS, DEPTH, DEFINITIONS = 1000, 50, 200, 6, 50

CLASSES = {
    "": "Rapc",
    "kept": "RapcTraced",
    "written": "RapcWritten",
    "inputs": "RapcInputs",
}


_OPEN: list[Iterator[object]] = []
"""What has made a piece of work: the files of that are there until it is closed."""


class Peer:
    """What the classes of an adapter are made from."""


def _adapter(name: str) -> Any:
    file = Path("bench", "rapc_adapter.py")
    scope = {"__name__": "adapter", "Peer": Peer, "peer": lambda made: made}
    exec(compile(file.read_text(), str(file), "exec"), scope)  # noqa: S102
    made: Any = scope[name]
    one = made()
    one.fired = 0
    return one


def _shared(workload: str, how: str) -> Work:
    """A workload that is shared with the peers."""
    if workload == "W1":
        text = _adapter("RapcLoad").w1_text(DEFINITIONS)
        names = {"lists": "Rapc", "nodes": "RapcIr", "library": "RapcLoad"}
        reader = _adapter(names[how])
        return lambda: reader.w1(text)
    one = _adapter(CLASSES.get(how, "Rapc"))
    if workload == "W2":
        dice = random.Random("items")
        rows = ((f"i{n}", f"p{dice.randrange(PLACES)}") for n in range(ITEMS))
        one.w2_setup([(*row, "rock", "red", dice.randrange(9)) for row in rows])
        ask = one.w2_first if how == "first" else one.w2_all
        return lambda: [ask(f"p{n}") for n in range(PLACES)]
    if workload == "W3":
        one.w3_setup(MONITORS)
        return lambda: [one.w3_fire(n) for n in range(MONITORS)]
    one.w4_setup(3, DEPTH)
    run: Work = one.w4_run
    return run


def _row(bench: str, number: int, quick: bool) -> Work:
    """The work behind one of the figures of a bench, by its number among them."""
    module = importlib.import_module(f"bench.{bench}")
    timed: list[Work] = []

    def seconds(work: Work, **_: object) -> float:
        timed.append(work)
        return 1.0

    module.seconds = seconds  # type: ignore[attr-defined]  # it has imported it
    figures: Iterator[object] = module.figures(quick)
    while len(timed) <= number:
        next(figures)
    _OPEN.append(figures)
    return timed[number]


def _digest(kinds: int) -> Work:
    """A property seen of items that look alike, or of which each is different."""
    memory: Any = importlib.import_module("bench.memory")
    return lambda: memory.digest(100, kinds)


def _order() -> Work:
    """An order of four rocks, from an empty agenda to the end."""
    order: Any = importlib.import_module("bench.order")
    library = order.compiled(order.loader.load_text(order.LIBRARY))
    return lambda: order._fill(library, 0)


def _passes(number: int) -> Work:
    """The passes behind a figure of `parse`; all, where there are the oldest alone."""
    module = importlib.import_module("bench.parse")
    return _row("parse", number if hasattr(module, "OLDEST") else ALL_PASSES, True)


ALL_PASSES, OLDEST, ERRORS = 3, 6, 7
"""Which of the figures of `parse` are those of passes."""


def _still() -> Work:
    """The thesis' run in the still world."""
    chapter6: Any = importlib.import_module("bench.chapter6")
    config = chapter6.session().points[0].config
    return lambda: chapter6.run(config, 0)


def work_of(name: str) -> Work:
    """Return a piece of work, set up: `W3`, `W4 kept`, `agenda 0`, `chapter6`."""
    first, _, rest = name.partition(" ")
    if first == "memory":
        return _digest(10 if rest == "alike" else 100)
    if first == "order":
        return _order()
    if first == "passes":
        return _passes({"oldest": OLDEST, "errors": ERRORS}[rest])
    if first == "chapter6":
        return _still()
    if first.startswith("W"):
        return _shared(first, rest)
    return _row(first, int(rest), quick=first != "agenda")


def main() -> None:
    """Do a piece of work as often as the command line says."""
    sys.path.insert(0, str(Path.cwd()))
    work = work_of(sys.argv[1])
    work()
    gc.collect()
    for _ in range(int(sys.argv[2])):
        work()


if __name__ == "__main__":
    main()
