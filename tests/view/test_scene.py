"""Drawings of pictures: what they show, as SVG, and the same shapes in the page."""

from __future__ import annotations

import json
import shutil
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

import rapc
from rapc.base import pictures
from rapc.base.values import format_list
from rapc.events import Event, FactAsserted, FactErased
from rapc.view import scene
from rapc.view.scene import Beliefs, Scene, scene_of
from rapc.view.svg import svg
from rapc.world import Drawable
from tests.cli.command import rapc as command
from tests.debug.sessions import TRUCK
from tests.view.test_page import data_of

PAGE = Path(scene.__file__).with_name("page")

RUNS = (
    (TRUCK, "truck", "(rock-order red 1)"),
    ("rapc:hallway", "hallway", "(go-to coffee-machine)"),
    ("examples/courier", "courier", "(deliver meals ward-4)"),
)

MAP = {
    "here": "yard",
    "heading": "west",
    "look": "color",
    "roads": [["yard", "barn"]],
    "spots": [
        {"name": "yard", "at": [0, 0], "things": [{"kind": "rock", "look": "red"}]},
        {"name": "barn", "at": [2, 1], "things": [], "note": "dark"},
        {"name": "arm", "things": [{"kind": "rod"}], "note": "folded"},
    ],
    "gauges": [{"name": "fuel", "value": 2.5, "believed": ["fuel"]}],
    "said": "hello",
}
KNOWN = {
    "(location item-1 barn)": 1.0,
    "(class item-1 rock true)": 1.0,
    "(color item-1 red)": 1.0,
    "(location item-2 arm)": 1.0,
    "(class item-2 rod true)": 1.0,
    "(class item-2 thing true)": 1.0,
    "(fuel 3)": 2.0,
}


def drawn(picture: Any, facts: Mapping[str, float] = KNOWN, **more: Any) -> Scene:
    found = scene_of(picture, Beliefs(facts, 10), **more)
    assert found is not None
    return found


def texts(found: Scene) -> list[str]:
    return [text for tag, _, text in found.shapes if tag == "text"]


def hints(found: Scene, kind: str) -> list[str]:
    return [text for _, given, text in found.shapes if kind in given["class"].split()]


def moments(library: str, world: str, task: str) -> Iterator[dict[str, Any]]:
    """Yield pictures with facts of a run, one for each hundred events."""
    facts: dict[str, float] = {}
    before: list[Any] = []

    def hear(event: Event) -> None:
        if isinstance(event, FactErased):
            facts.pop(format_list(event.fact), None)
        elif isinstance(event, FactAsserted):
            facts[format_list(event.fact)] = event.time

    run = rapc.load(library).start(world, tasks=(task,), seed=7, listeners=[hear])
    due = 0
    while run.step() and run.now < 100:
        if run.serial < due:
            continue
        due = run.serial + 100
        assert isinstance(run.port, Drawable)
        picture = json.loads(json.dumps(pictures.plain(run.port.picture())))
        yield {
            "picture": picture,
            "facts": [*facts.items()],
            "now": run.now,
            "before": before[-20:],
        }
        before.append(picture)


def test_truth_is_drawn_beside_belief() -> None:
    found = drawn(MAP)
    assert "yard: red rock; believed: nothing" in hints(found, "m-here")
    assert "barn: nothing; believed: red rock" in hints(found, "m-place")
    assert {"fuel: 2.5 ≠ 3", "says “hello”", "dark", "arm (folded)"} <= {*texts(found)}
    [unsure] = [given for _, given, _ in found.shapes if "m-unsure" in given["class"]]
    assert unsure["fill"] == "#d73027"
    true = scene_of(MAP, Beliefs(KNOWN, 10, compared=False))
    assert true is not None
    assert not any("≠" in text for text in texts(true))


def test_path_joins_the_spots_of_the_pictures_before() -> None:
    [line] = hints_of(drawn(MAP, before=[{**MAP, "here": "barn"}]), "m-path")
    assert line == "314,134 66,30"
    assert hints_of(drawn(MAP), "m-path") == []


def hints_of(found: Scene, kind: str) -> list[str]:
    return [given["points"] for _, given, _ in found.shapes if given["class"] == kind]


def test_world_without_picture_shows_places_in_memory() -> None:
    found = drawn(None, {**KNOWN, "(road arm barn)": 1.0})
    assert [text for text in texts(found) if text in ("arm", "barn")] == ["arm", "barn"]
    assert len(hints(found, "m-road")) == 1
    assert scene_of(None, Beliefs({"(fuel 3)": 1.0}, 2)) is None


