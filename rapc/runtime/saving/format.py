"""A saved run as bytes: one line that says what it is, then the records as JSON.

The line is `rapc-run`, the version of the format and the checksum of what follows.
JSON keeps whole numbers of any size.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias

import msgspec

from rapc.base.chance import Stream
from rapc.base.values import Atom, Fact, Number
from rapc.errors import StateError
from rapc.ir.nodes import Method
from rapc.runtime.fields import Natural
from rapc.runtime.memory.saving import MemoryState
from rapc.runtime.saving.codecs import Saved, fields_of
from rapc.runtime.settings import Settings
from rapc.runtime.state import agenda, run_state, task, things
from rapc.world import Time

FORMAT = 5
"""The version of the format; a change of the fields of states or of the IR is one."""

_HEAD = re.compile(rb"rapc-run (\d{1,9}) ([0-9a-f]{64})\n")

_encode = msgspec.json.Encoder().encode

if TYPE_CHECKING:
    TaskRecord: TypeAlias = Any
    StateRecord: TypeAlias = Any
    AgendaRecord: TypeAlias = Any
    ThingsRecord: TypeAlias = Any
else:
    TaskRecord = fields_of(task.Task).saved
    StateRecord = fields_of(run_state.RunState).saved
    AgendaRecord = fields_of(agenda.Agenda).saved
    ThingsRecord = fields_of(things.Things).saved


class RunRecord(msgspec.Struct, frozen=True):
    """A whole run."""

    #: The digest of the library's sources.
    library: str
    #: What the world is called.
    world_name: str
    #: The options that the world was made with, if that is known.
    options: dict[str, str | int | float | bool]
    settings: Settings
    seed: int
    #: The state of the interpreter's random stream.
    random: Stream
    #: How far the recorder has come.
    time: Time
    cycle: Natural
    serial: Natural
    #: The methods that solvers have added, in order, each with its RAP.
    added_methods: tuple[tuple[str, Method], ...]
    #: What `Writer` has gathered.
    resources: tuple[Number | tuple[Atom, ...], ...]
    environments: tuple[dict[str, Saved], ...]
    #: The tasks of the host, then the steps of the methods of these, and so on; of a
    #: step that has ended the RAP and the number.
    tasks: tuple[TaskRecord | tuple[str, int], ...]
    state: StateRecord
    agenda: AgendaRecord
    things: ThingsRecord
    #: The tasks whose monitors are to be tested, by number.
    to_test: tuple[int, ...]
    #: The deadlines that were missed and not yet told of, by the number of the task.
    missed: tuple[tuple[int, tuple[Time, ...]], ...]
    tested_at: Time
    #: The facts that the methods of tasks note, by the number of the task.
    notations: tuple[tuple[int, tuple[Fact, ...]], ...]
    memory: MemoryState
    #: What the world says of itself.
    world: bytes


@cache
def _decoder() -> msgspec.json.Decoder[RunRecord]:
    """Return what decodes a run; making it takes longer than most decodings."""
    return msgspec.json.Decoder(RunRecord)


def encode_run(record: RunRecord) -> bytes:
    """Return a run as bytes; the same records give the same bytes."""
    return sealed(_encode(record))


def sealed(body: bytes) -> bytes:
    """Return the records of a run behind the line that says what they are."""
    checksum = hashlib.sha256(body).hexdigest()
    return f"rapc-run {FORMAT} {checksum}\n".encode() + body


def decode_run(saved: bytes) -> RunRecord:
    """Return the records of a saved run.

    Raises:
        StateError: for bytes that are no saved run, a damaged one, or one of another
            version of the format.
    """
    head = _HEAD.match(saved)
    if head is None:
        raise StateError("this is no saved run")
    if int(head[1]) != FORMAT:
        raise StateError(
            f"this run was saved in format {int(head[1])}; "
            f"this version of rapc takes up format {FORMAT}"
        )
    body = memoryview(saved)[head.end() :]
    if hashlib.sha256(body).hexdigest() != head[2].decode():
        raise StateError("the saved run is damaged")
    try:
        return _decoder().decode(body)
    except (msgspec.MsgspecError, RecursionError) as error:
        raise not_a_run(error) from error


def not_a_run(error: Exception) -> StateError:
    """Return the error for a saved run that says what no run can have left."""
    return StateError(f"the saved run holds what no run leaves: {error}")
