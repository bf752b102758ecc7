"""Mounting the weapon: a tool, an arm too small, and a tool that changes hands.

The situation of T 6.2.1, trace 1, in the simulator; as a script it stands beside the
library.
"""

from __future__ import annotations

from .runs import STDLIB, Run, library, task

WEAPON = STDLIB / "truck" / "weapon.rap"


def test_the_weapon_is_mounted_whatever_the_seed() -> None:
    for seed in range(40):
        run = Run(task("ready-weapon"), seed=seed, compiled=library(WEAPON))
        assert run.outcomes == ["succeeded"], f"seed {seed}"
        assert run.places["gun-1"] == "weapon-bay"
        assert run.faults == []


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
