"""Shifts of the courier under many seeds, with the claims of its library and without.

    python -m tests.courier.shifts --seeds 200
    python -m tests.courier.shifts --seeds 200 --without-claims

Two standing tasks and three orders want one body. What is counted is taken from the
trace, by the methods that claim the wheels, and from the world, which knows what was
true. With the claims taken out the methods are the same and hold nothing.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

import msgspec

import rapc
from rapc.world import Time
from rapc.worlds.courier import CourierWorld
from rapc.worlds.registry import build_world
from tests.claims import Claims, claimants_of, users_of

COURIER = Path(__file__).parents[2] / "examples" / "courier"

CLAIM = "    (claims wheels)\n"

LONG = 20_000
"""A shift that has not ended by then never will."""


STRICT = rapc.Settings(strict=True)


class Shift(msgspec.Struct):
    """What came of one shift."""

    reason: str
    time: Time
    delivered: int
    failed: int
    #: Drives while another task of no lower priority was to have the wheels.
    moved_from_under: int
    #: Drives that took the wheels from a claimant of lower priority.
    overruled: int
    suspended: int
    #: Suspended tasks that were still blocked when the shift was over.
    not_resumed: int
    #: How often the world saw somebody left standing.
    in_vain: int


@cache
def library(claims: bool) -> rapc.CheckedLibrary:
    """The library of the courier, or the same text without its claims."""
    if claims:
        return rapc.load(COURIER)
    files = [file for file in COURIER.glob("*.rap") if ".test." not in file.name]
    text = "".join(file.read_text(encoding="utf-8") for file in sorted(files))
    kept = [line for line in text.splitlines() if not line.startswith("(require")]
    return rapc.loads("\n".join(kept).replace(CLAIM, ""), "without-claims")


def work_a_shift(
    seed: int, claims: bool = True, options: Mapping[str, int] | None = None
) -> Shift:
    """Run the agenda `shift` under a seed, the handlers held to what is declared."""
    world = build_world(CourierWorld, seed, options or {})
    declared = library(True).program.library
    watch = Claims(claimants_of(declared, "wheels"), users_of(declared, "wheels"))
    blocked: list[set[int]] = []
    run = library(claims).start(
        world, agenda="shift", seed=seed, settings=STRICT, listeners=[watch]
    )
    run.call_at_end(lambda: blocked.append(set(watch.suspended)))
    reason = run.run(until=LONG)
    assert isinstance(world, CourierWorld)
    return Shift(
        reason,
        run.now,
        len(world.state.deliveries),
        sum(task.outcome == "failed" for task in run.results()),
        watch.moved,
        watch.overruled,
        watch.times_suspended,
        len(blocked[0]),
        world.state.in_vain,
    )


def report(shifts: Mapping[int, Shift]) -> Iterable[str]:
    """What came of shifts by their seeds, line by line."""
    done = list(shifts.values())
    reasons = Counter(shift.reason for shift in done)
    yield f"{len(done)} shifts: " + ", ".join(f"{n} {r}" for r, n in reasons.items())
    for name in Shift.__struct_fields__[1:]:
        values = [getattr(shift, name) for shift in done]
        told = f"{name.replace('_', ' '):18} {sum(values) / len(values):8.2f}"
        yield f"{told}  from {min(values)} to {max(values)}"
    bad = [seed for seed, shift in shifts.items() if shift.reason != "done"]
    yield f"seeds not done: {str(bad[:10])[1:-1] or 'none'}{' ...' * (len(bad) > 10)}"


def main() -> None:
    """Work so many shifts and print what came of them."""
    parser = argparse.ArgumentParser(description="Shifts of the courier.")
    parser.add_argument("--from", type=int, default=0, dest="start")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--without-claims", action="store_true")
    given = parser.parse_args()
    claims = not given.without_claims
    seeds = range(given.start, given.start + given.seeds)
    shifts = {seed: work_a_shift(seed, claims) for seed in seeds}
    print("\n".join(report(shifts)))


if __name__ == "__main__":
    main()
