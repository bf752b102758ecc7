"""Saved runs of which one record is changed, under a checksum that fits.

    python -m tests.runtime.changed_saves --records 20000

Runs of the truck, the courier and the hallway are saved at several points. A record of
such a save is dropped, doubled, moved or given another value; then a run takes the save
up. Either `restore` raises a `StateError` and leaves the run as it was, or the run goes
on for 30 cycles and can be saved and restored again. The world or a handler may end it
with a `PortError` or `FactError`, as records and world can be of different moments;
these runs are counted. All else is a fault: the script prints it, and its status is 1.
"""

from __future__ import annotations

import argparse
import random
import signal
import sys
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import msgspec

from rapc.errors import FactError, PortError, StateError
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving import format
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import of_agenda
from rapc.worlds.courier import CourierWorld
from rapc.worlds.hallway import HallwayWorld
from rapc.worlds.hallway.map_text import named_map
from rapc.worlds.registry import build_world
from rapc.worlds.truck import TruckWorld
from tests.courier import shifts
from tests.hallway import sent
from tests.runtime import saving

CYCLES = 30
"""The cycles that a run goes on for after it has been restored."""

HANGS = 60
"""Seconds after which the script takes a restored run for one that hangs."""

Json = Any

Path = tuple[int | str, ...]
"""A place in records: keys and positions, from the outside."""

WORDS = ("", "?x", "nil", "robot", "no-such-name", "(a b)", "0")

NUMBERS = (-1, 0, 1, 2, 7, 10**9, -(10**9), 2**70, 0.5, 1e300)


# --- runs ---------------------------------------------------------------------------

SETTINGS = Settings(idle_cycles=1000, idle_waits=200, query_steps=10_000)
"""Bounds that let a run in vain end soon."""


def truck() -> Interpreter:
    """Return a run of the truck with enemies and nine orders."""
    world = build_world(TruckWorld, 3, {"fuel-spread": 0, **saving.HARD[3]})
    run = Interpreter(saving.library(), world, 3, SETTINGS)
    for task in saving.tasks():
        run.submit(task)
    return run


def courier() -> Interpreter:
    """Return a run of the courier's shift."""
    world = build_world(CourierWorld, 2, {})
    program = shifts.library(True).program
    run = Interpreter(program, world, 2, SETTINGS)
    for task in of_agenda(program.library, "shift"):
        run.submit(task)
    return run


def hallway() -> Interpreter:
    """Return a run of the hallway's tour with an order."""
    goal = named_map("default").landmark[3].name
    return sent.library().start(
        build_world(HallwayWorld, 4, {"usage": 4}),
        agenda="sightseeing",
        tasks=[f"(go-to {goal}) :at 60"],
        seed=4,
        settings=SETTINGS,
    )


RUNS: Mapping[str, tuple[Callable[[], Interpreter], Sequence[int]]] = {
    "truck": (truck, (1, 40, 300, 900, 2000)),
    "courier": (courier, (1, 20, 60, 150, 300)),
    "hallway": (hallway, (1, 10, 40, 90)),
}
"""The runs, each with the cycles after which it is saved."""


def saves(make: Callable[[], Interpreter], cycles: Sequence[int]) -> Iterator[bytes]:
    """Yield what a run is saved as after each of so many cycles."""
    run = make()
    for cycle in cycles:
        while run.recorder.cycle < cycle and run.step():
            pass
        yield run.save()


# --- changes ------------------------------------------------------------------------


class Save:
    """A saved run as records that can be changed one at a time."""

    def __init__(self, saved: bytes) -> None:
        self._body = saved.split(b"\n", 1)[1]
        records: Json = msgspec.json.decode(self._body)
        self._world = msgspec.json.decode(_bytes_of(records["world"]))
        records["world"] = self._world
        #: The places of all values, by the section of the records that they are in.
        self._places = {
            key: list(_places(value, (key,))) for key, value in records.items()
        }
        #: The values that stand somewhere under each key.
        self._alike: dict[str, list[Json]] = {}
        for key in self._places:
            for place in self._places[key]:
                self._alike.setdefault(_key_of(place), []).append(_at(records, place))

    def changed(self, dice: random.Random, section: str = "") -> tuple[str, bytes]:
        """Return what was changed, in words, and the save with this change.

        It is in the `section` of the records, or in any if none is named.
        """
        records: Json = msgspec.json.decode(self._body)
        records["world"] = msgspec.json.decode(_bytes_of(records["world"]))
        section = section or dice.choice(sorted(self._places))
        place = dice.choice(self._places[section])
        words = self._change(records, place, dice)
        if "world" in records:
            world = msgspec.json.encode(records["world"])
            records["world"] = msgspec.to_builtins(world)
        return words, format.sealed(msgspec.json.encode(records))

    def _change(self, records: Json, place: Path, dice: random.Random) -> str:
        above, key = _at(records, place[:-1]), place[-1]
        value = above[key]
        kind = dice.choice(("drop", "double", "swap", "other", "other", "value"))
        if kind == "drop":
            del above[key]
        elif kind == "double" and isinstance(above, list):
            above.insert(dice.randrange(len(above) + 1), value)
        elif kind == "swap":
            other = dice.choice(_keys(above))
            above[key], above[other] = above[other], value
        elif kind == "other":
            above[key] = dice.choice(self._alike[_key_of(place)])
        else:
            kind = "value"
            above[key] = _another(value, dice)
        now = above[key] if key in _keys(above) else None
        said = ".".join(map(str, place))
        return f"{kind} {said}: {value!r:.60} -> {now!r:.60}"


