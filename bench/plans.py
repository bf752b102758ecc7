"""Goals that no RAP has: how many runs achieve them, and what the plans cost.

python -m bench.plans                        all cases with 20 seeds each
python -m bench.plans courier --seeds 200    one case
python -m bench.plans --search               the times of grounding and search
python -m bench.plans --deliveries           five deliveries: one plan beside orders
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import rapc
from rapc import events
from rapc.base.values import Fact, Number
from rapc.library.library import usable_in_plans
from rapc.library.operators import Model
from rapc.planning.ground import Grounding, Situation
from rapc.planning.solver import situation, solve
from rapc.worlds.registry import importing_from

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


TEN = """(define-rap (ten-marks)
  (succeed (and (visited desk) (visited shelves) (visited workbench) (visited stock)
                (visited coffee-machine) (visited blackboard) (visited mail-slots)
                (visited fountain) (visited armchair) (visited chest)
                (current-space robot lab)))
  (plan))"""

PLACES, PARCELS, TRUCKS = 12, 10, 3
LOGISTICS = f"""
(declare-kind place ({" ".join(f"l{at}" for at in range(PLACES))}))
(declare-kind parcel ({" ".join(f"p{at}" for at in range(PARCELS))}))
(declare-kind truck ({" ".join(f"t{at}" for at in range(TRUCKS))}))
(declare-memory-property place-of ((?truck truck) (?place place)) unknown)
(declare-memory-proposition lies ((?parcel parcel) (?place place)))
(declare-memory-proposition in ((?parcel parcel) (?truck truck)))
(define-rap (drive (?truck truck) (?to place))
  (preconditions (and (place-of ?truck ?from) (n= ?from ?to)))
  (effects (place-of ?truck ?to)))
(define-rap (load (?parcel parcel) (?truck truck))
  (preconditions (and (lies ?parcel ?place) (place-of ?truck ?place)))
  (effects (in ?parcel ?truck) (not (lies ?parcel ?))))
(define-rap (unload (?parcel parcel) (?truck truck) (?place place))
  (preconditions (and (in ?parcel ?truck) (place-of ?truck ?place)))
  (effects (lies ?parcel ?place) (not (in ?parcel ?truck))))
(define-rap (deliver-all)
  (succeed (and {" ".join(f"(lies p{n} l{n * 5 % PLACES})" for n in range(PARCELS))}))
  (plan))
