"""Decode lines of a trace into events with values.

A trace contains text in place of the values of a run. The debugger parses goals, facts
and requests, as far as search and output need the values.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache, lru_cache
from typing import Annotated, Any, Union

import msgspec
from msgspec.json import Decoder

from rapc.base.values import Atom, Fact, number
from rapc.debug.log import ToldEvent
from rapc.errors import TextError
from rapc.events import Event, Goal, ResourceChange, TaskResult, kinds
from rapc.parser.parse import parse_fact

Int = Annotated[int, msgspec.Meta(ge=-(2**63), le=2**63 - 1)]
Count = Annotated[int, msgspec.Meta(ge=0, le=2**63 - 1)]
Number = Int | Annotated[float, msgspec.Meta(ge=-1e300, le=1e300)]
"""Numbers that Python can write and add without overflow."""

# --- the types of lines ---------------------------------------------------------------

_WRITTEN: Mapping[Any, Any] = {
    Goal: str,
    Fact: str,
    ResourceChange: str,
    Atom: str,
    str | Fact: str,
    tuple[Fact, ...]: tuple[str, ...],
    Mapping[str, Any]: dict[str, str],
    int: Int,
    int | None: Int | None,
    int | float: Number,
    int | float | None: Number | None,
    tuple[int, ...]: tuple[Int, ...],
}
"""The types of values in a trace, by the types of the fields of events."""


def _line_type(kind: type[msgspec.Struct]) -> type[msgspec.Struct]:
    """Return the type of the lines of an event, or of a part of an event."""
    fields = []
    for field in msgspec.structs.fields(kind):
        written = _WRITTEN.get(field.type, field.type)
        if field.type == tuple[TaskResult, ...]:
            written = tuple[_line_type(TaskResult), ...]  # type: ignore[misc]
        default = {} if field.required else {"default": field.default}
        made = msgspec.field(name=field.encode_name, **default)
        fields.append((field.name, written, made))
    config = kind.__struct_config__
    return msgspec.defstruct(
        f"{kind.__name__}Line",
        fields,
        tag=config.tag,
        tag_field=config.tag_field,
        kw_only=True,
    )


@cache
def event_lines() -> Decoder[Any]:
    """Return the decoder for the lines of all events."""
    lines = tuple(_line_type(kind) for kind in kinds().values())
    return Decoder(Union[lines])  # noqa: UP007  # no other form builds a union at run time


Read = Callable[[Any], Any]
"""The type of functions that parse a text of a trace."""

# --- words into values ----------------------------------------------------------------


def as_told(row: int, line: Any) -> ToldEvent:
    """Return an event of a trace in the raw form that a run emits."""
    kind = kinds()[line.__struct_config__.tag]
    return ToldEvent(kind, row, line.cycle, number(line.time), _values(kind, line))


def _values(kind: type[msgspec.Struct], line: Any) -> dict[str, Any]:
    """Return the values of an event, or of a part of an event, by field."""
    found = {}
    for name, read in _readers(kind):
        value = getattr(line, name)
        found[name] = value if read is None else read(value)
    return found


@cache
def _readers(kind: type[msgspec.Struct]) -> Sequence[tuple[str, Read | None]]:
    """Return the specific fields of an event, each with its parser."""
    fields = msgspec.structs.fields(kind)
    own = [one for one in fields if one.name not in Event.__struct_fields__]
    return [(one.name, _READ.get(one.type)) for one in own]


_WORD = re.compile(r'"(?:[^"\\]|\\.)*"|[^\s()"]*\([^()]*\)|[^\s()"]+')

_REMEMBERED = 4096
"""The number of parsed texts in the cache; a trace repeats many texts."""


def _words(text: str) -> tuple[str, ...]:
    """Return the words of a list; the original values are unknown."""
    return tuple(_WORD.findall(text[1:-1]))


@lru_cache(_REMEMBERED)
def _fact(text: str) -> Fact:
    """Return a fact, request or signal; return words if the text is invalid."""
    try:
        return parse_fact(text)
    except TextError:
        return _words(text) or ("",)


def _facts(texts: tuple[str, ...]) -> tuple[Fact, ...]:
    return tuple(map(_fact, texts))


@lru_cache(_REMEMBERED)
def _goal(text: str) -> Goal:
    words = _words(text) or ("",)
    at = words.index("=>") if "=>" in words else len(words)
    goal = Goal(words[0], words[1:at], words[at + 1 :])
    goal.text = text
    return goal


def _results(lines: tuple[Any, ...]) -> tuple[TaskResult, ...]:
    return tuple([TaskResult(**_values(TaskResult, line)) for line in lines])


def _result_or_signal(text: str) -> str | Fact:
    return _fact(text) if text.startswith("(") else text


_READ: Mapping[Any, Read] = {
    Goal: _goal,
    Fact: _fact,
    tuple[Fact, ...]: _facts,
    str | Fact: _result_or_signal,
    tuple[TaskResult, ...]: _results,
}
"""The parsers of values by the types of fields; resource changes stay text."""