def _keys(above: Json) -> list[Json]:
    """Return the keys of an object, or the positions of a list."""
    return list(above) if isinstance(above, dict) else list(range(len(above)))


def _key_of(place: Path) -> str:
    """Return the last key of a place, with how deep below it the place is."""
    depth = next(n for n, part in enumerate(reversed(place)) if isinstance(part, str))
    return f"{place[-1 - depth]}+{depth}"


def _places(value: Json, place: Path) -> Iterator[Path]:
    yield place
    if isinstance(value, dict):
        for key, part in value.items():
            yield from _places(part, (*place, key))
    elif isinstance(value, list):
        for at, part in enumerate(value):
            yield from _places(part, (*place, at))


def _at(records: Json, place: Path) -> Json:
    for part in place:
        records = records[part]
    return records


def _another(value: Json, dice: random.Random) -> Json:
    """Return another value, most often of the same type."""
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float) and dice.random() < 0.8:
        near = value + dice.choice((-1, 1, 3))
        return dice.choice((near, near, dice.choice(NUMBERS)))
    if isinstance(value, str) and dice.random() < 0.8:
        return dice.choice((dice.choice(WORDS), value[:-1], f"{value}x"))
    return dice.choice((None, 0, "x", [], {}, [value], dice.choice(NUMBERS)))


def _bytes_of(text: str) -> bytes:
    return msgspec.convert(text, bytes)


# --- what comes of it ---------------------------------------------------------------


class Outcome(NamedTuple):
    """What came of a changed save: `refused`, `went on`, `ended` or `fault`."""

    kind: str
    said: str = ""


def tried(run: Interpreter, good: bytes, changed: bytes) -> Outcome:
    """Restore a changed save in a run that stands at `good`, and go on."""
    try:
        run.restore(changed)
    except StateError as error:
        if run.save() != good:
            return Outcome("fault", f"half replaced: {error}")
        return Outcome("refused", str(error))
    except Exception as error:
        return Outcome("fault", f"restore: {_where(error)}")
    return _go_on(run)


def _go_on(run: Interpreter) -> Outcome:
    try:
        for _ in range(CYCLES):
            if not run.step():
                break
        saved = run.save()
        run.restore(saved)
        same = run.save() == saved
    except (PortError, FactError) as error:
        return Outcome("ended", str(error))
    except Exception as error:
        return Outcome("fault", f"later: {_where(error)}")
    return Outcome("went on") if same else Outcome("fault", "restored, it is another")


def _where(error: BaseException) -> str:
    frame = traceback.extract_tb(error.__traceback__)[-1]
    name = frame.filename.rpartition("rapc/")[2]
    return f"{type(error).__name__} at {name}:{frame.lineno}: {error}"


def trials(
    name: str, records: int, seed: int, section: str = ""
) -> Iterator[tuple[str, Outcome]]:
    """Yield what was changed, and what came of it, for so many changed saves."""
    make, cycles = RUNS[name]
    good = list(saves(make, cycles))
    opened = [Save(saved) for saved in good]
    run = make()
    for number in range(records):
        dice = random.Random(f"{name}:{seed}:{number}")
        at = dice.randrange(len(good))
        run.restore(good[at])
        words, changed = opened[at].changed(dice, section)
        outcome = tried(run, good[at], changed)
        yield f"{name} {number}: {words}", outcome
        if outcome.kind == "fault":
            run = make()


def _hangs(*_: object) -> None:
    raise RuntimeError("it hangs")


def main() -> int:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--records", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--run", choices=RUNS)
    parser.add_argument("--section", default="", help="change only these records")
    given = parser.parse_args()
    signal.signal(signal.SIGALRM, _hangs)
    count: Counter[tuple[str, str]] = Counter()
    names = [given.run] if given.run else list(RUNS)
    for name in names:
        records = given.records // len(names)
        for words, outcome in trials(name, records, given.seed, given.section):
            signal.alarm(HANGS)
            count[name, outcome.kind] += 1
            if outcome.kind == "fault":
                print(f"{words}\n    {outcome.said}", flush=True)
    for (name, kind), number in sorted(count.items()):
        print(f"{name:10} {kind:10} {number:6}")
    return 1 if any(kind == "fault" for _, kind in count) else 0


if __name__ == "__main__":
    sys.exit(main())
