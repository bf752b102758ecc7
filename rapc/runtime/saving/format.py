"""The format of a saved run: a header line, then the records as JSON.

The line contains `rapc-run`, the version of the format and the checksum of the rest.
JSON keeps whole numbers of any size.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

import msgspec

from rapc.base.chance import Stream
from rapc.base.decoding import UNREADABLE
from rapc.base.values import Atom, Number
from rapc.errors import StateError
from rapc.ir.nodes import Method
from rapc.runtime.fields import Natural
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.saving.codecs import Saved, fields_of
from rapc.runtime.settings import Settings
from rapc.runtime.state import agenda, run_state, task, things
from rapc.world import Time

FORMAT = 17
"""The version of the format; changes of the state's fields or of the IR change it."""

_HEAD = re.compile(rb"rapc-run (\d{1,9}) ([0-9a-f]{64})\n")

_encode = msgspec.json.Encoder().encode

if TYPE_CHECKING:
    TaskRecord: TypeAlias = Any
    StateRecord: TypeAlias = Any
    AgendaRecord: TypeAlias = Any
    ThingsRecord: TypeAlias = Any
    MemoryRecord: TypeAlias = Any
else:
    TaskRecord = fields_of(task.Task).saved
    StateRecord = fields_of(run_state.RunState).saved
    AgendaRecord = fields_of(agenda.Agenda).saved
    ThingsRecord = fields_of(things.Things).saved
    MemoryRecord = fields_of(MemoryAccess).saved


class RunRecord(msgspec.Struct, frozen=True):
    """The records of a whole run."""

    #: The digest of the library's sources.
    library: str
    #: The name of the world.
    world_name: str
    #: The options of the world, if known.
    options: dict[str, str | int | float | bool]
    settings: Settings
    seed: int
    #: The state of the interpreter's random stream.
    random: Stream
    #: The position of the recorder.
    time: Time
    cycle: Natural
    serial: Natural
    #: The methods that solvers have added, in order, each with its RAP.
    added_methods: tuple[tuple[str, Method], ...]
    #: The shared values from `Writer`.
    resources: tuple[Number | tuple[Atom, ...], ...]
    environments: tuple[dict[str, Saved], ...]
    #: The tasks of the host, then the steps of their methods, and so on; for an ended
    #: step the RAP and the number.
    tasks: tuple[TaskRecord | tuple[str, int], ...]
    state: StateRecord
    agenda: AgendaRecord
    things: ThingsRecord
    #: The tasks whose monitors are to be tested, by number.
    to_test: tuple[int, ...]
    #: The missed deadlines without an event so far, by task number.
    missed: tuple[tuple[int, tuple[Time, ...]], ...]
    tested_at: Time
    memory: MemoryRecord
    #: The state that the world has saved.
    world: bytes


@cache
def _decoder() -> msgspec.json.Decoder[RunRecord]:
    """Return the decoder of a run, cached: making it is slower than most decodings."""
    return msgspec.json.Decoder(RunRecord)


def encode_run(record: RunRecord) -> bytes:
    """Return a run as bytes; the same records give the same bytes."""
    return sealed(_encode(record))


def sealed(body: bytes) -> bytes:
    """Return the records of a run with the header line."""
    checksum = hashlib.sha256(body).hexdigest()
    return f"rapc-run {FORMAT} {checksum}\n".encode() + body


def decode_run(saved: bytes) -> RunRecord:
    """Return the records of a saved run.

    Raises:
        StateError: for bytes that are no saved run, a damaged run, or a run of another
            version of the format.
    """
    head = _HEAD.match(saved)
    if head is None:
        raise StateError("this is not a saved run")
    if int(head[1]) != FORMAT:
        raise StateError(
            f"this run was saved in format {int(head[1])}; "
            f"this version of rapc reads format {FORMAT}"
        )
    body = memoryview(saved)[head.end() :]
    if hashlib.sha256(body).hexdigest() != head[2].decode():
        raise StateError("the saved run is damaged")
    try:
        return _decoder().decode(body)
    except UNREADABLE as error:
        raise not_a_run(error) from error


def not_a_run(error: Exception) -> StateError:
    """Return the error for a saved run that no run can have left."""
    return StateError(f"the saved run is invalid: {error}")
