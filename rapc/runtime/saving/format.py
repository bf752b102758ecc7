"""A saved run as bytes: one line that says what it is, then the records as JSON.

The line is `rapc-run`, the version of the format and the checksum of what follows.
JSON keeps whole numbers of any size.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache

import msgspec

from rapc.errors import StateError
from rapc.runtime.saving.records import RunRecord

FORMAT = 4
"""The version of the format; a change of the records or of the IR is one of it."""

_HEAD = re.compile(rb"rapc-run (\d{1,9}) ([0-9a-f]{64})\n")

_encode = msgspec.json.Encoder().encode


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
