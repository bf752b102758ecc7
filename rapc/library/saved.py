"""Compiled libraries as bytes: one versioned file in place of many sources.

The first line is `rapc-library`, the format, the version of rapc and the checksum. The
rest is JSON: each source with its name, its text and the IR of its forms, and the
sources of the library and of the libraries of its tests. The file has no code: queries
are compiled from the IR at their first use, as for sources.

The content of a file is not trusted. Declarations are validated when the file is read.
A RAP is validated at its first use, which keeps reading fast.
Not here: reading the files (`rapc.host`), and writing the files (`rapc compile`).
"""

from __future__ import annotations

import hashlib
import re
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import msgspec

from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.files import COMPILED
from rapc.base.limits import MAX_REASON
from rapc.base.source import SourceFile
from rapc.base.version import VERSION
from rapc.errors import SavedError
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library.lazy import Lazy
from rapc.library.library import Library, link, own_methods, with_methods
from rapc.library.saved_check import UnsoundError, Verifier
from rapc.library.signatures import Signatures
from rapc.parser.unit import SourceUnit

FORMAT = 14
"""The version of the format; each change of the IR changes the format."""

_HEAD = re.compile(rb"rapc-library (\d{1,9}) ([!-~]{1,40}) ([0-9a-f]{64})\n")


class _WrongError(Exception):
    """A `SavedError` without the name of the file."""


class _Unit(msgspec.Struct, frozen=True, array_like=True):
    """A source: its forms, each as separate JSON, and the index of its RAPs."""

    file: str
    text: str
    forms: tuple[msgspec.Raw, ...]
    #: The indexes of the RAPs among the forms, by name.
    raps: dict[str, int]


class _Suite(msgspec.Struct, frozen=True, array_like=True):
    """A set of tests with the name and the sources of their library."""

    name: str
    units: tuple[int, ...]
    tests: tuple[msgspec.Raw, ...]


class _Body(msgspec.Struct, frozen=True, array_like=True):
    """All sources, the name and the sources of the library, and the tests."""

    name: str
    library: tuple[int, ...]
    units: tuple[_Unit, ...]
    suites: tuple[_Suite, ...]


class Suite(NamedTuple):
    """A set of tests that run the same library."""

    tests: Sequence[DefineTest]
    library: Library
    #: The name of the library in traces.
    name: str


# --- to bytes -------------------------------------------------------------------------


def encode(library: Library, name: str, suites: Iterable[Suite] = ()) -> bytes:
    """Serialise a checked library and its tests; equal input gives equal bytes.

    Args:
        library: the library, linked from sources and free of errors.
        name: the name of the library in traces.
        suites: the tests of the library.

    Raises:
        SavedError: for a library that could not be read back, that is, a library
            with suppressed errors that prevent a run, with an unprintable file name,
            or read from a compiled library.
    """
    if len(library.raps) > len(library.forms):
        raise SavedError(f"`{name}` is already a compiled library")
    units: dict[str, _Unit] = {}
    listed = _units(library, units)
    tests = tuple(
        _Suite(
            suite.name,
            _units(suite.library, units),
            tuple(msgspec.Raw(msgspec.json.encode(test)) for test in suite.tests),
        )
        for suite in suites
    )
    body = _Body(name, listed, tuple(units.values()), tests)
    with _errors_name(name):
        _look_at_names(body)
    sealed = seal(msgspec.json.encode(body))
    SavedLibrary(sealed, name).look_at_all()
    return sealed


def seal(payload: bytes, version: str = VERSION, form: int = FORMAT) -> bytes:
    """Return a payload after its first line: format, version and checksum."""
    checksum = hashlib.sha256(payload).hexdigest()
    return COMPILED + f"{form} {version} {checksum}\n".encode() + payload


def _units(library: Library, units: dict[str, _Unit]) -> tuple[int, ...]:
    """Return the indexes of a library's sources in `units`; add missing sources."""
    forms: dict[str, list[nodes.TopForm]] = {name: [] for name in library.files}
    for form in library.forms:
        own = form
        if library.methods and isinstance(form, nodes.DefineRap):
            own = msgspec.structs.replace(form, methods=own_methods(form))
        forms[form.span.file].append(own)
    for added in library.methods:
        forms[added.span.file].append(added)
    for name, source in library.files.items():
        if name not in units:
            units[name] = _unit(source, forms[name])
    places = {name: at for at, name in enumerate(units)}
    return tuple(places[name] for name in library.files)


def _unit(source: SourceFile, forms: Sequence[nodes.TopForm]) -> _Unit:
    encode = msgspec.json.Encoder().encode
    raps = {
        form.name: at
        for at, form in enumerate(forms)
        if isinstance(form, nodes.DefineRap)
    }
    listed = tuple(msgspec.Raw(encode(form)) for form in forms)
    return _Unit(source.name, source.text, listed, raps)


# --- from bytes -----------------------------------------------------------------------


