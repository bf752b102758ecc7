"""The networks of skills in docs/research/hallway.md are those of the paper."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from rapc.worlds.hallway.map_text import named_map
from tests.cli.command import rapc

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "research" / "hallway.md").read_text(encoding="utf-8")
SVG = "{http://www.w3.org/2000/svg}"

NETWORKS = {
    "(pass 0)": ("track-door-jambs", {"movement-complete", "door-closed"}),
    "(follow-hall-to-end)": ("track-hallway", {"end-o-hall", "hall-blocked"}),
}
"""What tells the networks of figures 4 and 5 apart: a skill and its events."""


@pytest.mark.parametrize("task", NETWORKS)
def test_network_of_a_task_has_the_parts_of_its_figure(task: str) -> None:
    run = ("--skills", "0.1", "--world", "hallway", "--task", task)
    network = json.loads(rapc("graph", "rapc:hallway", *run, "--format", "json").stdout)
    kinds: dict[str, set[str]] = {}
    for box in network["vertices"]:
        kinds.setdefault(box["kind"], set()).add(box["label"].split()[0])
    skill, events = NETWORKS[task]
    assert kinds == {
        "sensor": {"sonar", "pose"},
        "skill": {"detect-obstacles", skill, "follow-trajectory"},
        "event": {*events, "stuck"},
        "actuator": {"drive"},
    }


def test_figure_3_is_what_its_code_prints(capsys: pytest.CaptureFixture[str]) -> None:
    found = re.findall(
        r"^```python\n(.*?)^```\n\n```text\n(.*?)^```", PAGE, re.M | re.S
    )
    [(code, drawn)] = found
    exec(compile(code, "hallway.md", "exec"), {})  # noqa: S102  # a page of ours
    assert capsys.readouterr().out.strip() == drawn.strip()
    assert "[[" not in drawn  # no events


def test_the_building_is_drawn_with_all_its_spaces() -> None:
    drawn = ElementTree.parse(DOCS / "figures" / "s-figure1.svg")  # noqa: S314
    names = {space.name for space in named_map("default").space}
    assert names <= {text.text for text in drawn.iter(f"{SVG}text")}
