"""A tour, an order that comes in the midst of it, and the battery, all at once.

    python -m tests.hallway.duties --seeds 100

Each seed draws which landmark the order is for, when it comes, and whether it is more
urgent than the tour. The battery goes down at several times the usual pace, so that the
robot has to charge more than once.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from random import Random

import msgspec

from rapc import events
from rapc.base.values import Number
from rapc.runtime.events.report import cause_lines
from rapc.worlds.hallway.map_text import named_map
from tests.claims import Claims, claimants_of, users_of
from tests.hallway.sent import begin, library
from tests.hallway.strays import Stray, Strays

USAGE = 4
"""How fast the battery is used up."""

LONG = 10_000
"""Duties that are not done by then, in seconds, never will be."""


class Duties(msgspec.Struct):
    """What came of them."""

    #: What the order was, as a task.
    order: str
    #: Why the run was over, and when.
    reason: str
    time: Number
    #: What became of the tour and of the order, and why.
    outcomes: Sequence[str]
    causes: Sequence[str]
    #: Landmarks whose names were spoken.
    spoken: int
    charged: int
    fastest: Number
    strays: Sequence[Stray]
    claims: Claims
    #: Tasks that were suspended and still blocked when the run was over.
    not_resumed: int

    @property
    def done(self) -> bool:
        """Whether tour and order were carried out, and the body was in good hands."""
        return (
            self.reason == "done"
            and all(outcome == "succeeded" for outcome in self.outcomes)
            and self.claims.moved == self.claims.crossed == self.not_resumed == 0
            and self.fastest <= 0.1
        )


def attend(seed: int) -> Duties:
    """Let the robot attend to everything at once under a seed."""
    rng = Random(f"duties {seed}")
    goal = rng.choice(named_map("default").landmark).name
    at, priority = rng.randrange(60, 900), rng.choice((0, 4))
    order = f"(go-to {goal}) :at {at} :priority {priority}"
    declared = library().program.library
    claims = Claims(claimants_of(declared, "wheels"), users_of(declared, "wheels"))
    options = {"usage": USAGE}
    run, world = begin(
        seed, order, agenda="sightseeing", options=options, listeners=[claims]
    )
    strays, blocked, charged = Strays(run, world), list[int](), list[str]()
    run.call_at_end(lambda: blocked.append(len(claims.suspended)))
    run.listen(
        lambda event: charged.extend(
            [event.goal.name]
            if isinstance(event, events.TaskSucceeded) and event.goal.name == "charge"
            else []
        ),
        events.TaskSucceeded,
    )
    reason = run.run(until=LONG)
    given = [task for task in run.results() if not task.background]
    causes = [line for task in given for line in cause_lines(task.because)]
    return Duties(
        order,
        reason,
        run.now,
        [task.outcome for task in given],
        causes,
        len(world.simulation.state.said),
        len(charged),
        world.figures().fastest,
        strays.found,
        claims,
        blocked[0],
    )


def told(seed: int, duties: Duties) -> Iterator[str]:
    """Yield what there is to say of a seed: nothing if all went well."""
    if duties.done and not duties.strays:
        return
    yield (
        f"seed {seed}, {duties.order}: {duties.reason} at {duties.time:.0f} s, "
        f"{', '.join(duties.outcomes)}; {duties.spoken} landmarks, "
        f"charged {duties.charged} times, moved {duties.claims.moved}, "
        f"crossed {duties.claims.crossed}, not resumed {duties.not_resumed}, "
        f"fastest {duties.fastest} m/s"
    )
    yield from (f"    {line}" for line in [*duties.strays, *duties.causes])


def sums(every: Mapping[int, Duties]) -> Iterator[str]:
    """Yield what all seeds come to."""
    all_of = list(every.values())
    yield f"{sum(d.done for d in all_of)} of {len(all_of)} done"
    yield f"{sum(d.claims.moved for d in all_of)} times moved from under a claim"
    yield f"{sum(d.claims.crossed for d in all_of)} times skills of two tasks on"
    yield f"{sum(d.claims.overruled for d in all_of)} uses by a task of higher priority"
    yield f"{sum(d.claims.times_suspended for d in all_of)} methods suspended"
    yield f"{sum(d.not_resumed for d in all_of)} not resumed"
    yield f"{sum(d.charged for d in all_of)} times charged"
    strayed = sum(bool(d.strays) for d in all_of)
    yield f"{strayed} seeds with a wrong belief about the space on the way"
    yield f"fastest collision {max(d.fastest for d in all_of)} m/s"


def main() -> None:
    """Attend under many seeds, and print what came of it."""
    parser = argparse.ArgumentParser(description="A tour, an order and the battery.")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first-seed", type=int, default=0)
    given = parser.parse_args()
    every = {}
    for seed in range(given.first_seed, given.first_seed + given.seeds):
        every[seed] = attend(seed)
        for line in told(seed, every[seed]):
            print(line, flush=True)
    print("\n".join(sums(every)))


if __name__ == "__main__":
    main()
