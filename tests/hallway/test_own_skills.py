"""Skills that a subclass adds to the hallway robot, or puts in place of others."""

from __future__ import annotations

from random import Random

import pytest

from rapc.errors import PortError
from rapc.worlds.hallway import HallwayWorld
from rapc.worlds.hallway.channels import DRIVE, OBSTACLES, SONAR, Drive
from rapc.worlds.skills.declarations import Ports, Skill


class Spin(Skill):
    """Turn around on the spot."""

    name = "spin"
    outputs = (DRIVE,)
    uses = ("wheels",)

    def step(self, now: float, ports: Ports) -> None:
        ports[DRIVE] = Drive(0.0, 1.0)


class Blind(Skill):
    """Detect no obstacles."""

    name = "detect-obstacles"
    inputs = (SONAR,)
    outputs = (OBSTACLES,)

    def step(self, now: float, ports: Ports) -> None:
        ports[OBSTACLES] = (4.0,) * len(ports[SONAR])


class Robot(HallwayWorld):
    """The robot with both."""

    skills = (Spin, Blind)


def test_a_skill_of_a_subclass_is_offered_and_drives() -> None:
    assert Robot.kit.offer.skills[":spin"] == 0
    assert ":spin" not in HallwayWorld.kit.offer.skills
    world = Robot(Random(0), {})
    assert world.activate(1, [(":spin",)], []) is None
    world.advance(2)
    turned = (
        world.simulation.state.robot.heading
        - HallwayWorld(Random(0), {}).simulation.state.robot.heading
    )
    assert turned != 0
    assert world.activate(2, [(":turn-to", 1)], []) is not None


@pytest.mark.parametrize("sonar", ["ideal", "slant-30"])
@pytest.mark.parametrize(("kind", "collides"), [(Robot, True), (HallwayWorld, False)])
def test_a_skill_of_a_subclass_replaces_the_part_of_a_compound(
    kind: type[HallwayWorld], collides: bool, sonar: str
) -> None:
    world = kind(Random(0), {"people": 0, "sonar": sonar})
    world.activate(1, [(":move-in-direction", 0, 20, 0.5)], [":stuck"])
    world.advance(40)
    assert (world.figures().fastest > 0.3) == collides


def test_a_subclass_can_be_saved_and_restored() -> None:
    world, other = Robot(Random(0), {}), Robot(Random(1), {})
    world.activate(1, [(":spin",)], [])
    world.advance(1)
    other.restore(world.save())
    assert other.save() == world.save()


def test_an_error_in_a_skill_of_a_subclass_names_its_line() -> None:
    class Broken(Spin):
        def step(self, now: float, ports: Ports) -> None:
            ports[DRIVE] = ports[SONAR]

    class Other(HallwayWorld):
        skills = (Broken,)

    world = Other(Random(0), {})
    world.activate(1, [(":spin",)], [])
    said = r"the world `hallway` failed at test_own_skills.py:\d+: SkillError: `spin`"
    with pytest.raises(PortError, match=said):
        world.advance(1)
