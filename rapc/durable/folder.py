"""The folder of a journal: its files, the lock, and what can be read from them.

    meta           the specification of the run, its library and versions
    journal-000001 the records from the beginning, and so on
    snapshot-000002 the state of the run at the beginning of journal-000002
    lock           locked by the process that runs the run

A part of the journal begins with each snapshot. A snapshot replaces all preceding
parts, and parts may be missing at the front. The last record of the last part may be
incomplete: it is cut off.
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.writing import remove_parts, write_whole
from rapc.debug.act_lines import Library
from rapc.durable.records import Record, bodies, decoded, size_of, whole_record_after
from rapc.errors import LoadError, StateError, WriteError, reason
from rapc.runtime.fields import Natural
from rapc.spec import RunSpec
from rapc.world import Time

FORMAT = 1
"""The version of the format of journals."""

META = "meta"
LOCK = "lock"
_NAME = re.compile(r"(journal|snapshot)-(\d{6,9})")
_PART_HEAD = b"rapc-journal 1\n"
_HEAD = re.compile(rb"rapc-(meta|snapshot) (\d{1,9}) ([0-9a-f]{64})\n")

_LOOK = 0.02
"""The time in seconds after which the lock is tried again."""


class Options(msgspec.Struct, frozen=True):
    """The options of a journal."""

    #: When to wait for the disk: `always`, `requests` or `off`.
    sync: str = "requests"
    #: The limit of its size, in megabytes.
    limit: int = 256
    #: The treatment of requests under way after a crash, by primitive or `*`.
    after_crash: dict[str, str] = {}


class KeptEngine(msgspec.Struct, frozen=True):
    """The planner of a run that is not part of rapc: the arguments of `rapc.engine`."""

    name: str
    #: None for an engine of the host's own, which `rapc.engine` does not make.
    timeout: float | None = None
    costs: bool = True


class Meta(msgspec.Struct, frozen=True):
    """All that is known of a run before its first record."""

    #: The version of rapc that began the run.
    rapc: str
    spec: RunSpec
    library: Library
    #: The time of the world's clock when the run was made.
    begun: Time
    #: The file of the trace, or an empty text.
    trace: str
    options: Options
    #: None for the planner of rapc.
    engine: KeptEngine | None = None


class Snapshot(msgspec.Struct, frozen=True):
    """The state of a run at the beginning of a part of its journal."""

    number: Natural
    #: The moment of the run.
    cycle: Natural
    arrivals: Natural
    time: Time
    #: The number of answers before the snapshot.
    answers: Natural
    #: The size of the trace in bytes; None without a trace.
    trace: Natural | None
    #: The library of the run, if an act has replaced the first library.
    library: Library | None
    #: The state of the run; see `Interpreter.save`.
    run: bytes
    #: The states of the reports on the run.
    reports: tuple[bytes, ...]


class Part(msgspec.Struct, frozen=True):
    """A part of a journal."""

    number: int
    records: tuple[Record, ...]
    #: The offset after the last whole record, and the size of the file.
    end: int
    size: int


class Stored(msgspec.Struct, frozen=True):
    """The contents of a journal from a snapshot or from the beginning on."""

    folder: Path
    meta: Meta
    snapshot: Snapshot | None
    parts: tuple[Part, ...]
    #: The first damage, for which the contents have another beginning; or None.
    damage: LoadError | None

    @property
    def records(self) -> Iterator[Record]:
        """Yield the records of all parts."""
        for part in self.parts:
            yield from part.records

    @property
    def first_cycle(self) -> int:
        """Return the cycle at which the contents begin."""
        return 0 if self.snapshot is None else self.snapshot.cycle

    @property
    def last(self) -> Part:
        """Return the last part."""
        return self.parts[-1]


def is_journal(path: Path) -> bool:
    """Return whether a path is the folder of a journal, with or without its meta."""
    try:
        names = _names(path)
    except LoadError:
        return False
    return META in names or any(map(_NAME.fullmatch, names))


def _names(folder: Path) -> list[str]:
    """Return the names of the files in a folder. Raises LoadError."""
    try:
        return sorted(os.listdir(folder))
    except OSError as error:
        raise LoadError(f"cannot read `{folder}`: {reason(error)}") from error


def part_file(folder: Path, number: int) -> Path:
    """Return the file of a part."""
    return folder / f"journal-{number:06}"


def snapshot_file(folder: Path, number: int) -> Path:
    """Return the file of the snapshot at the beginning of a part."""
    return folder / f"snapshot-{number:06}"


def create(folder: Path, meta: Meta) -> None:
    """Create the folder of a new journal.

    Raises:
        WriteError: if the folder has files, or cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(one.name != LOCK for one in folder.iterdir()):
            raise WriteError(
                f"cannot begin a journal in `{folder}`: the folder is not empty",
                "continue a journal with `rapc run --resume`",
            )
    except OSError as error:
        raise WriteError(f"cannot write `{folder}`: {reason(error)}") from error
    write_meta(folder, meta)


