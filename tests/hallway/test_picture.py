"""The picture of the hallway world for a terminal."""

from __future__ import annotations

import re
from pathlib import Path
from random import Random

import pytest

import rapc as rapc_package
from rapc.base.values import Text
from rapc.console.show.plan import believed_pose
from rapc.library.loader import load
from rapc.worlds.hallway import HallwayWorld
from tests.cli.command import rapc

ROOT = Path(__file__).parents[2]


def test_the_picture_shows_the_robots_floor_and_what_is_true_there() -> None:
    picture = HallwayWorld(Random(0), {"doors": 0}).picture()
    spots = {spot.name: spot for spot in picture.spots}
    assert (picture.here, picture.heading) == ("lab", "west")
    assert {"lab", "lift", "north-hall"} <= set(spots)
    assert "attic" not in spots
    assert ("lab", "north-hall") in picture.roads
    assert spots["north-hall"].note == "somebody"
    places = [spot.at for spot in picture.spots if spot.at]
    assert min(x for x, _ in places) >= 0
    assert min(y for _, y in places) >= 0
    [gauge] = picture.gauges
    assert (gauge.value, gauge.believed) == ("lab", ("current-space", "robot"))


def test_a_closed_door_is_no_way() -> None:
    world = HallwayWorld(Random(0), {"doors": 20})
    world.advance(60)
    open_ways, shut = world.picture().roads, world.simulation.shut()
    assert shut
    for doorway in world.simulation.map.doorway:
        assert (doorway.joins in open_ways) == (doorway.name not in shut) or (
            world.simulation.openings[doorway.name].floor == 2
        )


def test_the_plan_shows_what_is_true_on_the_robots_floor() -> None:
    world = HallwayWorld(Random(0), {})
    world.activate(1, [(":detect-obstacles",)], [])
    world.advance(1)
    plan = world.picture().plan
    assert plan is not None
    names = {area.name for area in plan.areas}
    assert {"lab", "north-hall", "lift"} <= names
    assert "attic" not in names
    assert (len(plan.echoes), len(plan.others)) == (24, 5)
    assert plan.robot == pytest.approx((3.2, 17.5, 3.1416), abs=0.01)
    wall = [x for x, y in plan.echoes if abs(y - 17.5) < 0.05 and x < 3]
    assert wall == pytest.approx([2.2], abs=0.06)


def _frames(*args: str, **environment: str) -> str:
    done = rapc(
        *("run", "stdlib/hallway", "--world", "hallway", "--agenda", "errand"),
        *("--show", "--until", "12", *args),
        cwd=ROOT,
        **environment,
    )
    assert done.stderr == ""
    return done.stdout


def test_the_robot_and_its_belief_start_before_the_charger() -> None:
    """Where the two differ by less than a cell the robot hides its belief."""
    world = rapc_package.open_world("hallway", seed=0)
    assert isinstance(world, HallwayWorld)
    run = rapc_package.load(ROOT / "stdlib" / "hallway").start(world=world)
    plan = world.picture().plan
    assert plan is not None
    assert plan.robot is not None
    believed = believed_pose(plan.reckoning, run.memory)
    assert believed == pytest.approx(plan.robot, abs=0.01)


def test_there_is_a_frame_for_each_so_many_seconds_of_the_world() -> None:
    shown = _frames("--show-every", "3", COLUMNS="80", LINES="30")
    times = [float(t) for t in re.findall(r"^time ([\d.]+)", shown, re.M)]
    assert times == pytest.approx([2, 5, 8, 11, 12], abs=0.2)
    assert "\x1b" not in shown
    assert "⠀" not in shown
    assert re.search(r"^skills: [a-z-]+, ", shown, re.M)


@pytest.mark.parametrize("width", [40, 80, 200])
def test_frames_are_as_wide_as_the_terminal(width: int) -> None:
    shown = _frames(COLUMNS=str(width), LINES="30").partition("Run over")[0]
    lines = shown.splitlines()
    assert max(map(len, lines)) <= width
    assert len(lines) <= 30
    assert re.search(r"[→↗↑↖←↙↓↘]", shown)


def test_frame_of_60_columns_names_every_space() -> None:
    """Nobody covers a name, and no name is cut to less than three letters."""
    shown = _frames(COLUMNS="60", LINES="24").partition("Run over")[0]
    rows = shown.splitlines()
    columns = "\n".join(
        "".join(row[at : at + 1] or " " for row in rows) for at in range(60)
    )
    for name in ("lab", "office", "north-hall", "south-hall", "kitchen", "store"):
        assert name in shown
    for start in ("worksh", "meeting-", "mail-"):
        assert start in shown
    assert "west-hall" in columns
    assert shown.splitlines()[-1].endswith("1 lift")


def test_to_be_looked_at_changes_nothing(tmp_path: Path) -> None:
    shown, quiet = tmp_path / "shown.jsonl", tmp_path / "quiet.jsonl"
    _frames("--show-every", "1", "--trace", str(shown), "--until", "6")
    done = rapc(
        *("run", "stdlib/hallway", "--world", "hallway", "--agenda", "errand"),
        *("-q", "--until", "6", "--trace", str(quiet)),
        cwd=ROOT,
    )
    assert done.stderr == ""
    assert shown.read_bytes() == quiet.read_bytes()


def test_the_page_names_the_facts_by_which_the_picture_tells_belief() -> None:
    """They are words of the library; a picture of another name would show nothing."""
    picture = HallwayWorld(Random(0), {}).picture()
    plan = picture.plan
    assert plan is not None
    told = {str(gauge.believed[0]) for gauge in picture.gauges}
    told |= {str(door.believed[0]) for door in plan.doors}
    told |= {str(mark.believed[0]) for mark in plan.marks}
    assert plan.reckoning is not None
    reckoning = plan.reckoning
    told |= {str(f[0]) for f in (reckoning.place, reckoning.origin, reckoning.area)}
    page = (ROOT / "docs" / "libraries" / "hallway.md").read_text(encoding="utf-8")
    [named] = re.findall(
        r"picture reads the\s+beliefs from the facts (.*?)\n\n", page, re.S
    )
    assert told == set(re.findall(r"`([^`]+)`", named))
    library = load([ROOT / "stdlib" / "hallway"]).library
    assert told <= {*library.propositions, *library.properties}


def test_what_the_robot_says_is_printed_and_kept() -> None:
    world = HallwayWorld(Random(0), {"doors": 0})
    speak = (":speak", Text("the charger"))
    assert world.activate(1, [speak], [":spoken"]) is None
    world.advance(1)
    assert world.picture().said == "the charger"
    assert world.said == ((0.1, "the charger"),)
    world.messages()
    world.deactivate(1)
    world.advance(4)
    assert world.picture().said == ""
    assert world.said == ((0.1, "the charger"),)


def test_the_show_prints_what_is_said(tmp_path: Path) -> None:
    (tmp_path / "robot.rap").write_text('(require "hallway")')
    task = ("--task", '(say "the charger") :at 1')
    run = ("run", "robot.rap", "--world", "hallway", *task)
    done = rapc(*run, "--show", "--show-every", "1", cwd=tmp_path)
    assert done.returncode == 0
    heads = [line for line in done.stdout.splitlines() if line.startswith("time")]
    assert heads[-1].endswith("in lab   says “the charger”")
