"""Bug reports: a run in one file, to be repeated by somebody else.

The file has a JSON object in each line: the specification of the run with the versions
of rapc and Python; the files of the library, with their texts and digests; the acts of
the user, each with its moment; and the moment at which the report was written. A run is
a function of these. The file contains no code, and what is read is not trusted.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn, Union

import msgspec

from rapc.base.code_digest import digest_of_code
from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.values import number, readable
from rapc.base.version import VERSION
from rapc.base.writing import write_whole
from rapc.compiler.program import Program
from rapc.debug import act_lines
from rapc.debug.history import Done, History, Moment
from rapc.debug.recorded_lines import Count, Number
from rapc.errors import Error, LoadError, StateError, reason
from rapc.host import CheckError
from rapc.runtime.answers import RecordedWorld
from rapc.spec import RunSpec
from rapc.world import innermost

SUFFIX = ".bug"
"""The suffix of the files of bug reports."""

FORMAT = 1
"""The version of the format."""


class Versions(msgspec.Struct, frozen=True):
    """The versions of the code that ran the run."""

    rapc: str
    python: str
    #: The digest of the code of rapc and of the package of the world.
    code: str

    def __str__(self) -> str:
        return f"rapc {self.rapc} and Python {self.python}"


class _Line(msgspec.Struct, frozen=True, tag_field="line", forbid_unknown_fields=True):
    """A line of the file."""


class _Head(_Line, tag="bug", frozen=True):
    format: int
    versions: Versions
    spec: RunSpec


class _File(_Line, tag="file", frozen=True):
    file: str
    digest: str
    text: str


class _Act(_Line, tag="act", frozen=True):
    cycle: Count
    arrivals: Count
    time: Number
    #: The act as a JSON object (`rapc.debug.act_lines`).
    act: Any


class ReportMoment(_Line, tag="end", frozen=True):
    """The moment at which a report was written: the last line of the file."""

    cycle: Count
    arrivals: Count
    acts: Count
    time: Number
    #: The number of events of the run.
    events: Count
    #: The end reason of the run; empty before its end.
    reason: str

    @property
    def moment(self) -> Moment:
        """The moment in the form of a history."""
        return Moment(self.cycle, self.arrivals, self.acts)

    def __str__(self) -> str:
        text = f"cycle {self.cycle}, time {readable(number(self.time))}"
        text += f", {self.events} events"
        return f"{text}, run ended ({self.reason})" if self.reason else text


class _Format(msgspec.Struct, frozen=True):
    """The keys of the first line in every version of the format."""

    line: str
    format: int


class Bug(msgspec.Struct, frozen=True):
    """The content of a bug report."""

    versions: Versions
    spec: RunSpec
    library: Program
    acts: tuple[Done, ...]
    written_at: ReportMoment


def versions(history: History) -> Versions:
    """Return the versions of the code that runs a run."""
    world = type(innermost(history.run.port))
    return Versions(VERSION, platform.python_version(), digest_of_code(world))


def write_bug(history: History, path: Path) -> None:
    """Write a report of a run up to the present moment.

    Raises:
        StateError: for a playback, and in a world that cannot be saved: only this
            process knows its answers.
        WriteError: if the file cannot be written.
    """
    run = history.run
    if isinstance(run.port.behind, RecordedWorld):
        raise StateError(
            f"cannot report a run in the world `{run.port.name}`: the world cannot be "
            "saved, and nobody else can repeat its answers"
        )
    data = b"".join(msgspec.json.encode(line) + b"\n" for line in _lines(history))
    write_whole(path, data)


def _lines(history: History) -> Iterator[_Line]:
    assert history.first_library is not None
    yield _Head(FORMAT, versions(history), history.spec)
    for one in act_lines.library_in_text(history.first_library).files:
        yield _File(one.file, _digest(one.text), one.text)
    for done in history.branch.acts[: history.moment.acts]:
        act = act_lines.written(done.act)
        yield _Act(done.cycle, done.arrivals, done.time, act)
    yield present_moment(history)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


def present_moment(history: History) -> ReportMoment:
    """Return the present moment of a run, as in a report."""
    at = history.moment
    position = (at.cycle, at.arrivals, at.acts, history.now, history.serial)
    return ReportMoment(*position, history.reason)


# --- reading --------------------------------------------------------------------


def read_bug(path: Path) -> Bug:
    """Return the content of a bug report.

    Raises:
        LoadError: for a file that cannot be read or is damaged, a report of another
            format, and a library with errors.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise LoadError(f"cannot read `{path}`: {reason(error)}") from error
    texts = data.removesuffix(b"\n").split(b"\n")
    _check_format(path, texts[:1])
    lines = [_decoded(path, row, text) for row, text in enumerate(texts, 1)]
    head, *rest = lines
    count = sum(isinstance(one, _File) for one in rest)
    files, rows = rest[:count], rest[count:-1]
    end = rest[-1] if rest else None
    if not isinstance(end, ReportMoment):
        raise LoadError(f"`{path}` is cut off: it has no line `end`")
    if not isinstance(head, _Head) or any(not isinstance(one, _Act) for one in rows):
        _refuse(path, "its lines are out of order")
    acts = _acts(path, rows, count + 2, end)
    library = _library(path, files, head.spec)
    return Bug(head.versions, head.spec, library, acts, end)


