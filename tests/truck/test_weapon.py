"""Mounting the weapon: a tool, an arm too small, and a tool that changes hands.

The situation of T 6.2.1, trace 1, in the simulator instead of on paper.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from .runs import Run, library, task

MOUNT_WEAPON = """\
(require "truck")

(define-rap (mount-weapon => ?weapon)
  (succeed (and (location ?weapon weapon-bay)
                (class ?weapon weapon true)))
  (method
    (task-net
      (t1 (truck-travel-to warehouse)
          ((truck-location warehouse) for t2))
      (t2 (look-for-class weapon => ?thing)
          ((class ?thing weapon true) for t3))
      (t3 (move-thing-to ?thing weapon-bay)))))
"""


@pytest.fixture
def mount_weapon(tmp_path: Path) -> Path:
    """The library with one task more."""
    path = tmp_path / "mount-weapon.rap"
    path.write_text(MOUNT_WEAPON, encoding="utf-8")
    return path


def test_the_weapon_is_mounted_whatever_the_seed(mount_weapon: Path) -> None:
    compiled = library(mount_weapon)
    for seed in range(40):
        run = Run(task("mount-weapon"), seed=seed, compiled=compiled)
        assert run.outcomes == ["succeeded"], f"seed {seed}"
        assert run.places["gun-1"] == "weapon-bay"
        assert run.faults == []


def test_the_tool_changes_hands_by_way_of_bay1(mount_weapon: Path) -> None:
    steady = {"arm1-drops": 0, "arm2-drops": 0}
    compiled = library(mount_weapon)
    run = Run(task("mount-weapon"), options=steady, compiled=compiled)
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
