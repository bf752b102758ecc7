"""Many tests under many seeds, with faults and coverage, for a command."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import ClassVar

import msgspec
from msgspec.structs import replace

from rapc.base.names import plural
from rapc.base.values import format_list
from rapc.testing.coverage import Coverage
from rapc.testing.faults import told_for_skills
from rapc.testing.run import Case, Outcome, Status, run_case
from rapc.world import World
from rapc.worlds.faults import FaultyWorld, InjectedFault, problem


class TestSession(msgspec.Struct, frozen=True):
    """Options of a test session: each test runs under all seeds, with its faults."""

    #: Keeps pytest from collecting the class as a test.
    __test__: ClassVar[bool] = False

    seeds: range = range(1)
    faults: tuple[InjectedFault, ...] = ()
    coverage: Coverage | None = None
    #: The modules of which tests may name worlds, as `module:Class`.
    modules: tuple[str, ...] = ()
    #: Whether the declared effects of RAPs must come true in a simulator.
    effects: bool = False

    def run(self, cases: Iterable[Case]) -> Iterator[Outcome]:
        """Yield the outcome of each test: its first failure, or its last seed."""
        for case in cases:
            yield self.run_one(case)

    def run_one(self, case: Case) -> Outcome:
        """Run a test under all seeds, up to the first under which it fails."""
        faults = [fault for fault in self.faults if self._problem(fault, case) is None]

        def wrap(world: World, seed: int) -> World:
            return FaultyWorld(world, faults, seed) if faults else world

        own, state = case.test.seed, case.test.saved_state
        seeds = self.seeds if own is None else range(own, own + 1)
        checked: dict[str, None] = {}
        for seed in seeds if state is None else seeds[:1]:
            outcome = run_case(
                case,
                seed,
                wrap,
                self.coverage,
                modules=self.modules,
                effects=self.effects,
            )
            checked |= dict.fromkeys(outcome.checked)
            if outcome.status is not Status.PASSED:
                break
        return replace(outcome, checked=tuple(checked))

    def useless(self, cases: Sequence[Case]) -> Iterator[str]:
        """Return the faults that can occur in none of the tests, with the reason."""
        for fault in self.faults:
            reasons = [self._problem(fault, case) for case in cases]
            if reasons and None not in reasons:
                yield f"{format_list(fault.request)}: {reasons[0]}"

    def _problem(self, fault: InjectedFault, case: Case) -> str | None:
        told = told_for_skills(case.library.library)
        return problem(fault, case.library.signatures, told)


def summary(outcomes: Sequence[Outcome], seeds: int) -> str:
    """Return the last line: how many tests passed, failed, could not be run."""
    counts = Counter(outcome.status for outcome in outcomes)
    words = {
        Status.PASSED: "passed",
        Status.FAILED: "failed",
        Status.ERROR: "in error",
    }
    told = [f"{counts[status]} {words[status]}" for status in Status if counts[status]]
    tests = plural(len(outcomes), "test")
    under = f", each under {seeds} seeds" if seeds > 1 else ""
    return f"{tests}{under}: {', '.join(told)}"


def exit_status(outcomes: Sequence[Outcome]) -> int:
    """Return 0 if all passed, 2 if a test has an error, else 1."""
    found = {outcome.status for outcome in outcomes}
    if Status.ERROR in found:
        return 2
    return 1 if Status.FAILED in found else 0


def effects_summary(outcomes: Iterable[Outcome]) -> str:
    """Return a line that counts the RAPs with effects and names the unchecked ones."""
    raps: dict[str, bool] = {}
    for outcome in outcomes:
        for name, rap in outcome.case.library.library.raps.items():
            if rap.effects:
                raps[name] = raps.get(name, False) or name in outcome.checked
    missing = [f"`{name}`" for name, checked in raps.items() if not checked]
    told = f"effects: {len(raps) - len(missing)} of {plural(len(raps), 'RAP')} checked"
    return f"{told}; not: {', '.join(missing)}" if missing else told
