"""Solve a problem with an engine of unified-planning, in a process of its own.

`python up_engine.py ENGINE DOMAIN PROBLEM PLAN` reads two files of PDDL and writes the
plan to the third file. The module imports nothing of rapc.
"""

from __future__ import annotations

import sys
from pathlib import Path


def main(name: str, domain: str, problem: str, plan: str) -> None:
    """Write a plan to a file; without a plan the process ends with an error."""
    from unified_planning.exceptions import (  # noqa: PLC0415  # an extra
        UPNoRequestedEngineAvailableException,
    )
    from unified_planning.io import PDDLReader  # noqa: PLC0415  # an extra
    from unified_planning.shortcuts import (  # noqa: PLC0415
        OneshotPlanner,
        get_environment,
    )

    get_environment().credits_stream = None
    try:
        chosen = OneshotPlanner(name=name)
    except UPNoRequestedEngineAvailableException:
        missing = "or the package of the engine is missing"
        sys.exit(f"unified-planning has no engine `{name}`, {missing}")
    with chosen as planner:
        found = planner.solve(PDDLReader().parse_problem(domain, problem))
    if found.plan is None:
        sys.exit(f"no plan: {found.status.name}")
    lines = [f"({step.action.name})\n" for step in found.plan.actions]
    Path(plan).write_text("".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
