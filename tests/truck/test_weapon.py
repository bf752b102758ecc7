"""Mounting the weapon: a tool, an arm too small, and a tool that changes hands.

The situation of T 6.2.1, trace 1, in the simulator; as a script it stands beside the
library.
"""

from __future__ import annotations

import pytest

from rapc.base.values import Number

from .runs import PLENTY, STDLIB, Run, library, task

WEAPON = STDLIB / "truck" / "weapon.rap"


def rounds(run: Run) -> Number:
    """How many rounds the world has in the gun, if it is mounted."""
    gun = run.world.state.items["gun-1"]
    return gun.amount if gun.place == "weapon-bay" else 0


def test_an_empty_weapon_is_loaded_whatever_the_seed() -> None:
    for seed in range(20):
        options = {"gun-rounds": 0}
        run = Run(
            task("ready-weapon"), seed=seed, options=options, compiled=library(WEAPON)
        )
        assert run.outcomes == ["succeeded"], f"seed {seed}"
        assert rounds(run) == 15
        assert run.faults == []


@pytest.mark.slow
def test_a_search_ends_wherever_gun_and_tool_have_gone() -> None:
    options = {**PLENTY, "shuffle-interval": 30, "shuffle-tools": True}
    outcomes: set[str] = set()
    for seed in range(12):
        run = Run(
            task("ready-weapon"), seed=seed, options=options, compiled=library(WEAPON)
        )
        outcomes.update(run.outcomes)
        assert (run.outcomes == ["succeeded"]) == (rounds(run) > 0), f"seed {seed}"
        assert run.faults == []
    assert outcomes == {"succeeded", "failed"}


def test_the_tool_changes_hands_by_way_of_bay1() -> None:
    steady = {"arm1-drops": 0, "arm2-drops": 0}
    run = Run(task("mount-weapon"), options=steady, compiled=library(WEAPON))
    arms = [request for request in run.requests if request.startswith("(arm")]
    assert arms == [
        "(arm-move arm1 external)",
        "(arm-move arm1 gun-tool-1)",
        "(arm-grasp arm1 gun-tool-1)",
        "(arm-move arm1 gun-1)",
        "(arm-grasp arm1 gun-1)",
        "(arm-grasp arm1 gun-1)",
        "(arm-move arm1 bay1)",
        "(arm-ungrasp arm1 gun-tool-1)",
        "(arm-move arm2 bay1)",
        "(arm-move arm2 gun-tool-1)",
        "(arm-grasp arm2 gun-tool-1)",
        "(arm-move arm1 folded)",
        "(arm-grasp arm2 gun-tool-1)",
        "(arm-move arm2 external)",
        "(arm-move arm2 gun-1)",
        "(arm-grasp arm2 gun-1)",
        "(arm-move arm2 weapon-bay)",
        "(arm-ungrasp arm2 gun-1)",
    ]
    assert run.answers["arm-grasp", "arm-too-full"] == 2
    assert run.answers["arm-grasp", "arm-interference"] == 1
