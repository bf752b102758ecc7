"""One frame: the map with truth and beliefs, and the robot beside the map.

Each place has two lines: the things there, and below them `=` if the robot's belief is
equal, or `≠` and the robot's belief.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import msgspec
from rich.text import Text

from rapc.base.pictures import DIRECTIONS
from rapc.base.values import format_atom, readable
from rapc.console.lines import wrapped
from rapc.console.show.beliefs import (
    Contents,
    believed_contents,
    contents_in_words,
    true_contents,
)
from rapc.console.show.canvas import Canvas, fit, folded
from rapc.console.show.plan import draw_plan, legend
from rapc.runtime.memory.access import MemoryView
from rapc.world import Gauge, Picture, Spot, Time

_ARROWS = dict(zip(DIRECTIONS, "↑↗→↘↓↙←↖", strict=True))
_ROAD, _PLACE, _HERE, _TRUE = "blue", "bold", "bold reverse", ""
_RIGHT, _WRONG, _UNKNOWN = "green", "bold red", "yellow"
_LEAST = 3
"""The lowest number of rows of a place: name, truth, belief."""
_LEAST_WIDE = 14


class Activity(msgspec.Struct, frozen=True):
    """The robot's activity at one time: its current task and requests."""

    #: The time.
    time: Time = 0
    #: The goal of the top-level task of the active family.
    family: str = ""
    #: The latest requests for primitives, oldest first.
    requests: tuple[str, ...] = ()
    #: The names of the active skills, newest first.
    skills: tuple[str, ...] = ()


class _SpotView(msgspec.Struct, frozen=True):
    """A spot with its contents, and the contents that the robot believes in."""

    spot: Spot
    true: Contents
    believed: Contents

    @property
    def empty(self) -> bool:
        return not (self.true or self.believed)

    @property
    def right(self) -> bool:
        return self.true == self.believed

    def belief(self) -> tuple[str, str]:
        """Return the comparison of belief and truth, and its style."""
        if self.right:
            return "=", _RIGHT
        return (
            f"≠ {contents_in_words(self.believed)}",
            _WRONG if self.believed else _UNKNOWN,
        )


def draw_frame(
    picture: Picture, memory: MemoryView, doings: Activity, width: int, height: int
) -> list[Text]:
    """Return a picture beside memory as lines.

    Args:
        picture: the truth.
        memory: the beliefs.
        doings: the activity.
        width: the number of cells of a line.
        height: the highest number of lines; the rest is left out. With 0 there is no
            limit, and texts are not cut.
    """
    believed = believed_contents(memory, picture)
    sights = [
        _SpotView(s, true_contents(s.things), believed.pop(s.name, Counter()))
        for s in picture.spots
    ]
    around = [sight for sight in sights if sight.spot.at is not None]
    aboard = [sight for sight in sights if sight.spot.at is None]
    head = [_head(picture, memory, doings)]
    foot = [
        *_aboard(aboard, width, whole=not height),
        *_elsewhere(believed),
        *_doings(doings),
    ]
    lines = _with_plan(picture, memory, head, doings, (width, height))
    if lines is None:
        foot.append(Text("= as believed   ≠ what is believed instead", "dim"))
        room = max(height - len(head) - len(foot), 0) if height else None
        lines = [*head, *_map(picture, around, width, room), *foot]
    if not height:
        return lines
    for line in lines:
        line.truncate(width, overflow="ellipsis")
    return lines[:height]


def _with_plan(
    picture: Picture,
    memory: MemoryView,
    head: Sequence[Text],
    doings: Activity,
    size: tuple[int, int],
) -> list[Text] | None:
    """Return the lines of a frame with a plan; None if there is no plan or no room."""
    if picture.plan is None:
        return None
    width, height = size
    foot, signs = list(_doings(doings)), list(legend(width))
    rows: Sequence[Text] = ()
    for _ in range(2):  # the legend may need more lines once there are numbers
        room = height - len(head) - len(foot) - len(signs) if height else width
        drawn = draw_plan(picture.plan, memory, width, room)
        if drawn is None:
            return None
        rows, signs = drawn.rows, list(legend(width, drawn.numbers))
    return [*head, *rows, *foot, *signs]


def _head(picture: Picture, memory: MemoryView, doings: Activity) -> Text:
    line = Text().append(f"time {readable(doings.time)}", "bold")
    for gauge in picture.gauges:
        line.append(f"   {gauge.name} {readable(gauge.value)}")
        believed = _otherwise(gauge, memory)
        if believed:
            line.append(f" ≠ {believed}", _WRONG)
    if picture.said:
        line.append(f"   says “{picture.said}”")
    return line


def _otherwise(gauge: Gauge, memory: MemoryView) -> str:
    """Return the robot's belief about a gauge if it differs from the truth."""
    values = [fact[-1] for fact in memory.query(*gauge.believed, None)]
    if values == [gauge.value]:
        return ""
    return ", ".join(map(format_atom, values)) or "unknown"


# --- the map --------------------------------------------------------------------------


