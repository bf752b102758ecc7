"""A floor from above, true to scale, with the robot's beliefs drawn over it.

Walls, obstacles and the rays of the sensors are lines of dots. Other things are
characters: the robot, its believed position, other agents, doors, landmarks.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rich.text import Text

from rapc.base.pictures import Area, Door, Mark, Plan, Point, Pose, Reckoning
from rapc.base.values import Atom, Fact
from rapc.console.show.canvas import DOTS, Canvas, Dots
from rapc.console.show.labels import Inside, Taken, label, numbered
from rapc.runtime.memory.access import MemoryView

_COARSEST = 0.9
"""The largest size of a dot, in metres: a doorway is one metre wide."""

_WALL, _BLOCK, _RAY, _NAME = "blue", "magenta", "yellow", "dim"
_OTHER, _RIGHT, _WRONG = "bold cyan", "green", "bold red"
_ROBOT, _BELIEVED = "bold reverse", "bold yellow"

_HEADINGS = "→↗↑↖←↙↓↘"
"""The heading of the robot, by eighths of a turn from the x axis."""
_HEADINGS_BELIEVED = "⇒⇗⇑⇖⇐⇙⇓⇘"

_LEGEND = (
    ("→", "robot"),
    ("⇒", "where it believes to be"),
    ("◆", "counted from"),
    ("■", "known mark"),
    ("□", "unknown"),
    ("x", "closed"),
    ("X", "believed closed"),
    ("?", "wrongly so"),
    ("o", "somebody"),
    ("[ ]", "space believed"),
)


class _Scale(NamedTuple):
    """The scale of a plan: metres to dots and cells of a canvas."""

    #: The position of the leftmost and of the uppermost dot, in metres.
    west: float
    north: float
    #: The width and the height of a dot, in metres.
    dot: float

    def dots(self, point: Point) -> tuple[int, int]:
        """Return the dot of a point: column and row."""
        x, y = point
        return round((x - self.west) / self.dot), round((self.north - y) / self.dot)

    def cell(self, point: Point) -> tuple[int, int]:
        """Return the cell of a point: column and row."""
        column, row = self.dots(point)
        return column // DOTS[0], row // DOTS[1]


class Drawing(NamedTuple):
    """A plan as lines, and the meaning of the numbers on the plan."""

    rows: Sequence[Text]
    #: Numbers, each with the name that did not fit.
    numbers: Sequence[tuple[str, str]]


def draw_plan(
    plan: Plan, memory: MemoryView, width: int, height: int
) -> Drawing | None:
    """Return a plan as lines, or None if the cells are too few for the plan."""
    scale = _scale(plan, width, height)
    if scale is None:
        return None
    canvas, dots = Canvas(width, height), Dots(width, height)
    _lines(plan, dots, scale)
    others = set()
    for column, row, character, style in dots.cells():
        canvas.write(column, row, character, style)
        if style in {_WALL, _BLOCK}:
            others.add((column, row))
    signs = [
        (*scale.cell(at), character, style)
        for at, character, style in _characters(plan, memory)
    ]
    for column, row, *_ in signs:
        others.update({(column - 1, row), (column + 1, row)})
    taken = Taken({(column, row) for column, row, *_ in signs}, others)
    space, numbers = _believed_space(plan.reckoning, memory), list[tuple[str, str]]()
    for area in plan.areas:
        inside, believed = _inside(scale, area), area.name == space
        name = label(area.name, inside, taken, marked=believed)
        if name is None:
            number = str(len(numbers) + 1)
            numbers.append((number, area.name))
            name = numbered(number, inside, taken, marked=believed)
        for column, row, text in name:
            canvas.write(column, row, text, _RIGHT if believed else _NAME)
    for sign in signs:
        canvas.write(*sign)
    rows = list(canvas.lines())
    while rows and not rows[-1].plain:
        rows.pop()
    return Drawing(rows, numbers)


def legend(width: int, numbers: Sequence[tuple[str, str]] = ()) -> Iterator[Text]:
    """Yield the meaning of the characters of a plan, in as many lines as needed.

    Args:
        width: the width of a line.
        numbers: the numbers on the plan, each with its name.
    """
    line = Text(style="dim")
    for sign, means in (*_LEGEND, *numbers):
        entry = f"{sign} {means}"
        if line.plain and len(line.plain) + 3 + len(entry) > width:
            yield line
            line = Text(style="dim")
        line.append(f"   {entry}" if line.plain else entry)
    yield line


def _scale(plan: Plan, width: int, height: int) -> _Scale | None:
    xs = [x for wall in plan.walls for x, _ in wall]
    ys = [y for wall in plan.walls for _, y in wall]
    across, down = width * DOTS[0] - 1, height * DOTS[1] - 1
    if not xs or across < 1 or down < 1:
        return None
    dot = max((max(xs) - min(xs)) / across, (max(ys) - min(ys)) / down)
    return _Scale(min(xs), max(ys), dot) if 0 < dot <= _COARSEST else None


def _lines(plan: Plan, dots: Dots, scale: _Scale) -> None:
    """Draw all lines of dots; walls last, because the last style counts."""
    if plan.robot is not None:
        start = scale.dots(plan.robot[:2])
        for echo in plan.echoes:
            dots.line(start, scale.dots(echo), _RAY, every=3)
    for left, bottom, right, top in plan.blocks:
        (first, upper), (last, lower) = (
            scale.dots((left, top)),
            scale.dots((right, bottom)),
        )
        for row in range(upper, lower + 1):
            dots.line((first, row), (last, row), _BLOCK)
    for start_point, end_point in plan.walls:
        dots.line(scale.dots(start_point), scale.dots(end_point), _WALL)


def _inside(scale: _Scale, area: Area) -> Inside:
    """Return the cells inside the walls of a space."""
    left, bottom, right, top = area.box
    (first, upper), (last, lower) = scale.cell((left, top)), scale.cell((right, bottom))
    return Inside(first + 1, upper + 1, last - first - 1, lower - upper - 1)


def _characters(plan: Plan, memory: MemoryView) -> Iterator[tuple[Point, str, str]]:
    """Yield the characters of single things: cell, character, style."""
    origin = _origin(plan.reckoning, memory)
    for mark in plan.marks:
        yield (
            mark.at,
            *_mark(mark, memory, origin=origin is not None and origin[0] == mark.name),
        )
    for door in plan.doors:
        shown = _door(door, memory)
        if shown is not None:
            yield door.at, *shown
    for other in plan.others:
        yield other, "o", _OTHER
    believed = believed_pose(plan.reckoning, memory)
    if believed is not None:
        yield believed[:2], _pointing(_HEADINGS_BELIEVED, believed), _BELIEVED
    if plan.robot is not None:
        yield plan.robot[:2], _pointing(_HEADINGS, plan.robot), _ROBOT


def _pointing(arrows: str, pose: Pose) -> str:
    return arrows[round(pose[2] / (math.pi / 4)) % len(arrows)]


def _mark(mark: Mark, memory: MemoryView, *, origin: bool) -> tuple[str, str]:
    if origin:
        return "◆", _BELIEVED
    known = not mark.believed or bool(memory.query(*mark.believed))
    return ("■", _RIGHT) if known else ("□", _WRONG)


def _door(door: Door, memory: MemoryView) -> tuple[str, str] | None:
    """Return the character of a doorway; None if it is open, also in beliefs."""
    age = memory.age(*door.believed) if door.believed else None
    believed = age is not None and (door.counts is None or age <= door.counts)
    if door.closed:
        return ("X", _RIGHT) if believed else ("x", _WRONG)
    return ("?", _WRONG) if believed else None


# --- the robot's belief about its position -------------------------------------------


def believed_pose(reckoning: Reckoning | None, memory: MemoryView) -> Pose | None:
    """Return the robot's believed position on a plan; None if it is unknown.

    Its place and its reference landmark are in one frame, which is turned and moved so
    that the landmark has its position on the plan.
    """
    place = _last(memory, reckoning.place, 3) if reckoning else None
    origin = _origin(reckoning, memory)
    space = _believed_space(reckoning, memory)
    if reckoning is None or place is None or origin is None or space is None:
        return None
    at = str(origin[0]), str(space)
    stands = {(one.landmark, one.space): one.pose for one in reckoning.stands}.get(at)
    counted, now = _numbers(origin[1:]), _numbers(place)
    if stands is None or counted is None or now is None:
        return None
    turned = stands[2] - counted[2]
    cos, sin = math.cos(turned), math.sin(turned)
    dx, dy = now[0] - counted[0], now[1] - counted[1]
    x, y = stands[0] + cos * dx - sin * dy, stands[1] + sin * dx + cos * dy
    return x, y, now[2] + turned


def _numbers(values: Fact) -> Pose | None:
    match values:
        case (int() | float() as x, int() | float() as y, int() | float() as heading):
            return x, y, heading
    return None


def _origin(reckoning: Reckoning | None, memory: MemoryView) -> Fact | None:
    return _last(memory, reckoning.origin, 4) if reckoning else None


def _believed_space(reckoning: Reckoning | None, memory: MemoryView) -> Atom | None:
    last = _last(memory, reckoning.area, 1) if reckoning else None
    return last[0] if last else None


def _last(memory: MemoryView, prefix: Fact, more: int) -> Fact | None:
    """Return the rest of the newest fact with a given beginning, or None."""
    found = memory.query(*prefix, *[None] * more)
    return found[-1][len(prefix) :] if found else None
