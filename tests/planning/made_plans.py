"""Runs with plans, printed as JSON traces: `python -m tests.planning.made_plans`."""

from __future__ import annotations

import sys

import rapc
from bench.plans import CASES

ENDS = {"courier": 2000, "shuffled": 600, "hallway": 120}
"""The cases with the time at which their runs end; each has a plan or more."""


def main() -> None:
    """Print the traces."""
    for name, until in ENDS.items():
        case = CASES[name]
        library = rapc.load(case.library).extend(case.text)
        run = library.start(
            case.world,
            agenda=case.agenda,
            tasks=(*case.tasks, f"({case.goal}) :priority 2"),
            facts=case.facts,
            seed=3,
            options=case.options,
            listeners=[rapc.JsonTrace(sys.stdout)],
        )
        run.run(until=until)


if __name__ == "__main__":
    main()