def _check_format(path: Path, first: Sequence[bytes]) -> None:
    """Raise LoadError for another kind of file or another version of the format."""
    try:
        found = msgspec.json.decode(first[0] if first else b"", type=_Format)
    except UNREADABLE:
        found = None
    if found is None or found.line != "bug":
        raise LoadError(f"`{path}` is not a bug report of rapc")
    if found.format != FORMAT:
        raise LoadError(
            f"`{path}` was written by another version of rapc: format "
            f"{found.format}, not {FORMAT}"
        )


def _decoded(path: Path, row: int, text: bytes) -> Any:
    kinds = Union[_Head, _File, _Act, ReportMoment]  # noqa: UP007
    try:
        line = msgspec.json.decode(text, type=kinds)
        if isinstance(line, _Act):
            act = msgspec.convert(line.act, act_lines.line_types())
            line = msgspec.structs.replace(line, act=act)
    except UNREADABLE as error:
        _refuse(path, f"line {row}: {flaw(error)}")
    return line


def _acts(
    path: Path, rows: Sequence[_Act], first: int, end: ReportMoment
) -> tuple[Done, ...]:
    """Return the acts of the lines `rows`; the first of them is line `first`."""
    found: list[Done] = []
    for row, line in enumerate(rows, first):
        try:
            act = act_lines.read(line.act)
        except (Error, ValueError) as error:
            _refuse(path, f"line {row}: {error}")
        found.append(Done(line.cycle, line.arrivals, number(line.time), act))
    moments = [(one.cycle, one.arrivals) for one in found]
    if moments != sorted(moments) or moments[-1:] > [(end.cycle, end.arrivals)]:
        _refuse(path, "its acts are out of order")
    if len(found) != end.acts:
        _refuse(path, f"it has {len(found)} acts, not {end.acts}")
    return tuple(found)


def _library(path: Path, files: Sequence[_File], spec: RunSpec) -> Program:
    """Return the library of a report, after a check of all digests."""
    for one in files:
        if _digest(one.text) != one.digest:
            _refuse(path, f"the digest of `{one.file}` is different")
    named = tuple([act_lines.File(one.file, one.text) for one in files])
    if len({one.file for one in named}) != len(named):
        _refuse(path, "two of its files have one name")
    try:
        library = act_lines.read_library(act_lines.Library(spec.library, named))
    except CheckError as error:
        message = error.report.findings[0].diagnostic.message
        raise LoadError(f"the library in `{path}` has errors: {message}") from error
    if library.digest != spec.digest:
        _refuse(path, "the digest of its library is different")
    return library


def _refuse(path: Path, why: str) -> NoReturn:
    raise LoadError(f"`{path}` is not a bug report: {why}")
