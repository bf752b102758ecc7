"""An hour of driving in the hallway world by scripted skills: its cost, and a picture.

python -m bench.hallway                     processor time of an hour
python -m bench.hallway --picture FILE.png  the map and one long drive (needs viz)
python -m bench.hallway --seconds 0 --picture FILE.svg      the map alone
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from random import Random
from typing import Any

from rapc.worlds.hallway.picture import floor_plan
from rapc.worlds.hallway.state import HallwaySettings
from tests.hallway.driver import Driver
from tests.hallway.journey import Traveller

HOUR = 3600.0

Track = list[tuple[int, float, float, float, float]]
"""Floor, true place, reckoned place, tick by tick."""


def main() -> None:
    """Measure, or draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--picture", type=Path, help="where to draw the drive")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, help="how long to drive")
    given = parser.parse_args()
    seconds = HOUR if given.picture is None else 900.0
    if given.seconds is not None:
        seconds = given.seconds
    start = time.process_time()
    driver, track, journeys = drive(given.seed, seconds)
    used = time.process_time() - start
    state = driver.sim.state
    print(
        f"{driver.sim.now:.0f} s of driving in {used:.1f} s of processor time, "
        f"{used / max(state.ticks, 1) * 1000:.2f} ms a tick; "
        f"{state.robot.distance:.0f} m, "
        f"{journeys} journeys, {len(state.collisions)} collisions"
    )
    if given.picture is not None:
        draw(driver, track, given.picture)


def drive(seed: int, seconds: float) -> tuple[Driver, Track, int]:
    """Drive from landmark to landmark for some time; return where the robot was."""
    driver, rng = Driver(seed, HallwaySettings(usage=0)), Random(seed)
    track: Track = []
    tick = driver.tick

    def traced(ticks: int = 1) -> Any:
        told = tick(ticks)
        body = driver.sim.state.robot
        track.append((body.floor, body.x, body.y, body.reckoned_x, body.reckoned_y))
        return told

    driver.__dict__["tick"] = traced
    signs = [sign for sign in driver.sim.signs if sign.space != "lift"]
    traveller, journeys = Traveller(driver, "lab", "charger"), 0
    while driver.sim.now < seconds:
        goal = rng.choice(signs)
        driver.sim.state.said.append((driver.sim.now, f"to {goal.says}"))
        journeys += traveller.travel(goal.landmark, goal.space, within=600)
    return driver, track, journeys


def draw(driver: Driver, track: Track, path: Path) -> None:
    """Draw both floors, the drive, and how things stand at its end."""
    from matplotlib import rc_context  # noqa: PLC0415 (only the picture needs viz)
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(15, 7), layout="constrained")
    floors = sorted(driver.sim.plans)
    sheets = figure.subplots(1, len(floors), sharex=True, sharey=True, squeeze=False)
    for axes, floor in zip(sheets[0], floors, strict=True):
        draw_floor(axes, driver, floor)
        true = [(x, y) for f, x, y, _, _ in track if f == floor]
        reckoned = [(x, y) for f, _, _, x, y in track if f == floor]
        if track:
            axes.plot(*zip(*reckoned, strict=True), ",", color="tab:orange")
            axes.plot(*zip(*true, strict=True), ",", color="tab:blue")
        axes.set_aspect("equal")
        told = ": true track blue, dead reckoning orange" if track else ""
        axes.set_title(f"floor {floor}{told}")
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "hallway"}):
        about = {"Date": None} if path.suffix == ".svg" else None
        figure.savefig(path, dpi=90, metadata=about)


def draw_floor(axes: Any, driver: Driver, floor: int) -> None:
    """Draw a floor with all that stands and moves on it."""
    from matplotlib.patches import Circle, Rectangle  # noqa: PLC0415

    seen = floor_plan(driver.sim, floor)
    for area in seen.areas:
        left, bottom, right, top = area.box
        middle = ((left + right) / 2, (bottom + top) / 2)
        upright = top - bottom > 2 * (right - left)
        turn = 90 if upright else 0
        axes.text(
            *middle, area.name, ha="center", va="center", fontsize=7, rotation=turn
        )
    for start, end in seen.walls:
        axes.plot(*zip(start, end, strict=True), color="0.35", lw=2)
    for left, bottom, right, top in seen.blocks:
        corner = (left, bottom)
        axes.add_patch(Rectangle(corner, right - left, top - bottom, color="0.6"))
    for door in seen.doors:
        if door.closed:
            axes.plot(*door.at, "X", color="tab:red", ms=8)
    for mark in seen.marks:
        axes.plot(*mark.at, "s", color="tab:green", ms=3)
    for place in seen.others:
        axes.add_patch(Circle(place, 0.25, color="tab:purple"))
    if seen.robot is not None:
        axes.add_patch(Circle(seen.robot[:2], 0.25, color="black"))
        for x, y in seen.echoes:
            axes.plot((seen.robot[0], x), (seen.robot[1], y), color="gold", lw=0.5)
    axes.autoscale_view()


if __name__ == "__main__":
    main()
