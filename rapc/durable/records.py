"""The records of a journal, and their bytes.

A record is its length and its checksum (CRC-32), 4 bytes each, and a JSON array: the
kind of record, then the fields. What is read is not trusted: all values are checked.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Union

import msgspec

from rapc.base.messages import Resumed
from rapc.base.values import Atom, Fact
from rapc.ir.nodes import Method
from rapc.runtime.fields import Natural
from rapc.runtime.planner import Planned
from rapc.world import NOT_KNOWN, Message, Picture, Refused, Reply, Time

_HEAD = struct.Struct("<II")

MOST = 1 << 30
"""The highest length of a record, in bytes."""

_BEGINNING = b'["'
"""The first bytes of each body."""


class Record(
    msgspec.Struct, frozen=True, array_like=True, tag_field="kind", kw_only=False
):
    """A record of a journal."""


class Requested(Record, tag="ask", frozen=True):
    """A request, before the world receives the request."""

    readings: Natural
    call: str
    asked: Any


class Answered(Record, tag="told", frozen=True):
    """An answer of the world, before its use."""

    readings: Natural
    call: str
    asked: Any
    told: Any


class Solved(Record, tag="solved", frozen=True):
    """The methods that a solver has returned, or the answer of the planner."""

    cycle: Natural
    rap: str
    methods: tuple[Method, ...]
    planned: Planned | None = None


class Acted(Record, tag="act", frozen=True):
    """An act of the host, before the act is performed."""

    readings: Natural
    cycle: Natural
    arrivals: Natural
    time: Time
    #: The act as an object (`rapc.debug.act_lines`).
    act: Any


class ActFailed(Record, tag="void", frozen=True):
    """The failure of the preceding act, which changed nothing."""


class Reached(Record, tag="at", frozen=True):
    """A cycle that the run has reached."""

    readings: Natural
    cycle: Natural
    time: Time


class Ended(Record, tag="end", frozen=True):
    """The end of the run."""

    readings: Natural
    cycle: Natural
    time: Time
    reason: str


_KINDS: Any = Union[Requested, Answered, Solved, Acted, ActFailed, Reached, Ended]  # noqa: UP007
_encode = msgspec.json.Encoder().encode
_decode = msgspec.json.Decoder(_KINDS).decode


class Call(NamedTuple):
    """The types of the arguments and of the answer of a method of a world."""

    asked: Any
    told: Any


_NOTHING = tuple[()]

CALLS: Mapping[str, Call] = {
    "facts": Call(_NOTHING, tuple[Fact, ...]),
    "now": Call(_NOTHING, Time),
    "perform": Call(tuple[int, Fact], Reply),
    "cancel": Call(tuple[int], None),
    "next_time": Call(_NOTHING, Time | None),
    "advance": Call(tuple[Time], None),
    "messages": Call(_NOTHING, tuple[Message | Resumed, ...]),
    "ended": Call(_NOTHING, str | None),
    "picture": Call(_NOTHING, Picture),
    "activate": Call(tuple[int, tuple[Fact, ...], tuple[str, ...]], Refused),
    "deactivate": Call(tuple[int], None),
    "usual_time": Call(tuple[Fact], Time),
    "adjust": Call(tuple[str, Atom | bool], None),
}
"""The methods of a world whose answers are kept."""

_NOT_KNOWN = "not-known"
"""The form of `NOT_KNOWN`, which JSON does not have."""


def framed(record: Record) -> bytes:
    """Return the bytes of a record.

    Raises:
        TypeError: for a value that is no answer of a world.
    """
    if isinstance(record, Answered) and record.told == NOT_KNOWN:
        record = msgspec.structs.replace(record, told=_NOT_KNOWN)
    body = _encode(record)
    return _HEAD.pack(len(body), zlib.crc32(body)) + body


def decoded(body: bytes) -> Record:
    """Return the record of a body.

    Raises:
        UNREADABLE: if `body` is not a record.
    """
    record: Record = _decode(body)
    if isinstance(record, Requested | Answered):
        call = CALLS.get(record.call)
        if call is None:
            raise msgspec.DecodeError(f"unknown method `{record.call:.60}`")
        asked = msgspec.convert(record.asked, call.asked)
        record = msgspec.structs.replace(record, asked=asked)
    if isinstance(record, Answered):
        told = _answer(record.call, record.told)
        record = msgspec.structs.replace(record, told=told)
    return record


def _answer(call: str, told: Any) -> Any:
    if call == "next_time" and told == _NOT_KNOWN:
        return NOT_KNOWN
    if call in ("perform", "activate"):
        if told is None:
            return None
        if isinstance(told, dict) and "result" not in told:
            return msgspec.convert(told, Refused)
    return msgspec.convert(told, CALLS[call].told)


class Bodies(NamedTuple):
    """The bodies of the records in some bytes."""

    found: Sequence[bytes]
    #: The offset after the last whole record.
    end: int


def bodies(data: bytes, at: int) -> Bodies:
    """Return the bodies of the records from an offset on, up to one that is damaged."""
    found = []
    while at + _HEAD.size <= len(data):
        length, checksum = _HEAD.unpack_from(data, at)
        start, end = at + _HEAD.size, at + _HEAD.size + length
        if length > MOST or end > len(data):
            break
        body = data[start:end]
        if zlib.crc32(body) != checksum:
            break
        found.append(body)
        at = end
    return Bodies(found, at)


def whole_record_after(data: bytes, at: int) -> bool:
    """Return whether any whole record follows the damaged one at an offset."""
    start = at + _HEAD.size
    while (start := data.find(_BEGINNING, start + 1)) >= 0:
        if bodies(data, start - _HEAD.size).found:
            return True
    return False


def size_of(body: bytes) -> int:
    """Return the size of a record with its length and checksum."""
    return _HEAD.size + len(body)