"""


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


class Searched(NamedTuple):
    """A problem whose search is timed."""

    name: str
    library: rapc.CheckedLibrary
    goal: str
    #: The greatest processor time in milliseconds, on an idle machine.
    bar: int
    facts: Situation
    #: Whether only the grounding is timed.
    grounds: bool = False


def begun(name: str, text: str, goal: str) -> tuple[rapc.CheckedLibrary, Situation]:
    """Return a library with a goal, and the memory at the beginning of its case."""
    case = CASES[name]
    library = rapc.load(case.library).extend(text)
    run = library.start(
        case.world, agenda=case.agenda, facts=case.facts, tasks=case.tasks, seed=3
    )
    run.run(until=5)
    return library, situation(run.memory)


def searches() -> Iterator[Searched]:
    """Yield the problems."""
    for name, text, goal, bar in (
        ("courier", ROUND, "evening-round", 40),
        ("truck", ROCKS, "rocks-about", 40),
        ("hallway", TEN, "ten-marks", 120),
    ):
        library, facts = begun(name, text, goal)
        yield Searched(name, library, goal, bar, facts)
    library, facts = begun("truck", ROCKS, "rocks-about")
    places = [str(fact[1]) for fact in facts if fact[0] == "place"]
    seen: dict[Fact, Number | None] = dict(facts)
    for at in range(68):
        for fact in (
            ("class", f"rock-{at}", "rock"),
            ("color", f"rock-{at}", ("red", "blue", "yellow")[at % 3]),
            ("location", f"rock-{at}", places[at % len(places)]),
        ):
            seen[fact] = 1
    said = f"truck, {len(seen)} facts, grounding"
    yield Searched(said, library, "rocks-about", 100, seen, grounds=True)
    carried: dict[Fact, Number | None] = {}
    for at in range(PARCELS):
        carried["lies", f"p{at}", f"l{at % PLACES}"] = 1
    for at in range(TRUCKS):
        carried["place-of", f"t{at}", f"l{at}"] = 1
    library = rapc.loads(LOGISTICS, check=False)
    yield Searched("logistics", library, "deliver-all", 1000, carried)


def timed(one: Searched, times: int) -> str:
    """Return a line with the shortest of several times of a search."""
    program, spent = one.library.program, list[float]()
    rap = program.library.raps[one.goal]
    for _ in range(times):
        began = time.process_time()
        use = usable_in_plans(program.library.raps, rap)
        model = Model(program.library, program.signatures, use)
        goal = model.goal(rap, {})
        if one.grounds:
            problem = Grounding(model, one.facts, goal).problem()
            said = f"{len(problem.actions)} ground steps"
        else:
            found = solve(model, one.facts, goal, limit=20_000)
            steps = 0 if found.sketch is None else len(found.sketch.actions)
            said = f"{found.outcome}, {steps} steps, {found.expanded} states"
            if found.problem is not None:
                said += f", {len(found.problem.actions)} ground steps"
        spent.append(time.process_time() - began)
    return f"{one.name}: {min(spent) * 1000:.0f} ms of {one.bar} ({said})"


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", default=list(CASES))
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--first", type=int, default=70_000, help="the first seed")
    parser.add_argument("--search", action="store_true", help="time the searches")
    parser.add_argument(
        "--deliveries",
        action="store_true",
        help="compare one plan for five deliveries with five orders",
    )
    given = parser.parse_args()
    if given.search:
        for one in searches():
            print(timed(one, 5), flush=True)
        return
    seeds = range(given.first, given.first + given.seeds)
    if given.deliveries:
        print(compared(seeds))
        return
    for name in given.cases:
        with importing_from(Path(CASES[name].library)):
            print(measured(name, CASES[name], seeds), flush=True)


DELIVERIES = (
    "medicine ward-3",
    "meals ward-4",
    "linen ward-1",
    "medicine ward-2",
    "meals ward-1",
)
ALL_FIVE = f"""(define-rap (all-five)
  (succeed (and {" ".join(f"(delivered {one})" for one in DELIVERIES)}))
  (plan fetch bring))"""
NEVER = 6000
"""The end of a run of deliveries, in time units."""


def compared(seeds: Sequence[int]) -> str:
    """Return a line about five deliveries by one plan, beside five orders.

    The ratio is that of the mean times; its standard error is that of the paired
    differences.
    """
    library = rapc.load(CASES["courier"].library).extend(ALL_FIVE)
    orders = [f"(deliver {one}) :priority 2" for one in DELIVERIES]
    ends: list[list[float]] = []
    done = []
    for tasks in (["(all-five) :priority 2"], orders):
        ends.append([])
        done.append(0)
        for seed in seeds:
            run = library.start("courier", tasks=(*CHARGED, *tasks), seed=seed)
            run.run(until=NEVER)
            found = [one for one in run.results() if one.goal.name != "stay-charged"]
            done[-1] += all(one.outcome == "succeeded" for one in found)
            ends[-1].append(max(float(one.ended or NEVER) for one in found))
    planned, ordered = map(statistics.fmean, ends)
    ratio = planned / ordered
    apart = [one - ratio * other for one, other in zip(*ends, strict=True)]
    error = statistics.stdev(apart) / len(apart) ** 0.5 / ordered
    return (
        f"five deliveries: {planned:.0f} time units by a plan, "
        f"{ordered:.0f} by orders: "
        f"{ratio:.3f} +- {error:.3f}, all delivered in {done[0]} and {done[1]} of "
        f"{len(apart)} runs"
    )


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
