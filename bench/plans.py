"""Goals that no RAP has: how many runs achieve them, and what the plans cost.

python -m bench.plans                        all cases with 20 seeds each
python -m bench.plans courier --seeds 200    one case
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import rapc
from rapc import events

ROUND = """(define-rap (evening-round)
  (succeed (and (delivered medicine ward-3) (delivered meals ward-4)
                (not (call ward-2)) (docked)))
  (plan))"""

ROCKS = """(define-rap (rocks-about)
  (succeed (and (location ?red warehouse) (color ?red red)
                (location ?blue warehouse) (color ?blue blue)
                (location ?yellow ?factory) (color ?yellow yellow)
                (place ?factory factory) (truck-location depot)))
  (plan get-rock leave-at stop-at))"""

WALK = """(define-query (no-luck) (and (last-result ?result) (n= ?result okay)))
(define-rap (evening-walk)
  (resources (counter ?waits))
  (succeed (and (visited coffee-machine) (visited armchair) (visited blackboard)
                (current-space robot lab)))
  (repeat-while (< (value ?waits) 30))
  (method wait
    (context (no-luck))
    (task-net (t1 (pause 65) (counter-add ?waits 1))))
  (plan))"""

BENCH = """(define-rap (clear-the-way)
  (succeed (and (sample-at s1 bench) (sample-at s2 bench) (sample-at s3 instrument)))
  (plan))"""


class Case(NamedTuple):
    """A library with a goal, the world, and the tasks beside the goal."""

    library: str
    world: str
    text: str
    goal: str
    agenda: str | None
    tasks: tuple[str, ...]
    until: int
    options: Mapping[str, rapc.world.Atom | bool] = {}
    facts: tuple[str, ...] = ()


CHARGED = ("(stay-charged) :priority 4 :background true",)
TRUCK = (
    "(watch-fuel) :priority 4 :background true",
    "(watch-surroundings) :priority 8 :background true",
    "(handle-enemy-troops) :priority 6 :background true",
)
LABORATORY = (
    "(answer-smoke) :priority 9 :background true",
    "(answer-stop) :priority 8 :background true",
    "(answer-door) :priority 7 :background true",
    "(answer-spills) :priority 5 :background true",
)
MOVED = {"shuffle-efficiency": 40, "shuffle-interval": 15}

CASES = {
    "courier": Case(
        "examples/courier",
        "courier",
        ROUND,
        "evening-round",
        None,
        CHARGED,
        4000,
        facts=("(call ward-2)",),
    ),
    "truck": Case(
        "stdlib/truck-beyond", "truck", ROCKS, "rocks-about", None, TRUCK, 8000
    ),
    "shuffled": Case(
        "stdlib/truck-beyond", "truck", ROCKS, "rocks-about", None, TRUCK, 16000, MOVED
    ),
    "hallway": Case(
        "stdlib/hallway", "hallway", WALK, "evening-walk", "standing-by", (), 4000
    ),
    "laboratory": Case(
        "examples/laboratory",
        "laboratory:LaboratoryWorld",
        BENCH,
        "clear-the-way",
        None,
        LABORATORY,
        1500,
    ),
}


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", default=list(CASES))
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=70_000, help="the first seed")
    given = parser.parse_args()
    for name in given.cases:
        seeds = range(given.first, given.first + given.seeds)
        print(measured(name, CASES[name], seeds), flush=True)


def measured(name: str, case: Case, seeds: Iterable[int]) -> str:
    """Return a line about the runs of a case."""
    library = rapc.load(case.library).extend(case.text)
    tasks = (*case.tasks, f"({case.goal}) :priority 2")
    succeeded, times, plans, failed = 0, list[float](), list[int](), list[int]()
    began = time.process_time()
    for seed in seeds:
        made: list[events.Event] = []
        run = library.start(
            case.world,
            agenda=case.agenda,
            tasks=tasks,
            facts=case.facts,
            seed=seed,
            options=case.options,
        )
        run.listen(made.append, events.PlanMade)
        run.run(until=case.until)
        result = next(one for one in run.results() if one.goal.name == case.goal)
        plans.append(len(made))
        if result.outcome == "succeeded":
            succeeded += 1
            times.append(float(result.ended or 0))
        else:
            failed.append(seed)
    used = time.process_time() - began
    mean = statistics.fmean(times) if times else 0
    said = f", not: {failed}" if failed else ""
    return (
        f"{name}: {succeeded} of {len(plans)} in {mean:.0f} time units, "
        f"{statistics.fmean(plans):.2f} plans a run, {used:.1f} s CPU{said}"
    )


if __name__ == "__main__":
    main()
