"""Twenty faults, each planted in a copy of a shipped library, to be found by debugging.

`python -m tests.debug.planted FOLDER` writes a folder for each fault with the library,
and prints how the faulty and the sound library end.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator, Mapping
from itertools import takewhile
from pathlib import Path

import msgspec

import rapc
from rapc.base.values import Atom, format_atom, readable

CHECKOUT = Path(__file__).parents[2]
LIBRARIES = {
    "courier": CHECKOUT / "examples" / "courier",
    "truck": CHECKOUT / "stdlib" / "truck",
    "hallway": CHECKOUT / "stdlib" / "hallway",
    "laboratory": CHECKOUT / "examples" / "laboratory",
}
WORLDS = {"laboratory": "laboratory:LaboratoryWorld"}
"""The worlds whose names are not those of their libraries."""


class Fault(msgspec.Struct, frozen=True):
    """A fault: an edit of a library, and a run that shows the fault."""

    name: str
    #: How it shows: `over`, `never done`, `slower`, `wrong belief` or `rare failure`.
    shows: str
    library: str
    file: str
    #: The text that stands once in the file, and the text in its place.
    sound: str
    faulty: str
    agenda: str = ""
    tasks: tuple[str, ...] = ()
    seed: int = 1
    until: float = 5000
    #: The time by which a sound robot has succeeded and a faulty one has not.
    by: float = 0
    options: Mapping[str, Atom | bool] = {}

    def plant(self, folder: Path) -> str:
        """Write the faulty library to a folder; return the place of the fault."""
        shutil.copytree(LIBRARIES[self.library], folder, dirs_exist_ok=True)
        file = folder / self.file
        text = file.read_text(encoding="utf-8")
        assert text.count(self.sound) == 1, self.name
        file.write_text(text.replace(self.sound, self.faulty), encoding="utf-8")
        pairs = zip(self.sound, self.faulty, strict=False)
        differs = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))
        differs = min(differs, len(self.sound) - 1)
        row = text[: text.index(self.sound) + differs].count("\n") + 1
        return f"{self.file}:{row}"

    def run(self, library: Path) -> rapc.RunResult:
        """Run a sound or faulty library."""
        return rapc.run(
            rapc.load(library),
            WORLDS.get(self.library, self.library),
            self.tasks,
            agenda=self.agenda or None,
            seed=self.seed,
            until=self.until,
            options=dict(self.options),
        )


def told(result: rapc.RunResult) -> Iterator[str]:
    figures = {n: readable(v) for n, v in result.run.figures().items()}
    yield f"  {result.reason} at {readable(result.time)} {figures}"
    for task in result.tasks:
        if task.outcome != "succeeded" and not task.background:
            yield f"    {task.goal} {task.outcome} {format_atom(task.result or '')}"


FAULTS: tuple[Fault, ...] = (
    Fault(
        "way-home-forgotten",
        "over",
        "courier",
        "moving.rap",
        "(+ (way ?here ?room) (way ?room base) ?spare)",
        "(+ (way ?here ?room) ?spare)",
        "shift",
        options={"calls": 60},
    ),
    Fault(
        "late-to-the-charger",
        "over",
        "hallway",
        "travel.rap",
        "(:watch-battery 40)",
        "(:watch-battery 4)",
        "sightseeing",
        options={"usage": 8},
    ),
    Fault(
        "fuel-too-late",
        "over",
        "truck",
        "fuel.rap",
        "(< ?level 10)\n                      (bay-capacity",
        "(< ?level 0)\n                      (bay-capacity",
        "nine-orders",
    ),
    Fault(
        "acknowledged-too-early",
        "never done",
        "laboratory",
        "alarms.rap",
        "(stop released)",
        "(stop pressed)",
        "shift",
    ),
    Fault(
        "rocks-not-counted",
        "never done",
        "truck",
        "orders.rap",
        "          (set-sub ?loaded ?rock)\n          (counter-sub ?wanted 1))))",
        "          (set-sub ?loaded ?rock))))",
        "nine-orders",
    ),
    Fault(
        "nurse-of-another-ward",
        "never done",
        "courier",
        "orders.rap",
        "(wait-for (:nurse ?ward) :proceed)",
        "(wait-for (:nurse ward-1) :proceed)",
        "shift",
    ),
    Fault(
        "calibrated-again-and-again",
        "slower",
        "laboratory",
        "measuring.rap",
        "(believe (standard-value ?value) 80)",
        "(believe (standard-value ?value) 25)",
        "shift",
        by=650,
    ),
    Fault(
        "slow-on-the-road",
        "slower",
        "truck",
        "travel.rap",
        "(truck-speed-p medium)",
        "(truck-speed-p slow)",
        "nine-orders",
        by=4200,
        until=9000,
    ),
    Fault(
        "waits-long-for-the-door",
        "slower",
        "courier",
        "moving.rap",
        "(t1 (halt-for 10) (counter-add ?pauses 1))",
        "(t1 (halt-for 100) (counter-add ?pauses 1))",
        "shift",
        by=900,
        options={"blocked": 40},
    ),
    Fault(
        "closed-door-taken-as-passed",
        "wrong belief",
        "hallway",
        "moving.rap",
        "((not (current-space robot ?beyond)) (mem-add (found-closed ?mark)))))\n"
        "    ((:stuck)",
        "((not (current-space robot ?beyond))\n"
        "        (mem-add (current-space robot ?beyond)))))\n    ((:stuck)",
        "sightseeing",
        by=800,
    ),
    Fault(
        "slip-taken-as-grip",
        "wrong belief",
        "laboratory",
        "arms.rap",
        "    (primitive (grip ?arm ?sample))))\n",
        "    (primitive (grip ?arm ?sample))))\n\n"
        "(define-memory-rule (pick-up ?arm ?sample) :finish\n"
        "  (match-result (? (rule (true (mem-add (sample-at ?sample ?arm)))))))\n",
        "shift",
    ),
    Fault(
        "delivered-when-nobody-was-there",
        "wrong belief",
        "courier",
        "orders.rap",
        "    (primitive (hand-over ?goods ?ward))))",
        "    (primitive (hand-over ?goods ?ward))))\n\n"
        "(define-memory-rule (have-taken-off ?goods ?ward) :finish\n"
        "  (match-result (? (rule (true (mem-add (delivered ?goods ?ward)))))))",
        "shift",
        seed=3,
        options={"absent": 70},
    ),
    Fault(
        "too-few-rounds",
        "rare failure",
        "laboratory",
        "samples.rap",
        "(< (value ?rounds) 20)",
        "(< (value ?rounds) 6)",
        "shift",
        seed=10,
    ),
    Fault(
        "strong-arm-too-seldom",
        "rare failure",
        "truck",
        "grasping.rap",
        "                  (or (too-small-for arm1 ?thing)\n"
        "                      (method-tried steady))))",
        "                  (too-small-for arm1 ?thing)))",
        "nine-orders",
    ),
    Fault(
        "one-round-alone",
        "rare failure",
        "courier",
        "orders.rap",
        "(< (value ?rounds) 20)",
        "(< (value ?rounds) 2)",
        "shift",
        seed=4,
    ),
    # The five of the first trial.
    Fault(
        "charges-too-late",
        "over",
        "courier",
        "charging.rap",
        "(< ?level 48)",
        "(< ?level 18)",
        "shift",
    ),
    Fault(
        "drives-off-while-loading",
        "never done",
        "courier",
        "orders.rap",
        "                  (not (last-result tray-full))))\n    (claims wheels)\n",
        "                  (not (last-result tray-full))))\n",
        "shift",
    ),
    Fault(
        "never-fully-charged",
        "slower",
        "courier",
        "charging.rap",
        "(>= ?level 90)",
        "(> ?level 100)",
        "shift",
        by=900,
    ),
    Fault(
        "heading-not-turned",
        "wrong belief",
        "hallway",
        "travel.rap",
        "                    (+ ?heading 3.14159))))",
        "                    ?heading)))",
        "errand",
        by=200,
    ),
    Fault(
        "sold-out-for-ever",
        "rare failure",
        "courier",
        "orders.rap",
        "(not (believe (sold-out ?store ?goods) 60))",
        "(not (sold-out ?store ?goods))",
        "shift",
        seed=4,
    ),
)


def main(folder: Path, names: list[str]) -> None:
    """Plant the faults below a folder, and print how the runs end."""
    sys.path.insert(0, str(LIBRARIES["laboratory"]))
    for fault in FAULTS:
        if not names or fault.name in names:
            place = fault.plant(folder / fault.name)
            print(f"{fault.name} ({fault.shows}) at {fault.library}/{place}")
            sound, faulty = (
                fault.run(LIBRARIES[fault.library]),
                fault.run(folder / fault.name),
            )
            print("\n".join([" sound", *told(sound), " faulty", *told(faulty)]))


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
