"""The drawing of a picture beside what the robot believes, as shapes.

The shapes are SVG elements as plain data. `page/map.js` has the same functions for the
page, and the tests compare the shapes of both: a change here is a change there.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rapc.base import values
from rapc.base.pictures import DIRECTIONS, outermost
from rapc.base.values import format_atom

Shape = tuple[str, dict[str, Any], str]
"""An element: its tag, its attributes, and its text; a text of a shape is a hint."""

Contents = dict[tuple[str, str], int]
"""The number of things of a class with a look (`red`, or no text)."""

Json = Mapping[str, Any]

_ACROSS, _DOWN = 124, 104
"""The least distance of two spots in a row and of two rows, in pixels."""
_SIDE, _TOP = 66, 30
_BOX, _ROW = 11, 8
"""The size of the box of a thing, and the number of boxes in a row."""
_WIDE = 760
"""The width of a plan and of lines of text."""
_LETTER, _BOLD = 6.0, 7.2
"""The average width of a letter, plain and bold."""

_LOOKS = {
    "red": "#d73027",
    "blue": "#3a6fd8",
    "yellow": "#f2c81e",
    "green": "#35a35c",
    "white": "#ffffff",
    "black": "#222222",
    "orange": "#f08a24",
    "brown": "#8a5a33",
    "purple": "#8e4bb0",
    "grey": "#8b919b",
}
"""The colours of looks."""

_TURNS = {name: 45 * number for number, name in enumerate(DIRECTIONS)}

_WORD = re.compile(r'"(?:[^"\\]|\\.)*"|[^\s()"]*\([^()]*\)|[^\s()"]+')


class Scene(NamedTuple):
    """Shapes, and the size of the space that they take in pixels."""

    width: float
    height: float
    shapes: list[Shape]


class Beliefs:
    """The facts of memory at a moment, for drawing.

    Args:
        facts: the facts as texts, each with the time of its last assertion.
        now: the time of the moment.
        compared: whether drawings show where the facts differ from the truth.
    """

    def __init__(
        self, facts: Mapping[str, float], now: float, *, compared: bool = True
    ) -> None:
        self._now = now
        self.compared = compared
        self._facts: dict[str, list[tuple[list[str], float]]] = {}
        for text, since in facts.items():
            words = _WORD.findall(text[1:-1])
            if words:
                self._facts.setdefault(words[0], []).append((words, since))

    def find(self, pattern: Sequence[Any]) -> list[tuple[list[str], float]]:
        """Return the facts that match, each with its age; None matches any word."""
        wanted = [None if one is None else word(one) for one in pattern]
        return [
            (words, self._now - since)
            for words, since in self._facts.get(wanted[0] or "", [])
            if len(words) == len(wanted)
            and all(w in (None, given) for w, given in zip(wanted, words, strict=True))
        ]

    def last(self, prefix: Sequence[Any], more: int) -> list[str] | None:
        """Return the rest of the newest fact with a beginning, or None."""
        found = self.find([*prefix, *[None] * more])
        return found[-1][0][len(prefix) :] if found else None

    def contents(self, look: str) -> dict[str, Contents]:
        """Return the things that the robot believes in, by spot.

        The first class of an item in memory is the class of its introduction. An item
        that is believed to be in a second item is at the place of the second.
        """
        places = {
            words[1]: words[2] for words, _ in self.find(("location", None, None))
        }
        looks = {words[1]: words[2] for words, _ in self.find((look, None, None))}
        found: dict[str, Contents] = {}
        seen = set()
        for words, _ in self.find(("class", None, None, "true")):
            item, kind = words[1], words[2]
            if item in places and item not in seen:
                seen.add(item)
                here = found.setdefault(outermost(places[item], places), {})
                key = kind, looks.get(item, "")
                here[key] = here.get(key, 0) + 1
        return found

    def places(self) -> list[str]:
        """Return the places of items, sorted."""
        found = {words[2] for words, _ in self.find(("location", None, None))}
        return sorted(found - {"unknown"})

    def roads(self, places: Sequence[str]) -> list[tuple[str, str]]:
        """Return the pairs of places that one fact names."""
        known, found = set(places), set()
        for facts in self._facts.values():
            for words, _ in facts:
                pair = [one for one in words[1:] if one in known]
                if len(pair) == 2 and pair[0] != pair[1]:
                    found.add((min(pair), max(pair)))
        return sorted(found)


def word(atom: Any) -> str:
    """Return an atom of a picture as the word of a fact."""
    if isinstance(atom, Mapping):
        return f'"{atom.get("value", "")}"'
    return format_atom(atom) if isinstance(atom, float | int) else str(atom)


def _short(text: str) -> str:
    """Return a word, with at most three decimals in a number."""
    number = _floats([text])
    if number is None:
        return text
    return format_atom(values.number(math.floor(number[0] * 1000 + 0.5) / 1000))


def believed_picture(beliefs: Beliefs) -> dict[str, Any] | None:
    """Return a picture of the places that memory knows; None without places."""
    places = beliefs.places()
    if not places:
        return None
    wide = math.ceil(math.sqrt(len(places)))
    return {
        "here": "",
        "spots": [
            {"name": name, "at": [at % wide, at // wide], "things": [], "note": ""}
            for at, name in enumerate(places)
        ],
        "roads": beliefs.roads(places),
        "look": "color",
    }


def scene_of(
    picture: Json | None, beliefs: Beliefs, before: Sequence[Json] = ()
) -> Scene | None:
    """Return the drawing of a picture; without a picture, of the places in memory.

    Args:
        picture: the picture as plain data; None if the world has none.
        beliefs: memory.
        before: the pictures before, for the path of the robot.
    """
    if picture is None:
        only = believed_picture(beliefs)
        return None if only is None else _map(only, beliefs, (), alone=True)
    if picture.get("plan") is not None:
        return _plan(picture, beliefs, before)
    return _map(picture, beliefs, before)


# --- a map of spots and roads ---------------------------------------------------------


class _Sight(NamedTuple):
    """A spot with its contents, true and believed."""

    spot: Json
    true: Contents
    believed: Contents
    #: Whether there is no truth, and whether the belief is compared with the truth.
    alone: bool
    compared: bool

    @property
    def wrong(self) -> bool:
        return self.compared and self.true != self.believed

    @property
    def shown(self) -> Contents:
        return self.believed if self.alone else self.true


def _map(
    picture: Json, beliefs: Beliefs, before: Sequence[Json], alone: bool = False
) -> Scene:
    believed = beliefs.contents(word(picture.get("look", "")))
    compared = beliefs.compared and not alone
    sights = [
        _Sight(s, _contents(s["things"]), believed.pop(s["name"], {}), alone, compared)
        for s in picture["spots"]
    ]
    around = [sight for sight in sights if sight.spot.get("at") is not None]
    across, down = _steps(around)
    left = min((s.spot["at"][0] for s in around), default=0)
    top = min((s.spot["at"][1] for s in around), default=0)

    def placed(spot: Json) -> tuple[float, float]:
        x, y = spot["at"]
        return _SIDE + (x - left) * across, _TOP + (y - top) * down

    at = {s.spot["name"]: placed(s.spot) for s in around}
    width = 2.0 * _SIDE
    for sight in around:
        x, note = at[sight.spot["name"]][0], sight.spot.get("note", "")
        end = min(x + 13 + len(note) * _LETTER, _WIDE)
        width = max(width, x + _SIDE, end)
    lowest = max([y for _, y in at.values()] + [_TOP])
    shapes: list[Shape] = []
    for one, other in picture.get("roads", ()):
        if one in at and other in at:
            shapes.append(_line("m-road", at[one], at[other]))
    path = []
    for one in (*before, picture):
        for spot in one["spots"]:
            if spot["name"] == one["here"] and spot.get("at") is not None:
                path.append(placed(spot))
    if len(path) > 1:
        shapes.append(_polyline("m-path", path))
    letters = _letters({kind for s in sights for kind, _ in (*s.true, *s.believed)})
    bottom = lowest + 20
    for sight in around:
        x, y = at[sight.spot["name"]]
        shapes += _spot(sight, picture, letters, (x, y))
        bottom = max(bottom, y + 26 + _height(sight))
    width = max(width, 360)
    y = bottom + 14
    aboard = [sight for sight in sights if sight.spot.get("at") is None]
    column = 30 + max((len(_called(s.spot)) for s in aboard), default=0) * _BOLD
    for sight in aboard:
        shapes += _carried(sight, letters, (column, y))
        y += 18
    texts = _words_below(picture, beliefs, {} if alone else believed, letters)
    return _with_text(shapes, texts, width, y)


def _steps(sights: Sequence[_Sight]) -> tuple[float, float]:
    """Return the length of a step across and down, so that no spots touch."""
    points = [sight.spot["at"] for sight in sights]
    pairs = [(a, b) for i, a in enumerate(points) for b in points[:i]]
    beside = [abs(a[0] - b[0]) for a, b in pairs if abs(a[1] - b[1]) < 0.5]
    below = [abs(a[1] - b[1]) for a, b in pairs if abs(a[1] - b[1]) >= 0.25]
    least = min((one for one in beside if one >= 0.25), default=1)
    return _ACROSS / least, _DOWN / min(below, default=1)


def _contents(things: Sequence[Json]) -> Contents:
    found: Contents = {}
    for thing in things:
        look = thing.get("look")
        key = thing["kind"], "" if look is None else word(look)
        found[key] = found.get(key, 0) + 1
    return found


def _letters(kinds: set[str]) -> dict[str, str]:
    """Return a letter of each kind of thing, different if possible."""
    found: dict[str, str] = {}
    for kind in sorted(kinds):
        free = [one for one in kind if one.isalnum() and one not in found.values()]
        found[kind] = (free or list(kind) or ["?"])[0]
    return found


def in_words(contents: Contents) -> str:
    """Return contents as text: `2 red rock, fuel-drum`, or `nothing`."""
    parts = [
        " ".join(part for part in (str(n) if n > 1 else "", look, kind) if part)
        for (kind, look), n in sorted(contents.items())
    ]
    return ", ".join(parts) or "nothing"


def _spot(
    sight: _Sight, picture: Json, letters: Mapping[str, str], at: tuple[float, float]
) -> Iterator[Shape]:
    (x, y), here = at, sight.spot["name"] == picture["here"]
    name, note = sight.spot["name"], sight.spot.get("note", "")
    hint = name if sight.alone and not sight.believed else _hint(sight)
    yield _shape("circle", "m-place" + " m-here" * here, hint, cx=x, cy=y, r=8)
    if here and picture.get("heading") in _TURNS:
        yield _arrow(x, y, _TURNS[picture["heading"]])
    yield _text("m-name m-mid", name, x, y - 13)
    if note:
        yield _text("m-dim", note, x + 13, y + 4)
    west = x - _BOX * _ROW / 2
    yield from _boxes(sight.shown, letters, (west, y + 14), "", hint)
    if sight.wrong:
        below = y + 14 + _BOX * _rows(sight.true)
        yield _text("m-wrong", "≠", west - 11, below + 11)
        at = west, below + 2
        yield from _boxes(sight.believed, letters, at, " m-unsure", hint)


def _hint(sight: _Sight) -> str:
    """Return a spot in a line: its name, its contents, and the belief if different."""
    said = f"{sight.spot['name']}: {in_words(sight.shown)}"
    return f"{said}; believed: {in_words(sight.believed)}" if sight.wrong else said


def _rows(contents: Contents) -> int:
    return math.ceil(sum(contents.values()) / _ROW)


def _height(sight: _Sight) -> float:
    """Return the height of the boxes below a spot."""
    rows = _rows(sight.shown) + (max(_rows(sight.believed), 1) if sight.wrong else 0)
    return float(_BOX * rows)


def _arrow(x: float, y: float, turn: float) -> Shape:
    """Return an arrow beside a spot, in a direction: degrees clockwise from north."""
    angle = math.radians(turn)
    ahead, aside = (
        (math.sin(angle), -math.cos(angle)),
        (math.cos(angle), math.sin(angle)),
    )
    points = [
        (x + 14 * ahead[0] + 4 * aside[0], y + 14 * ahead[1] + 4 * aside[1]),
        (x + 19 * ahead[0], y + 19 * ahead[1]),
        (x + 14 * ahead[0] - 4 * aside[0], y + 14 * ahead[1] - 4 * aside[1]),
    ]
    return _polyline("m-arrow", points)


def _boxes(
    contents: Contents,
    letters: Mapping[str, str],
    at: tuple[float, float],
    extra: str,
    hint: str,
) -> Iterator[Shape]:
    """Yield a box with a letter for each thing."""
    x, y = at
    place = 0
    for (kind, look), count in sorted(contents.items()):
        for _ in range(count):
            column, row = place % _ROW, place // _ROW
            left, above = x + column * _BOX, y + row * _BOX
            box = {"x": left, "y": above, "width": _BOX - 2, "height": _BOX - 2}
            fill = _LOOKS.get(look, "")
            if fill:
                yield _shape("rect", f"m-thing{extra}", hint, fill=fill, **box)
            else:
                yield _shape("rect", f"m-thing{extra} m-plain", hint, **box)
            yield _text("m-letter", letters[kind], left + 4.5, above + 7.5)
            place += 1


def _called(spot: Json) -> str:
    return f"{spot['name']} ({spot['note']})" if spot.get("note") else spot["name"]


def _carried(
    sight: _Sight, letters: Mapping[str, str], at: tuple[float, float]
) -> Iterator[Shape]:
    """Yield a spot that the robot carries, in a line."""
    x, y = at
    yield _text("m-name", _called(sight.spot), 12, y)
    yield from _boxes(sight.shown, letters, (x, y - 9), "", _hint(sight))
    x += _BOX * min(sum(sight.shown.values()), _ROW) + (6 if sight.shown else 0)
    said = in_words(sight.shown)
    yield _text("m-dim", said, x, y)
    if sight.wrong:
        told = f"≠ {in_words(sight.believed)}"
        yield _text("m-wrong", told, x + 10 + len(said) * _LETTER, y)


def _words_below(
    picture: Json,
    beliefs: Beliefs,
    elsewhere: Mapping[str, Contents],
    letters: Mapping[str, str],
) -> Iterator[tuple[str, str]]:
    """Yield the lines of text below a drawing, each with its class."""
    for gauge in picture.get("gauges", ()):
        value = word(gauge["value"])
        last = beliefs.last(gauge["believed"], 1)
        believed = "unknown" if last is None else _short(last[0])
        line = f"{gauge['name']}: {_short(value)}"
        differs = last is None or (last[0] != value and believed != _short(value))
        if differs and beliefs.compared:
            yield "m-wrong", f"{line} ≠ {believed}"
        else:
            yield "", line
    if picture.get("said"):
        yield "", f"says “{picture['said']}”"
    for place, contents in sorted(elsewhere.items()):
        yield "m-dim", f"believed at {place}: {in_words(contents)}"
    if letters:
        told = ", ".join(f"{letter} {kind}" for kind, letter in letters.items())
        yield "m-dim", f"boxes: {told}; the colour is the look"
    if letters and beliefs.compared and picture["here"]:
        yield "m-dim", "≠ and dashed boxes: what the robot believes instead"


def _with_text(
    shapes: list[Shape], texts: Iterator[tuple[str, str]], width: float, y: float
) -> Scene:
    """Return a scene with lines of text below its shapes."""
    x = 12.0
    for kind, text in texts:
        needed = len(text) * _LETTER + 24
        if x > 12 and x + needed > width:
            x, y = 12.0, y + 16
        shapes.append(_text(kind, text, x, y))
        x += needed
        width = max(width, min(needed, _WIDE))
    return Scene(round(width, 1), round(y + 12, 1), shapes)


# --- a floor true to scale ------------------------------------------------------------


def _plan(picture: Json, beliefs: Beliefs, before: Sequence[Json]) -> Scene:
    plan = picture["plan"]
    boxes = [area["box"] for area in plan["areas"]]
    ends = [end for wall in plan["walls"] for end in wall]
    xs = [x for x, _ in ends] + [x for box in boxes for x in (box[0], box[2])]
    ys = [y for _, y in ends] + [y for box in boxes for y in (box[1], box[3])]
    west, north = min(xs, default=0), max(ys, default=0)
    east, south = max(xs, default=1), min(ys, default=0)
    scale = min((_WIDE - 24) / max(east - west, 1), 620 / max(north - south, 1))

    def at(point: Sequence[float]) -> tuple[float, float]:
        return 12 + (point[0] - west) * scale, 12 + (north - point[1]) * scale

    shapes: list[Shape] = []
    reckoning = plan.get("reckoning")
    space = beliefs.last(reckoning["area"], 1) if reckoning else None
    for area in plan["areas"]:
        shapes += _area(area, at, scale, space is not None and space[0] == area["name"])
    for left, low, right, high in plan.get("blocks", ()):
        x, y = at((left, high))
        size = {"width": (right - left) * scale, "height": (high - low) * scale}
        shapes.append(_shape("rect", "m-block", "obstacle", x=x, y=y, **size))
    for one, other in plan["walls"]:
        shapes.append(_line("m-wall", at(one), at(other)))
    robot, places = plan.get("robot"), {area["name"] for area in plan["areas"]}
    if robot is not None:
        here = at(robot)
        shapes += [_line("m-echo", here, at(end)) for end in plan.get("echoes", ())]
        path = [
            at(one["plan"]["robot"])
            for one in before
            if one.get("plan", {}).get("robot") is not None and one["here"] in places
        ]
        if path:
            shapes.append(_polyline("m-path", [*path, here]))
    origin = beliefs.last(reckoning["origin"], 4) if reckoning else None
    for mark in plan.get("marks", ()):
        is_origin = origin is not None and origin[0] == mark["name"]
        shapes.append(_mark(mark, at(mark["at"]), beliefs, is_origin))
    for door in plan.get("doors", ()):
        shapes += _door(door, at(door["at"]), beliefs)
    for other in plan.get("others", ()):
        x, y = at(other)
        shapes.append(_shape("circle", "m-other", "somebody", cx=x, cy=y, r=5))
    reckoned = believed_pose(reckoning, beliefs)
    if robot is not None:
        hint = f"robot in {picture['here']}"
        shapes.append(_pointer("m-robot", at(robot), robot[2], hint))
    if reckoned is not None:
        x, y = at(reckoned)
        if robot is not None:
            shapes.append(_line("m-off", at(robot), (x, y)))
        hint = "where the robot believes to be"
        shapes.append(_pointer("m-reckoned", (x, y), reckoned[2], hint))
    wide = 24 + max((east - west) * scale, 336)
    high = 24 + (north - south) * scale
    return _with_text(shapes, _below_plan(picture, beliefs), wide, high + 10)


def _below_plan(picture: Json, beliefs: Beliefs) -> Iterator[tuple[str, str]]:
    yield from _words_below(picture, beliefs, {}, {})
    yield "m-dim", "▲ robot; outlined: where it believes to be"
    yield "m-dim", "■ known mark, □ unknown, ◆ counted from"
    yield "m-dim", "× closed door: green known, red unknown, dashed believed wrongly"


def _area(area: Json, at: Any, scale: float, believed: bool) -> Iterator[Shape]:
    left, low, right, high = area["box"]
    x, y = at((left, high))
    width, height = (right - left) * scale, (high - low) * scale
    kind = "m-area m-believed-area" if believed else "m-area"
    hint = (
        f"{area['name']}: the robot believes to be here" if believed else area["name"]
    )
    yield _shape("rect", kind, hint, x=x, y=y, width=width, height=height)
    name = area["name"]
    upright = width < height and len(name) * 5.2 > width
    most = int((height if upright else width) / 5.2)
    if most < len(name) and most < 5:
        return
    shown = name if len(name) <= most else f"{name[: most - 1]}…"
    middle, centre = x + width / 2, y + height / 2
    if height > 40 and not upright:
        centre = y + 11
    if upright:
        turn = f"rotate(-90 {_plain(middle)} {_plain(centre)})"
        yield _text("m-label", shown, middle, centre + 3, transform=turn)
    else:
        yield _text("m-label", shown, middle, centre + 3)


def _mark(
    mark: Json, at: tuple[float, float], beliefs: Beliefs, is_origin: bool
) -> Shape:
    x, y = at
    size = {"width": 7, "height": 7}
    if is_origin:
        points = [(x - 5.5, y), (x, y - 5.5), (x + 5.5, y), (x, y + 5.5)]
        return _polygon("m-origin", points, f"{mark['name']}: counted from")
    known = not mark.get("believed") or bool(beliefs.find(mark["believed"]))
    kind = "m-known" if known else "m-unknown"
    hint = mark["name"] if known else f"{mark['name']}: unknown to the robot"
    return _shape("rect", kind, hint, x=x - 3.5, y=y - 3.5, **size)


def _door(door: Json, at: tuple[float, float], beliefs: Beliefs) -> Iterator[Shape]:
    (x, y), counts = at, door.get("counts")
    found = beliefs.find(door["believed"]) if door.get("believed") else []
    believed = any(counts is None or age <= counts for _, age in found)
    if not (door["closed"] or believed):
        return
    kind, said = {
        (True, True): ("m-closed-known", "closed"),
        (True, False): ("m-closed", "closed, which the robot does not know"),
        (False, True): ("m-closed-wrongly", "open, and believed closed"),
    }[bool(door["closed"]), believed]
    hint = f"{door['name']}: {said}"
    yield _line(kind, (x - 4.5, y - 4.5), (x + 4.5, y + 4.5), hint)
    yield _line(kind, (x - 4.5, y + 4.5), (x + 4.5, y - 4.5), hint)


def _pointer(kind: str, at: tuple[float, float], heading: float, hint: str) -> Shape:
    """Return a triangle that points in a heading."""
    (x, y), far, wide = at, 11, 7.5
    cos, sin = math.cos(heading), math.sin(heading)
    points = [
        (x + cos * ahead - sin * aside, y - sin * ahead - cos * aside)
        for ahead, aside in ((far, 0), (-far * 0.7, wide), (-far * 0.7, -wide))
    ]
    return _polygon(kind, points, hint)


def believed_pose(
    reckoning: Json | None, beliefs: Beliefs
) -> tuple[float, float, float] | None:
    """Return the robot's believed position on a plan; None if it is unknown."""
    if reckoning is None:
        return None
    place = beliefs.last(reckoning["place"], 3)
    origin = beliefs.last(reckoning["origin"], 4)
    space = beliefs.last(reckoning["area"], 1)
    if place is None or origin is None or space is None:
        return None
    stands = [
        stand["pose"]
        for stand in reckoning["stands"]
        if (stand["landmark"], stand["space"]) == (origin[0], space[0])
    ]
    counted, now = _floats(origin[1:]), _floats(place)
    if not stands or counted is None or now is None:
        return None
    x, y, heading = stands[-1]
    turned = heading - counted[2]
    cos, sin = math.cos(turned), math.sin(turned)
    dx, dy = now[0] - counted[0], now[1] - counted[1]
    return x + cos * dx - sin * dy, y + sin * dx + cos * dy, now[2] + turned


