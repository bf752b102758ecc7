"""docs/trace.md names every event with its keys, and none that there is not."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec

from rapc import events

PAGE = Path(__file__).parents[2] / "docs" / "trace.md"
COMMON = {"n", "cycle", "time"}
_ROW = re.compile(r"^\| `([a-z-]+)` \| (`.*?`) \| ", re.M)


def _keys(kind: type[events.Event]) -> set[str]:
    return set(events.keys(kind)) - COMMON


def test_page_names_each_event_with_its_keys() -> None:
    rows = _ROW.findall(PAGE.read_text(encoding="utf-8"))
    told = {event: set(re.findall(r"`([a-z-]+)`", keys)) for event, keys in rows}
    assert len(rows) == len(told)
    assert told == {name: _keys(kind) for name, kind in events.kinds().items()}


def test_common_keys_are_those_of_every_event() -> None:
    assert {f.name for f in msgspec.structs.fields(events.Event)} == COMMON
    assert events.Event.__struct_config__.tag_field == "event"
