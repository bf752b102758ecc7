"""What a failure that never ends costs, by T's rule and by two others.

    python -m bench.waste                 # arms that drop whatever they grasp
    python -m bench.waste --curves 10     # points of chapter 6, ten seeds each

By T's rule a task makes the same choice twice and then fails, and its parent may make
its own choice again (T 3.2.5): where a primitive always fails, each level above doubles
the requests. Two other rules are tried here. They are put into the interpreter of this
process alone; no run of rapc has them:

- `cause`: that a task was caught in a futile loop is handed up. The choice of its
  parent that led there is not made a second time.
- `family`: what asks the world for something, and has failed four times with the same
  goal for one top-level task without a success between, fails at once from then on.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from statistics import mean
from unittest.mock import patch

import msgspec

from bench.chapter6 import session
from rapc.events import Cause
from rapc.experiments.measures import Measures
from rapc.experiments.run import PointConfig, measure
from rapc.language.results import FUTILE_LOOP
from rapc.runtime.run import Run
from rapc.runtime.state.task import Env, Task
from rapc.runtime.tasks import cycle, finish, try_method

LIMIT = 4
"""How often what asks the world may fail with the same goal for a top-level task."""

CURVES = ((0, 0), (15, 40), (8, 40), (15, 80))
"""Intervals between shuffles, and their efficiency in per cent."""

RULES = ("T", "cause", "family")


@contextmanager
def rule(name: str) -> Iterator[None]:
    """Have this process go by one of `RULES` for a while."""
    with ExitStack() as patches:
        if name == "cause":
            for module in (cycle, try_method):
                patches.enter_context(patch.object(module, "fail", _hand_up))
        elif name == "family":
            family = _Family()
            for module in (cycle, try_method):
                patches.enter_context(patch.object(module, "fail", family.fail))
            patches.enter_context(patch.object(cycle, "succeed", family.succeed))
            patches.enter_context(patch.object(cycle, "try_method", family.try_method))
        yield


def _hand_up(run: Run, task: Task, reason: str, because: Cause | None = None) -> None:
    """Fail a task; after a futile loop its parent has made its choice for good."""
    parent = task.within.task if task.within is not None else None
    if parent is not None and reason == FUTILE_LOOP and parent.choice is not None:
        history = parent.history
        last = history.last_choice if history and history.choices else parent.choice
        parent.note_choice(last)
    finish.fail(run, task, reason, because)


class _Family:
    """The rule `family`: what failed how often, by top-level task and goal."""

    def __init__(self) -> None:
        self.failed: Counter[tuple[int, str]] = Counter()

    def fail(
        self, run: Run, task: Task, reason: str, because: Cause | None = None
    ) -> None:
        """Fail a task, and count that if it asks the world."""
        if _asks_world(task):
            self.failed[_key(task)] += 1
        finish.fail(run, task, reason, because)

    def succeed(self, run: Run, task: Task, found: Env) -> None:
        """End a task well: its failures are forgotten."""
        self.failed.pop(_key(task), None)
        finish.succeed(run, task, found)

    def try_method(self, run: Run, task: Task) -> None:
        """Try a method of a task, unless its like has failed too often."""
        if _asks_world(task) and self.failed[_key(task)] >= LIMIT:
            finish.fail(run, task, FUTILE_LOOP)
        else:
            try_method.try_method(run, task)


def _asks_world(task: Task) -> bool:
    return any(method.request is not None for method in task.plan.methods)


def _key(task: Task) -> tuple[int, str]:
    return task.family, str(task.goal())


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--curves", type=int, default=0, help="seeds a point")
    parser.add_argument("--first-seed", type=int, default=2000)
    given = parser.parse_args()
    for line in (
        curves(range(given.first_seed, given.first_seed + given.curves))
        if given.curves
        else hopeless()
    ):
        print(line, flush=True)


def hopeless() -> Iterator[str]:
    """One order, with arms that drop whatever they grasp."""
    yield "| rule | primitives | grasps | time | filled |"
    yield "| --- | ---: | ---: | ---: | ---: |"
    tasks = ["(fill-order red 1 factory-1) :priority 2"]
    config = _still(tasks, arm1_drops=100, arm2_drops=100)
    for name in RULES:
        with rule(name):
            found = measure(config, 0)
        yield _row(
            name,
            found.effector + found.sensor,
            found.failed,
            found.time,
            found.completed,
        )


def curves(seeds: range) -> Iterator[str]:
    """The basic experiment, still and shuffled."""
    yield "| interval, efficiency | rule | time each | filled | primitives | failed |"
    yield "| --- | --- | ---: | ---: | ---: | ---: |"
    for interval, efficiency in CURVES:
        config = _still(shuffle_interval=interval, shuffle_efficiency=efficiency)
        for name in RULES:
            with rule(name):
                runs = [measure(config, seed) for seed in seeds]
            ended = [run for run in runs if run.disaster is None]
            where = f"{interval}, {efficiency} %" if interval else "still"
            yield _of_runs(where, name, ended)


def _of_runs(where: str, name: str, runs: list[Measures]) -> str:
    filled = sum(run.completed for run in runs)
    return _row(
        where,
        name,
        sum(run.time for run in runs) / max(filled, 1),
        f"{filled / len(runs):.1f}",
        mean(run.effector + run.sensor for run in runs),
        mean(run.failed for run in runs),
    )


def _row(*cells: object) -> str:
    told = [f"{cell:.0f}" if isinstance(cell, int | float) else cell for cell in cells]
    return f"| {' | '.join(map(str, told))} |"


def _still(tasks: Sequence[str] = (), **options: int) -> PointConfig:
    """The still part of chapter 6, with other options or tasks."""
    config = session().points[0].config
    changed = {name.replace("_", "-"): value for name, value in options.items()}
    spec = msgspec.structs.replace(
        config.spec,
        options={**config.spec.options, **changed},
        tasks=tuple(tasks) or config.spec.tasks,
    )
    return msgspec.structs.replace(config, spec=spec)


if __name__ == "__main__":
    main()
