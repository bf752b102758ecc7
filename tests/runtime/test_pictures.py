"""The setting `rapc.pictures`: the trace has the changes of the world's picture."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rapc
from rapc.base import pictures
from rapc.events import Event, Pictured
from rapc.host import CheckedLibrary
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.world import Drawable
from tests.debug.sessions import TRUCK

TASKS = ("(rock-order red 1)",)

WORLDS = (
    (TRUCK, "truck", TASKS, 200),
    ("rapc:hallway", "hallway", ("(go-to coffee-machine)",), 30),
    ("examples/courier", "courier", ("(deliver meals ward-4)",), 100),
)
"""For each world a library, tasks and a time limit."""


def _begun(
    library: CheckedLibrary, world: str, tasks: tuple[str, ...], on: bool = True
) -> tuple[Interpreter, list[Event]]:
    told: list[Event] = []
    run = library.start(
        world,
        tasks=tasks,
        seed=7,
        settings=Settings(pictures=on),
        listeners=[told.append],
    )
    return run, told


def _last(told: list[Event]) -> dict[str, Any]:
    """Return the picture after all events."""
    found: dict[str, Any] = {}
    for event in told:
        if isinstance(event, Pictured):
            found = pictures.changed(found, event.changed)
    return found


def _now(run: Interpreter) -> Any:
    """Return the present picture, as a reader of the trace has it."""
    assert isinstance(run.port, Drawable)
    picture = run.port.picture()
    found = msgspec.json.decode(msgspec.json.encode(pictures.plain(picture)))
    assert pictures.from_plain(found).here == picture.here
    return found


@pytest.mark.parametrize(("library", "world", "tasks", "until"), WORLDS)
def test_changes_give_the_present_picture(
    library: str, world: str, tasks: tuple[str, ...], until: int
) -> None:
    run, told = _begun(rapc.load(library), world, tasks)
    count = 0
    while run.now < until and run.come_to_choice():
        assert _last(told) == _now(run)
        count += 1
        run.step()
    pictured = [one for one in told if isinstance(one, Pictured)]
    assert count > 2
    assert len(pictured) > 2
    assert all(one.changed for one in pictured)


def test_a_trace_has_no_pictures_by_default() -> None:
    run, told = _begun(rapc.load(TRUCK), "truck", TASKS, on=False)
    run.run()
    with_pictures, more = _begun(rapc.load(TRUCK), "truck", TASKS)
    with_pictures.run()
    assert not [one for one in told if isinstance(one, Pictured)]
    others = [one for one in more if not isinstance(one, Pictured)]
    assert [type(one) for one in others] == [type(one) for one in told]


def test_a_restored_run_emits_the_same_pictures() -> None:
    library = rapc.load(TRUCK)
    run, told = _begun(library, "truck", TASKS)
    for _ in range(60):
        run.step()
    saved, count = run.save(), len(told)
    run.run()
    first, told[count:] = told[count:], []
    run.restore(saved)
    run.run()
    assert [*map(str, told[count:])] == [*map(str, first)]
    assert any(isinstance(one, Pictured) for one in first)


VALUES = st.recursive(
    st.integers() | st.text() | st.lists(st.integers(), max_size=2),
    lambda inner: st.dictionaries(st.text(max_size=2), inner, max_size=3),
)
OBJECTS = st.dictionaries(st.text(max_size=2), VALUES, max_size=4)


@given(OBJECTS, OBJECTS)
def test_a_change_leads_from_one_object_to_the_next(
    before: dict[str, Any], after: dict[str, Any]
) -> None:
    assert pictures.changed(before, pictures.change(before, after)) == after
