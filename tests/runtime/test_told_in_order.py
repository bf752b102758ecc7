"""A trace writes the keys of an event as they are told: so all tell them in order."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from io import StringIO
from pathlib import Path

import msgspec
import pytest

import rapc
from rapc import events
from rapc.base.values import Fact
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.memory import access
from rapc.runtime.memory.recognition import item_events

PACKAGE = Path(rapc.__file__).parent
COMMON = len(events.Event.__struct_fields__)

OF_SEVERAL: dict[tuple[str, str], list[type[events.Event]]] = {
    (access.__name__, "kind"): [events.ItemMoved, events.ItemLost],
    (item_events.__name__, "kind"): [events.ItemIntroduced, events.ItemMerged],
    ("rapc.runtime.monitors.monitors", "kind"): [events.TaskBlocked, events.TaskWoken],
}
"""What is meant where the kind of an event is no name of one, by the module."""


def _told() -> Iterator[tuple[str, str, list[str]]]:
    """The module, the kind and the keys of each call that tells of an event."""
    for file in sorted(PACKAGE.rglob("*.py")):
        if "runtime" not in file.relative_to(PACKAGE).parts:
            continue
        module = ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts)
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Attribute)
                and node.func.attr == "emit"
                and "recorder" in ast.unparse(node.func.value)
            ):
                keys = [str(key.arg) for key in node.keywords]
                yield module, ast.unparse(node.args[0]).split(".")[-1], keys


CALLS = list(_told())


@pytest.mark.parametrize(("module", "name", "keys"), CALLS)
def test_keys_are_told_in_the_order_of_the_fields(
    module: str, name: str, keys: list[str]
) -> None:
    known = getattr(events, name, None)
    for kind in OF_SEVERAL[module, name] if known is None else [known]:
        fields = list(kind.__struct_fields__[COMMON:])
        assert keys == [field for field in fields if field in keys]
        required = {one.name for one in msgspec.structs.fields(kind) if one.required}
        assert required - set(events.Event.__struct_fields__) <= set(keys)


def test_calls_of_all_kinds_are_looked_at() -> None:
    told = {name for _, name, _ in CALLS if name != "kind"}
    told |= {kind.__name__ for kinds in OF_SEVERAL.values() for kind in kinds}
    kinds = inspect.getmembers(events, inspect.isclass)
    every = {
        name
        for name, kind in kinds
        if issubclass(kind, events.Event) and not kind.__subclasses__()
    }
    assert told == every


def _line(event: events.Event) -> str:
    stream = StringIO()
    JsonTrace(stream)(event)
    return stream.getvalue()


FACT: Fact = ("at", "hall", 3)


@pytest.mark.parametrize(
    ("event", "line"),
    [
        (
            events.TaskBlocked(n=1, cycle=2, time=2.5, task=3, on="(x)"),
            '{"event":"task-blocked","n":1,"cycle":2,"time":2.5,"task":3,"on":"(x)"}\n',
        ),
        (
            events.TaskBlocked(n=1, cycle=2, time=3, task=3, on="arm", holder=9),
            '{"event":"task-blocked","n":1,"cycle":2,"time":3,'
            '"task":3,"on":"arm","holder":9}\n',
        ),
        (
            events.FamilySwitched(n=0, cycle=1, time=0, task=3, from_=1, to=2),
            '{"event":"family-switched","n":0,"cycle":1,"time":0,'
            '"task":3,"from":1,"to":2}\n',
        ),
        (
            events.PrimitiveRequested(
                n=0, cycle=1, time=0, task=3, request=FACT, sent=FACT
            ),
            '{"event":"primitive-requested","n":0,"cycle":1,"time":0,'
            '"task":3,"request":"(at hall 3)","sent":"(at hall 3)"}\n',
        ),
        (
            events.RunEnded(
                n=0, cycle=1, time=0, reason="done", results=(), waiting=()
            ),
            '{"event":"run-ended","n":0,"cycle":1,"time":0,"reason":"done",'
            '"because":null,"results":[],"waiting":[]}\n',
        ),
    ],
)
def test_a_line_has_all_keys_of_its_kind_by_their_names(
    event: events.Event, line: str
) -> None:
    assert _line(event) == line