def write_meta(folder: Path, meta: Meta) -> None:
    """Write the file `meta`. Raises WriteError."""
    write_whole(folder / META, _sealed("meta", meta))


def write_snapshot(folder: Path, snapshot: Snapshot) -> None:
    """Write a snapshot, whole or not at all. Raises WriteError."""
    data = _sealed("snapshot", snapshot)
    write_whole(snapshot_file(folder, snapshot.number), data)


def _sealed(kind: str, contents: msgspec.Struct) -> bytes:
    body = msgspec.json.encode(contents)
    checksum = hashlib.sha256(body).hexdigest()
    return f"rapc-{kind} {FORMAT} {checksum}\n".encode() + body


def _unsealed(kind: str, type_: Any, path: Path) -> Any:
    """Return the contents of a sealed file.

    Raises:
        LoadError: if the file cannot be read, is damaged, or has another format.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise LoadError(f"cannot read `{path}`: {reason(error)}") from error
    head = _HEAD.match(data)
    if head is None or head[1].decode() != kind:
        raise LoadError(f"`{path}` is not the {kind} of a journal, or is damaged")
    if int(head[2]) != FORMAT:
        raise LoadError(
            f"`{path}` was written by another version of rapc: format "
            f"{int(head[2])}, not {FORMAT}"
        )
    body = data[head.end() :]
    if hashlib.sha256(body).hexdigest() != head[3].decode():
        raise LoadError(f"`{path}` is damaged")
    try:
        return msgspec.json.decode(body, type=type_)
    except UNREADABLE as error:
        raise LoadError(f"`{path}` is damaged: {flaw(error)}") from error


def read_meta(folder: Path) -> Meta:
    """Return the contents of the file `meta`. Raises LoadError."""
    names = _names(folder) if folder.is_dir() else []
    if META not in names:
        lost = f"the journal `{folder}` has no file `{META}`"
        raise LoadError(lost if is_journal(folder) else f"`{folder}` is not a journal")
    meta: Meta = _unsealed("meta", Meta, folder / META)
    return meta


def numbers(folder: Path) -> tuple[list[int], list[int]]:
    """Return the numbers of the parts and of the snapshots. Raises LoadError."""
    found: dict[str, list[int]] = {"journal": [], "snapshot": []}
    for name in _names(folder):
        if named := _NAME.fullmatch(name):
            found[named[1]].append(int(named[2]))
    return found["journal"], found["snapshot"]


def read(folder: Path, *, whole: bool = False) -> Stored:
    """Return the contents of a journal from the last snapshot on.

    Args:
        folder: the folder.
        whole: whether to return all that the folder has: from the beginning or, if
            parts are missing, from the first snapshot with all later parts.

    Raises:
        LoadError: if the folder cannot be read or is not a journal; if a part between
            two others is missing or damaged.
    """
    meta = read_meta(folder)
    parts, snapshots = numbers(folder)
    last = max((*parts, *snapshots), default=1)
    beginnings = [*snapshots] if snapshots and 1 not in parts else [1, *snapshots]
    damage = None
    for number in beginnings if whole else reversed(beginnings):
        try:
            snapshot = None if number == 1 else read_snapshot(folder, number)
            found = tuple(
                read_part(folder, one, is_last=one == last)
                for one in range(number, last + 1)
            )
            return Stored(folder, meta, snapshot, found, damage)
        except LoadError as error:
            damage = damage or error
    assert damage is not None
    raise damage


def read_snapshot(folder: Path, number: int) -> Snapshot:
    """Return a snapshot. Raises LoadError."""
    path = snapshot_file(folder, number)
    snapshot: Snapshot = _unsealed("snapshot", Snapshot, path)
    if snapshot.number != number:
        raise LoadError(f"`{path}` is damaged")
    return snapshot


def damaged_snapshots(folder: Path) -> Iterator[LoadError]:
    """Yield the error of each snapshot that cannot be read."""
    for number in numbers(folder)[1]:
        try:
            read_snapshot(folder, number)
        except LoadError as error:
            yield error


def read_part(folder: Path, number: int, *, is_last: bool, start: int = 0) -> Part:
    """Return a part of a journal.

    Args:
        folder: the folder.
        number: the number of the part.
        is_last: whether the part may be missing or end within a record.
        start: the offset at which to begin; 0 for the beginning.

    Raises:
        LoadError: if the part cannot be read or is damaged.
    """
    path = part_file(folder, number)
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        if is_last:
            return Part(number, (), 0, 0)
        raise LoadError(f"`{path}` is missing") from None
    except OSError as error:
        raise LoadError(f"cannot read `{path}`: {reason(error)}") from error
    if not data.startswith(_PART_HEAD):
        if is_last and _PART_HEAD.startswith(data):
            return Part(number, (), 0, len(data))
        raise LoadError(f"`{path}` is not a part of a journal of this version of rapc")
    found, end = bodies(data, start or len(_PART_HEAD))
    if end < len(data) and (not is_last or whole_record_after(data, end)):
        raise LoadError(
            f"`{path}` is damaged at byte {end}",
            "go back to a snapshot with `rapc journal cut`",
        )
    records: list[Record] = []
    for body in found:
        try:
            records.append(decoded(body))
        except UNREADABLE as error:
            if is_last and len(records) + 1 == len(found):
                end -= size_of(body)  # an invalid answer, which has ended the run
                break
            raise LoadError(f"`{path}` is damaged: {flaw(error)}") from error
    return Part(number, tuple(records), end, len(data))


class Writer:
    """A writer of the last part of a journal.

    Args:
        folder: the folder.
        number: the number of the part.
        end: the offset of the first new record; what follows is cut off.

    Raises:
        WriteError: if the file cannot be written.
    """

    def __init__(self, folder: Path, number: int, end: int = 0) -> None:
        self.path = part_file(folder, number)
        self.number = number
        try:
            self._file = os.open(self.path, os.O_WRONLY | os.O_CREAT, 0o666)
            os.ftruncate(self._file, end)
            os.lseek(self._file, end, os.SEEK_SET)
        except OSError as error:
            raise self._wrong(error) from error
        #: The offset after the last record.
        self.end = end
        if not end:
            self.write(_PART_HEAD)

    def write(self, data: bytes) -> None:
        """Append bytes, all or none. Raises WriteError."""
        written = 0
        try:
            while written < len(data):
                written += os.write(self._file, data[written:])
        except OSError as error:
            os.ftruncate(self._file, self.end)
            os.lseek(self._file, self.end, os.SEEK_SET)
            raise self._wrong(error) from error
        self.end += len(data)

    def sync(self) -> None:
        """Wait until the disk has all records. Raises WriteError."""
        try:
            os.fdatasync(self._file)
        except OSError as error:
            raise self._wrong(error) from error

    def close(self) -> None:
        """Close the file."""
        os.close(self._file)

    def _wrong(self, error: OSError) -> WriteError:
        return WriteError(f"cannot write the journal `{self.path}`: {reason(error)}")


class Lock:
    """The lock of a journal, held until the process ends or `release` is called.

    Raises:
        StateError: if another process has the lock.
        WriteError: if the file cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = os.open(folder / LOCK, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            raise WriteError(f"cannot write `{folder}`: {reason(error)}") from error
        for wait in (_LOOK, 0):
            try:
                fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except OSError as error:
                if wait:  # `is_running` has the lock for a moment
                    time.sleep(wait)
                    continue
                os.close(self._file)
                raise StateError(
                    f"cannot run the journal `{folder}`: another process runs it"
                ) from error
        remove_parts([folder / LOCK])  # of killed processes

    def release(self) -> None:
        """Release the lock."""
        os.close(self._file)


def is_running(folder: Path) -> bool:
    """Return whether a process runs the run of a journal."""
    try:
        file = os.open(folder / LOCK, os.O_RDWR)
    except OSError:
        return False
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(file)
    return False
