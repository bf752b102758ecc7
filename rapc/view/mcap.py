"""A run as an MCAP file, which Foxglove and Lichtblick open.

Messages and schemas are JSON. Each event of the trace is a message of one topic: tasks,
requests, memory or other events. A world with pictures adds the picture, the pose of
the robot, the pose that the robot believes, and the map. A time unit is a second.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any, BinaryIO

import msgspec
from mcap.writer import Writer

from rapc import events
from rapc.base import pictures
from rapc.base.version import VERSION
from rapc.view.pictures import Change, valid
from rapc.view.scene import Beliefs, believed_pose

Json = Mapping[str, Any]

_UNIT = 1_000_000_000
"""The nanoseconds in a time unit."""

_TOPICS = {"task": "/tasks", "method": "/tasks", "primitive": "/requests"}
_TOPICS |= {"request": "/requests", "skill": "/requests"}
_TOPICS |= {"fact": "/memory", "item": "/memory"}
_OTHERS = "/events"
"""The topics by the first word of the kind of an event, and the topic of others."""

_SCENE, _POSE = "foxglove.SceneUpdate", "foxglove.PoseInFrame"
_FRAME = "map"
_WALL = {"r": 0.23, "g": 0.27, "b": 0.32, "a": 1}
_BLOCK = {"r": 0.72, "g": 0.75, "b": 0.8, "a": 1}
_NAME = {"r": 0.35, "g": 0.38, "b": 0.44, "a": 1}
_THICK, _FONT = 2, 0.5
"""The thickness of lines in pixels, and the height of letters in metres."""


def write_mcap(
    stream: BinaryIO, records: Iterable[Json], changes: Sequence[Change]
) -> None:
    """Write a run to a stream.

    Args:
        stream: the stream.
        records: the events, each as in the trace.
        changes: the changes of the picture beside the trace; none if there are none.

    Raises:
        LoadError: if the trace has an invalid picture.
    """
    made = _File(Writer(stream))
    made.write(records, iter(changes))


class _File:
    """An MCAP file that is being written."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._channels: dict[str, int] = {}
        self._schemas: dict[str, int] = {}
        self._facts: dict[str, float] = {}
        self._picture: Json = {}
        self._map: Any = None

    def write(self, records: Iterable[Json], changes: Iterator[Change]) -> None:
        self._writer.start(profile="", library=f"rapc {VERSION}")
        due = next(changes, None)
        for one in records:
            kind = one["event"]
            topic = _TOPICS.get(kind.partition("-")[0], _OTHERS)
            self._add(topic, f"rapc.{topic[1:].title()}", one, one["time"], one["n"])
            if kind == "fact-asserted":
                self._facts[one["fact"]] = one["time"]
            elif kind == "fact-erased":
                self._facts.pop(one["fact"], None)
            elif kind == "pictured":
                self._draw(one["changed"], one)
            while due is not None and due[0] <= one["n"]:
                self._draw(due[1], one)
                due = next(changes, None)
        self._writer.finish()

    def _draw(self, change: Json, one: Json) -> None:
        """Write the picture after a change, at the time of an event."""
        now, serial = one["time"], one["n"]
        self._picture = pictures.changed(self._picture, change)
        picture = valid(self._picture)
        self._add("/picture", "rapc.Picture", picture, now, serial)
        fixed = _map_of(picture)
        if fixed != self._map:
            self._map = fixed
            scene = _scene(fixed, now)
            self._add("/map", _SCENE, scene, now, serial)
        plan = picture.get("plan", {})
        true = plan.get("robot") or _spot_pose(picture)
        believed = believed_pose(plan.get("reckoning"), Beliefs(self._facts, now))
        for topic, pose in (("/pose", true), ("/pose/believed", believed)):
            if pose is not None:
                self._add(topic, _POSE, _pose_in_frame(pose, now), now, serial)

    def _add(
        self, topic: str, schema: str, message: Json, time: float, serial: int
    ) -> None:
        if topic not in self._channels:
            self._channels[topic] = self._writer.register_channel(
                topic, "json", self._schema(schema)
            )
        at = round(time * _UNIT)
        self._writer.add_message(
            self._channels[topic], at, msgspec.json.encode(message), at, serial
        )

    def _schema(self, name: str) -> int:
        if name not in self._schemas:
            data = msgspec.json.encode(schema_of(name))
            registered = self._writer.register_schema(name, "jsonschema", data)
            self._schemas[name] = registered
        return self._schemas[name]


# --- schemas --------------------------------------------------------------------------

_NUMBER: Json = {"type": "number"}
_TEXT: Json = {"type": "string"}
_TIME: Json = {
    "type": "object",
    "title": "time",
    "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}},
}


def _object(**properties: Json) -> Json:
    return {"type": "object", "properties": properties}


def _list(items: Json) -> Json:
    return {"type": "array", "items": items}


_VECTOR = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER)
_TURN = _object(x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)
_PLACED = _object(position=_VECTOR, orientation=_TURN)
_COLOUR = _object(r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)

