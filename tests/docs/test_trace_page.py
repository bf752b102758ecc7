"""docs/trace.md names every event with its keys, and none that there is not."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import msgspec

from rapc.language.trace_events import COMMON as COMMON_KEYS
from rapc.language.trace_events import KEYS
from rapc.runtime.events import events

PAGE = Path(__file__).parents[2] / "docs" / "trace.md"
COMMON = {"n", "cycle", "time"}
_ROW = re.compile(r"^\| `([a-z-]+)` \| (`.*?`) \| ", re.M)


def _keys(kind: type[events.Event]) -> set[str]:
    return {field.encode_name for field in msgspec.structs.fields(kind)} - COMMON


def _kinds(kind: type[events.Event]) -> Iterator[type[events.Event]]:
    """The kinds of events below one; those that have kinds below them do not occur."""
    below = kind.__subclasses__()
    if not below:
        yield kind
    for one in below:
        yield from _kinds(one)


def test_page_names_each_event_with_its_keys() -> None:
    rows = _ROW.findall(PAGE.read_text(encoding="utf-8"))
    told = {event: set(re.findall(r"`([a-z-]+)`", keys)) for event, keys in rows}
    assert len(rows) == len(told)
    built = _kinds(events.Event)
    assert told == {str(kind.__struct_config__.tag): _keys(kind) for kind in built}


def test_what_tests_may_expect_is_what_a_trace_holds() -> None:
    built = {str(k.__struct_config__.tag): _keys(k) for k in _kinds(events.Event)}
    assert {name: set(keys) for name, keys in KEYS.items()} == built
    assert set(COMMON_KEYS) == COMMON


def test_common_keys_are_those_of_every_event() -> None:
    assert {f.name for f in msgspec.structs.fields(events.Event)} == COMMON
    assert events.Event.__struct_config__.tag_field == "event"
