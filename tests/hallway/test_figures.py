"""The networks in docs/reference/hallway.md are those of the commands beside them.

python -m tests.hallway.test_figures    draws them anew; needs Graphviz
"""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from rapc.worlds.hallway.map_text import named_map
from tests.cli.command import rapc

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGE = (DOCS / "reference" / "hallway.md").read_text(encoding="utf-8")
SVG = "{http://www.w3.org/2000/svg}"

FIGURES: dict[str, list[str]] = {
    name: shlex.split(command)
    for command, name in re.findall(
        r"^rapc (graph .*?) \| dot -Tsvg\n```\n\n"
        r"!\[.*?\]\(\.\./(figures/s-figure\d.svg)\)",
        PAGE,
        re.M,
    )
}
"""The arguments by which each figure is made, by its file."""


[LIBRARY] = re.findall(r"^```rap\n(.*?)^```", PAGE, re.M | re.S)
"""The file `robot.rap` of the page."""


def _printed(folder: Path, name: str, form: str = "dot") -> str:
    """Return what the command of a figure prints in a folder of its own."""
    (folder / "robot.rap").write_text(LIBRARY, encoding="utf-8")
    done = rapc(*FIGURES[name], "--format", form, cwd=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


def _texts(group: ElementTree.Element) -> list[str]:
    return [text.text or "" for text in group.iter(f"{SVG}text")]


SKILLS = {
    "figures/s-figure4.svg": ("track-door-jambs", {"movement-complete", "door-closed"}),
    "figures/s-figure5.svg": ("track-hallway", {"end-o-hall", "hall-blocked"}),
}
"""What tells the networks of the paper apart: a skill and its events."""


@pytest.mark.parametrize("name", SKILLS)
def test_a_figure_is_what_its_command_prints(name: str, tmp_path: Path) -> None:
    network: dict[str, Any] = json.loads(_printed(tmp_path, name, "json"))
    drawn = ElementTree.parse(DOCS / name)  # noqa: S314  # a file of ours
    nodes: dict[str, str] = {}
    edges: Counter[tuple[str, str]] = Counter()
    for group in drawn.iter(f"{SVG}g"):
        title, told = group.findtext(f"{SVG}title") or "", _texts(group)
        if group.get("class") == "node":
            nodes[title] = " ".join(told)
        elif group.get("class") == "edge":
            edges[title, " ".join(told)] += 1
    assert nodes == {box["id"]: box["label"] for box in network["vertices"]}
    assert edges == Counter(
        (f"{edge['source']}->{edge['target']}", edge["label"])
        for edge in network["edges"]
    )
    kinds: dict[str, set[str]] = {}
    for box in network["vertices"]:
        kinds.setdefault(box["kind"], set()).add(box["label"].split()[0])
    skill, events = SKILLS[name]
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


def test_the_page_has_just_these_figures() -> None:
    assert set(FIGURES) == set(SKILLS)


def test_the_building_is_drawn_with_all_its_spaces() -> None:
    drawn = ElementTree.parse(DOCS / "figures" / "s-figure1.svg")  # noqa: S314
    names = {space.name for space in named_map("default").space}
    assert names <= set(_texts(drawn.getroot()))


def main() -> None:
    """Draw the figures anew."""
    for name in FIGURES:
        with tempfile.TemporaryDirectory() as folder:
            printed = _printed(Path(folder), name)
        done = subprocess.run(
            ["dot", "-Tsvg"],
            input=printed,
            text=True,
            capture_output=True,
            check=True,
        )
        lines = re.sub(r"<!--.*?-->\n*", "", done.stdout, flags=re.S)
        (DOCS / name).write_text(lines, encoding="utf-8")


if __name__ == "__main__":
    main()