def _map(
    picture: Picture, sights: Sequence[_SpotView], width: int, height: int | None
) -> Iterator[Text]:
    """Yield the places as a map, or as a list if the map does not fit.

    Without a `height` the map is as high as the contents of the places.
    """
    across = max((s.spot.at[0] for s in sights if s.spot.at), default=0)
    down = max((s.spot.at[1] for s in sights if s.spot.at), default=0)
    wide = int(width / (across + 1))
    high = _enough(sights, wide) if height is None else int(height / (down + 1))
    if wide < _LEAST_WIDE or high < _LEAST:
        yield from _list(picture, sights, height)
        return
    cells = {
        s.spot.name: (round(s.spot.at[0] * wide), round(s.spot.at[1] * high))
        for s in sights
        if s.spot.at is not None
    }
    canvas = Canvas(width, round((down + 1) * high))
    for one, other in picture.roads:
        if one in cells and other in cells:
            canvas.line(cells[one], cells[other], _ROAD)
    for sight in sights:
        column, row = cells[sight.spot.name]
        beside = [c for c, r in cells.values() if r == row and c > column]
        room = min(beside, default=width) - column - 1
        _place(canvas, sight, picture, (column, row), (room, (high - 1) // 2))
    yield from canvas.lines()


def _place(
    canvas: Canvas,
    sight: _SpotView,
    picture: Picture,
    at: tuple[int, int],
    size: tuple[int, int],
) -> None:
    """Draw a place from a cell on, with a width and a number of content lines."""
    (column, row), (room, lines) = at, size
    name, style = sight.spot.name, _PLACE
    if name == picture.here:
        name, style = f"[{_ARROWS.get(picture.heading, '')}{name}]", _HERE
    canvas.write(column, row, fit(name, room), style)
    if sight.spot.note:
        note = fit(f" {sight.spot.note} ", room - len(name))
        canvas.write(column + len(name), row, note)
    if not sight.empty:
        belief, style = sight.belief()
        for text, drawn in ((contents_in_words(sight.true), _TRUE), (belief, style)):
            for line in folded(text, room - 2, lines):
                row += 1
                canvas.write(column + 2, row, line, drawn)


def _enough(sights: Sequence[_SpotView], wide: int) -> int:
    """Return the number of lines that a place needs for uncut contents."""
    texts = [t for s in sights for t in (contents_in_words(s.true), s.belief()[0])]
    most = max((len(wrapped(text, max(wide - 3, 1))) for text in texts), default=1)
    return max(1 + 2 * most, _LEAST)


def _list(
    picture: Picture, sights: Sequence[_SpotView], height: int | None
) -> Iterator[Text]:
    """Yield the places as a list, if a map does not fit; wrong beliefs first."""
    here = picture.here
    told = [s for s in sights if not s.empty or s.spot.name == here]
    told.sort(key=lambda s: (s.spot.name != here, s.right))
    fitting = told
    if height is not None and len(told) > height:
        fitting = told[: max(height - 1, 0)]
    for sight in fitting:
        name = sight.spot.name
        shown = f"[{_ARROWS.get(picture.heading, '')}{name}]" if name == here else name
        yield _row(sight, shown)
    if len(told) > len(fitting) and height:
        yield Text(f"and {len(told) - len(fitting)} more places", "dim")


# --- the robot ------------------------------------------------------------------------


def _row(sight: _SpotView, name: str) -> Text:
    """Return a spot in one line."""
    line = Text().append(name, _PLACE)
    if sight.spot.note:
        line.append(f" ({sight.spot.note})")
    if not sight.empty:
        belief, style = sight.belief()
        line.append(f": {contents_in_words(sight.true)} ", _TRUE).append(belief, style)
    return line


def _aboard(sights: Sequence[_SpotView], width: int, *, whole: bool) -> Iterator[Text]:
    """Yield arms and bays, two in a line; if `whole`, only if none is cut."""
    middle = width // 2
    told = [_row(sight, sight.spot.name) for sight in sights]
    if whole and any(line.cell_len >= middle for line in told):
        yield from told
        return
    rows = (len(sights) + 1) // 2
    for at in range(rows):
        pair = [_row(s, s.spot.name) for s in sights[at::rows]]
        line = pair[0]
        if len(pair) > 1:
            line.truncate(middle - 1, overflow="ellipsis", pad=True)
            line = Text().append(line).append(" ").append(pair[1])
        yield line


def _elsewhere(believed: Mapping[str, Contents]) -> Iterator[Text]:
    """Yield beliefs about places that are not in the picture."""
    found = [
        f"{contents_in_words(contents)} at {place}"
        for place, contents in believed.items()
    ]
    line = Text().append("elsewhere", _PLACE)
    yield line.append(f": {', '.join(found)}") if found else line


def _doings(doings: Activity) -> Iterator[Text]:
    yield Text().append("task", _PLACE).append(f": {doings.family}")
    if doings.skills:
        yield Text().append("skills", _PLACE).append(f": {', '.join(doings.skills)}")
    for request in doings.requests:
        yield Text(f"  {request}")
