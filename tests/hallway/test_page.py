"""What docs/reference/hallway.md says is so."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rapc.worlds.hallway.channels import Pose
from rapc.worlds.hallway.map_text import named_map, read_map
from rapc.worlds.hallway.skills.all import SENSORS, catalogue
from rapc.worlds.skills.catalogue import Catalogue, SkillRequest
from rapc.worlds.skills.declarations import Skill
from rapc.worlds.skills.runtime import SkillRuntime

PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "hallway.md").read_text(
    encoding="utf-8"
)


def _block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1]


def test_the_table_lists_every_skill_with_its_parameters_and_events() -> None:
    made = catalogue()
    skills = PAGE.partition("\n## Options\n")[0]
    rows = re.findall(r"^\| `([a-z].*?)` \|.*\|(.*)\|$", skills, re.MULTILINE)
    listed: dict[str, tuple[list[str], dict[str, list[str]]]] = {}
    for skill, events in rows:
        name, *parameters = skill.split()
        told = re.findall(r"`([a-z].*?)`", events)
        listed[name] = (parameters, {event.split()[0]: event.split() for event in told})
    assert set(listed) == set(made.entries)
    for name, (wanted, by_event) in listed.items():
        known = made.describe(name)
        assert wanted == [p.name for p in known.parameters], name
        assert set(by_event) == set(known.events), name
        for event, words in by_event.items():
            if len(words) > 1:
                carries = [p.name for p in made.events[event].carries]
                assert words[1:] == carries, event


def test_the_map_of_the_page_is_one() -> None:
    made = read_map(_block("toml"))
    assert [space.name for space in made.space] == ["lab", "hall"]
    assert made.landmark[0].charger


def test_the_default_map_is_as_described() -> None:
    map = named_map("default")
    assert (len(map.space), len(map.person)) == (17, 6)
    assert sum(doorway.door for doorway in map.doorway) == 8
    assert sum(s.kind == "room" and s.floors == (1,) for s in map.space) == 9


def test_the_skill_of_the_page_runs() -> None:
    names: dict[str, object] = {}
    [code] = re.findall(r"```python\n((?:(?!```).)*?class Spin.*?)```", PAGE, re.DOTALL)
    exec(compile(code, "hallway.md", "exec"), names)  # noqa: S102
    spin = names["Spin"]
    assert isinstance(spin, type)
    assert issubclass(spin, Skill)
    runtime = SkillRuntime(Catalogue([spin], SENSORS))
    assert runtime.activate(1, [SkillRequest("spin", (0.5,))], []) is None
    runtime.tick(0.1, {"pose": lambda: Pose(0.0, 0.0, 0.0)})
    (out,) = spin.outputs
    value = runtime.value(out)
    assert getattr(value, "bearing", None) == pytest.approx(0.5)