def _floats(words: Sequence[str]) -> list[float] | None:
    if not all(re.fullmatch(r"-?[0-9.]+(e-?[0-9]+)?", one) for one in words):
        return None
    return [float(one) for one in words]


# --- shapes ---------------------------------------------------------------------------


def _number(value: float) -> float:
    """Return a coordinate in tenths of a pixel."""
    return math.floor(value * 10 + 0.5) / 10


def _shape(tag: str, kind: str, hint: str, **more: Any) -> Shape:
    numbers = {k: v if isinstance(v, str) else _number(v) for k, v in more.items()}
    return tag, {"class": kind, **numbers}, hint


def _line(
    kind: str, one: tuple[float, float], other: tuple[float, float], hint: str = ""
) -> Shape:
    ends = {"x1": one[0], "y1": one[1], "x2": other[0], "y2": other[1]}
    return _shape("line", kind, hint, **ends)


def _polyline(kind: str, points: Sequence[tuple[float, float]]) -> Shape:
    return "polyline", {"class": kind, "points": _points(points)}, ""


def _polygon(kind: str, points: Sequence[tuple[float, float]], hint: str) -> Shape:
    return "polygon", {"class": kind, "points": _points(points)}, hint


def _points(points: Sequence[tuple[float, float]]) -> str:
    return " ".join(f"{_plain(x)},{_plain(y)}" for x, y in points)


def _plain(value: float) -> str:
    return f"{_number(value):g}"


def _text(kind: str, text: str, x: float, y: float, **more: Any) -> Shape:
    return "text", {"class": kind, "x": _number(x), "y": _number(y), **more}, text