_SCENE_PARTS = {
    "lines": _object(
        type=_NUMBER,
        pose=_PLACED,
        thickness=_NUMBER,
        scale_invariant={"type": "boolean"},
        points=_list(_VECTOR),
        color=_COLOUR,
        colors=_list(_COLOUR),
        indices=_list(_NUMBER),
    ),
    "cubes": _object(pose=_PLACED, size=_VECTOR, color=_COLOUR),
    "texts": _object(
        pose=_PLACED,
        billboard={"type": "boolean"},
        font_size=_NUMBER,
        scale_invariant={"type": "boolean"},
        color=_COLOUR,
        text=_TEXT,
    ),
}
_FOXGLOVE: Mapping[str, Json] = {
    _POSE: _object(timestamp=_TIME, frame_id=_TEXT, pose=_PLACED),
    _SCENE: _object(
        deletions=_list(_object(timestamp=_TIME, type=_NUMBER, id=_TEXT)),
        entities=_list(
            _object(
                timestamp=_TIME,
                frame_id=_TEXT,
                id=_TEXT,
                lifetime=_TIME,
                frame_locked={"type": "boolean"},
                metadata=_list(_object(key=_TEXT, value=_TEXT)),
                **{name: _list(part) for name, part in _SCENE_PARTS.items()},
            )
        ),
    ),
}
"""The schemas of Foxglove, with the fields that are written here."""

_TYPES: Mapping[Any, str] = {int: "integer", bool: "boolean", int | float: "number"}
"""The types of values in JSON, by the types of fields."""


@cache
def schema_of(name: str) -> Json:
    """Return the JSON schema of the messages of a name."""
    if name in _FOXGLOVE:
        return {"title": name, **_FOXGLOVE[name]}
    if name == "rapc.Picture":
        _, found = msgspec.json.schema_components([pictures.Picture])
        return {"title": name, "$defs": found, "$ref": "#/$defs/Picture"}
    own = [
        kind
        for tag, kind in events.kinds().items()
        if _TOPICS.get(tag.partition("-")[0], _OTHERS) == f"/{name[5:].lower()}"
    ]
    common: dict[str, Json] = {"event": _TEXT}
    for kind in own:
        for field in msgspec.structs.fields(kind):
            known = field.required and field.type in _TYPES
            shape = {"type": _TYPES[field.type]} if known else {}
            if common.setdefault(field.encode_name, shape) != shape:
                common[field.encode_name] = {}
    needed = ["event", "n", "cycle", "time"]
    return {"title": name, "type": "object", "properties": common, "required": needed}


# --- poses and maps -------------------------------------------------------------------


def _stamp(time: float) -> Json:
    seconds = math.floor(time)
    return {"sec": seconds, "nsec": round((time - seconds) * _UNIT)}


def _pose(x: float, y: float, heading: float = 0, z: float = 0) -> Json:
    turn = {"x": 0, "y": 0, "z": math.sin(heading / 2), "w": math.cos(heading / 2)}
    return {"position": {"x": x, "y": y, "z": z}, "orientation": turn}


def _pose_in_frame(pose: Sequence[float], now: float) -> Json:
    return {"timestamp": _stamp(now), "frame_id": _FRAME, "pose": _pose(*pose)}


def _spot_pose(picture: Json) -> tuple[float, float, float] | None:
    """Return the position of the robot's spot on a map without scale."""
    for spot in picture["spots"]:
        if spot["name"] == picture["here"] and spot.get("at") is not None:
            return spot["at"][0], -spot["at"][1], 0
    return None


def _map_of(picture: Json) -> Json:
    """Return the parts of a map that are drawn once: lines, blocks and names."""
    plan = picture.get("plan")
    if plan is not None:
        names = [
            (area["name"], [(area["box"][i] + area["box"][i + 2]) / 2 for i in (0, 1)])
            for area in plan["areas"]
        ]
        lines = [end for wall in plan["walls"] for end in wall]
        return {"lines": lines, "blocks": plan.get("blocks", ()), "names": names}
    at = {
        spot["name"]: [spot["at"][0], -spot["at"][1]]
        for spot in picture["spots"]
        if spot.get("at") is not None
    }
    roads = [r for r in picture.get("roads", ()) if r[0] in at and r[1] in at]
    lines = [at[name] for road in roads for name in road]
    return {"lines": lines, "blocks": (), "names": [*at.items()]}


def _scene(fixed: Json, now: float) -> Json:
    """Return a map as an update of a scene."""
    lines = {
        "type": 2,  # a list of lines
        "pose": _pose(0, 0),
        "thickness": _THICK,
        "scale_invariant": True,
        "points": [{"x": x, "y": y, "z": 0} for x, y in fixed["lines"]],
        "color": _WALL,
        "colors": [],
        "indices": [],
    }
    cubes = [
        {
            "pose": _pose((left + right) / 2, (low + high) / 2, 0, 0.25),
            "size": {"x": right - left, "y": high - low, "z": 0.5},
            "color": _BLOCK,
        }
        for left, low, right, high in fixed["blocks"]
    ]
    texts = [
        {
            "pose": _pose(*at),
            "billboard": True,
            "font_size": _FONT,
            "scale_invariant": False,
            "color": _NAME,
            "text": name,
        }
        for name, at in fixed["names"]
    ]
    entity = {
        "timestamp": _stamp(now),
        "frame_id": _FRAME,
        "id": "map",
        "lifetime": _stamp(0),
        "frame_locked": True,
        "metadata": [],
        "lines": [lines],
        "cubes": cubes,
        "texts": texts,
    }
    return {"deletions": [], "entities": [entity]}