def test_letters_of_kinds_differ() -> None:
    kinds = ("gun", "gun-tool", "rock")
    things = [{"kind": kind} for kind in kinds]
    spot = {"name": "yard", "at": [0, 0], "things": things}
    found = drawn({**MAP, "spots": [spot]}, {})
    assert "boxes: g gun, u gun-tool, r rock; the colour is the look" in texts(found)


def test_svg_is_well_formed_and_shows_hostile_text_as_text() -> None:
    name = "</svg><script>alert(1)</script>\x1b[2J&"
    spots = [{"name": name, "at": [0, 0], "things": [{"kind": name, "look": name}]}]
    text = svg(drawn({**MAP, "spots": spots, "here": name}), name)
    root = ET.fromstring(text)  # noqa: S314  # made here
    assert {one.tag.rpartition("}")[2] for one in root.iter()} <= {
        *("svg", "title", "style", "rect", "circle", "line", "polyline", "text")
    }
    assert "\x1b" not in text
    assert "var(" not in text
    assert "light-dark" not in text


@pytest.mark.parametrize("world", ["truck", "hallway", "courier"])
def test_worlds_write_pictures_without_a_run(world: str, tmp_path: Path) -> None:
    file = tmp_path / "world.svg"
    done = command("worlds", world, "--picture", str(file))
    assert (done.returncode, done.stdout) == (0, f"wrote {file}\n")
    text = file.read_text(encoding="utf-8")
    assert len(list(ET.fromstring(text))) > 20  # noqa: S314  # made here
    assert "≠" not in text


def test_view_writes_the_picture_of_a_moment(tmp_path: Path) -> None:
    trace, given = tmp_path / "run.jsonl", ("--task", "(rock-order red 1)")
    run = ("run", TRUCK, "--world", "truck", *given, "-q", "--trace", str(trace))
    assert command(*run).returncode == 0
    drawings = []
    for at in ((), ("--at", "1"), ("--at", "150")):
        file = tmp_path / "moment.svg"
        done = command("view", str(trace), "--picture", str(file), *at)
        assert (done.returncode, done.stdout) == (0, f"wrote {file}\n")
        drawings.append(file.read_text(encoding="utf-8"))
    assert len({*drawings}) == 3
    assert not Path("run.html").exists()
    with_pictures = tmp_path / "pictured.jsonl"
    assert command(*run[:-1], str(with_pictures), "--trace-pictures").returncode == 0
    file = tmp_path / "other.svg"
    text = with_pictures.read_text().replace('"digest":"', '"digest":"0', 1)
    with_pictures.write_text(text)
    more = ("--picture", str(file), "--at", "150")
    assert command("view", str(with_pictures), *more).returncode == 0
    assert file.read_text(encoding="utf-8").replace("pictured", "run") == drawings[2]


def test_report_and_trace_have_the_same_pictures(tmp_path: Path) -> None:
    trace, report = tmp_path / "run.jsonl", tmp_path / "run.bug"
    run = ("--world", "courier", "--agenda", "shift", "--until", "3000", "-q")
    command("run", "examples/courier", *run, "--seed", "1", "--trace", str(trace))
    assert command("bug", str(trace), "-o", str(report)).returncode == 0
    found = []
    for file in (trace, report):
        page = tmp_path / "page.html"
        assert command("view", str(file), "-o", str(page)).returncode == 0
        more = json.loads(data_of(page.read_text(encoding="utf-8"))["more-0"])
        found.append(more["pictures"])
    assert found[0] == found[1]
    assert len(found[0]) > 10


@pytest.mark.slow
@pytest.mark.parametrize(("library", "world", "task"), RUNS)
def test_page_draws_the_same_shapes(library: str, world: str, task: str) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    given = [*moments(library, world, task)]
    odd = {"picture": MAP, "facts": [*KNOWN.items()], "now": 10, "before": [MAP, MAP]}
    given += [odd, {**odd, "picture": None}]
    files = [PAGE / name for name in ("model.js", "dom.js", "map.js")]
    files.append(Path(__file__).with_name("scenes.js"))
    script = "".join(file.read_text(encoding="utf-8") for file in files)
    lines = "".join(json.dumps(one) + "\n" for one in given)
    done = subprocess.run(
        [node, "--input-type=commonjs", "-e", script],
        input=lines,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    shown = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(shown) == len(given) > 3
    for one, there in zip(given, shown, strict=True):
        here = scene_of(
            one["picture"], Beliefs(dict(one["facts"]), one["now"]), one["before"]
        )
        assert here is not None
        assert [here.width, here.height] == [there["width"], there["height"]]
        assert json.loads(json.dumps(here.shapes)) == there["shapes"]
