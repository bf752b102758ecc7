"""docs/tutorials/skills.md leads to a library that does what the page says."""

from __future__ import annotations

import re
from pathlib import Path

import rapc
from rapc.worlds.hallway import HallwayWorld
from rapc.worlds.registry import build_world

PAGE = Path(__file__).parents[2] / "docs" / "tutorials" / "skills.md"


def test_the_watchman_looks_around_where_he_was_sent() -> None:
    page = PAGE.read_text(encoding="utf-8")
    text = "\n".join(re.findall(r"```rap\n(.*?)```", page, re.DOTALL))
    world = build_world(HallwayWorld, 0, {"doors": 0})
    agenda, task = "standing-by", "(check-on desk) :at 1"
    result = rapc.run(rapc.loads(text), world, task, agenda=agenda, until=600)
    assert result.succeeded
    assert result.run.memory.query("looked-around-at", None) == [
        ("looked-around-at", "desk")
    ]
    assert isinstance(world, HallwayWorld)
    assert world.figures().space == "office"