class SavedLibrary:
    """A checked library that was read from bytes.

    `library` is the linked library, `name` its name in traces.

    Args:
        data: the bytes of the file.
        file: the name of the file, for messages.

    Raises:
        SavedError: for bytes that are not a compiled library, are damaged, come from a
            different version, or have content that no source compiles to. The methods,
            and reading a RAP of the library, may raise the error, too.
    """

    def __init__(self, data: bytes, file: str) -> None:
        self._file = file
        with _errors_name(file):
            self._body = _decode(_payload(data), _Body)
            _look_at_names(self._body)
            self.name = self._body.name
            self._read: dict[tuple[int, ...], tuple[Library, Verifier]] = {}
            self.library, _ = self._linked(self._body.library)

    def suites(self) -> Iterator[Suite]:
        """Yield the tests with their libraries, completely validated."""
        for suite in self._body.suites:
            with _errors_name(self._file):
                library, verifier = self._linked(suite.units)
                tests = tuple(_decode(raw, DefineTest) for raw in suite.tests)
                for test in tests:
                    verifier.node(test)
            _look_at_all(library)
            yield Suite(tests, library, suite.name)

    def look_at_all(self) -> None:
        """Validate the whole content at once, not at its first use."""
        _look_at_all(self.library)
        deque(self.suites(), 0)

    def _linked(self, places: tuple[int, ...]) -> tuple[Library, Verifier]:
        """Return the library of some of the sources, with lazy RAPs.

        The library is cached: suites with the same sources share it.
        """
        if places not in self._read:
            self._read[places] = self._link(places)
        return self._read[places]

    def _link(self, places: tuple[int, ...]) -> tuple[Library, Verifier]:
        if not all(0 <= at < len(self._body.units) for at in places):
            raise _WrongError("has no source")
        if len(set(places)) < len(places):
            raise _WrongError("has a duplicate source")
        units = [self._body.units[at] for at in places]
        linked, found = link([_parsed(unit, _declarations(unit)) for unit in units])
        rows = {name: (unit, at) for unit in units for name, at in unit.raps.items()}
        if found or len(rows) < sum(len(unit.raps) for unit in units):
            raise _WrongError("has duplicate names")
        added = linked.methods
        decoded = Lazy(rows, lambda name: self._rap(name, *rows[name], added))
        linked = msgspec.structs.replace(linked, raps=decoded)
        verifier = Verifier(Signatures.of(linked), linked.files)
        for form in (*linked.forms, *linked.methods):
            verifier.declaration(form)
        raps = Lazy(rows, lambda name: self._verified(decoded[name], verifier))
        return msgspec.structs.replace(linked, raps=raps, forms=()), verifier

    def _rap(
        self, name: str, unit: _Unit, at: int, added: Iterable[nodes.DefineMethod]
    ) -> nodes.DefineRap:
        """Decode a RAP with its methods among those `added`.

        Raises:
            SavedError: if the index of the RAP leads to a different form, or two
                methods have the same name.
        """
        with _errors_name(self._file):
            if not 0 <= at < len(unit.forms):
                raise _WrongError(f"has no RAP `{name}`")
            made: nodes.DefineRap = _decode(unit.forms[at], nodes.DefineRap)
            if made.name != name:
                raise _WrongError("has a RAP at the position of another RAP")
            whole, same = with_methods(made, [m for m in added if m.rap == name])
            if same:
                raise _WrongError("has duplicate names")
            return whole

    def _verified(self, rap: nodes.DefineRap, verifier: Verifier) -> nodes.DefineRap:
        """Return a RAP; raise SavedError if the RAP is invalid."""
        with _errors_name(self._file):
            verifier.rap(rap)
            return rap


def _look_at_names(body: _Body) -> None:
    """Validate that the names of files and libraries are printable."""
    libraries = (body.name, *[suite.name for suite in body.suites])
    for name in (*libraries, *[unit.file for unit in body.units]):
        if not name.isprintable():
            raise _WrongError(f"has a file name that cannot be printed: {name!a}")


def _look_at_all(library: Library) -> None:
    """Read every RAP once; raise SavedError for an invalid RAP."""
    deque(library.raps.values(), 0)


@contextmanager
def _errors_name(file: str) -> Iterator[None]:
    """Add the name of the file to errors about its content, as SavedError."""
    try:
        yield
    except _WrongError as error:
        raise SavedError(f"`{file}` {error}") from None
    except UnsoundError as error:
        raise SavedError(f"`{file}` cannot be run: {error}") from None
    except RecursionError:
        reason = "is invalid: a node is nested too deeply"
        raise SavedError(f"`{file}` {reason}") from None


def _declarations(unit: _Unit) -> Iterator[int]:
    """Return the indexes of the forms of a source that are not RAPs."""
    raps = {*unit.raps.values()}
    return (at for at in range(len(unit.forms)) if at not in raps)


def _parsed(unit: _Unit, places: Iterable[int]) -> SourceUnit:
    """Return a source with some of its forms."""
    forms = tuple(_decode(unit.forms[at], nodes.TopForm) for at in places)
    return SourceUnit(SourceFile(unit.file, unit.text), forms)


def _payload(data: bytes) -> memoryview:
    """Return the bytes after the first line; raise if that line is invalid."""
    if not data.startswith(COMPILED):
        raise _WrongError("is not a compiled library")
    head = _HEAD.match(data)
    if head is None:
        raise _WrongError("is damaged: its first line is incomplete")
    form, version, checksum = (part.decode() for part in head.groups())
    if int(form) != FORMAT or version != VERSION:
        raise _WrongError(
            f"was compiled by rapc {version}, format {form}; this is rapc {VERSION}, "
            f"format {FORMAT}: compile it again"
        )
    payload = memoryview(data)[head.end() :]
    if hashlib.sha256(payload).hexdigest() != checksum:
        raise _WrongError("is damaged: its content does not match its checksum")
    return payload


def _decode(data: memoryview | msgspec.Raw, kind: Any) -> Any:
    try:
        return _decoder(kind).decode(data)
    except UNREADABLE as error:
        reason = ascii(flaw(error))[1:-1][:MAX_REASON]
        raise _WrongError(f"is invalid: {reason}") from None


@cache
def _decoder(kind: Any) -> msgspec.json.Decoder[Any]:
    """Return the decoder of a type, cached: a decoder is expensive to make."""
    return msgspec.json.Decoder(kind)
