"""What checks came to, kept on disk for the next one: by content, not by time.

A library is told by the names and digests of its files, in the order in which they are
read: what was found in it is found again, and no file of it is parsed. Which files make
up a library is looked for anew at each check, with what every file requires by its
digest, for a file may be put in the place of another. So nothing that is kept has to be
held against anything, but for the version of rapc, the rules chosen, and a checksum.

A cache that is damaged, of another version or cannot be read is as if there were none;
one that cannot be written stays as it was. It is written whole, so that processes that
share it never see half of it. Libraries with a `require` that names nothing are not
kept, for what is said of it depends on what else is in the folder.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import msgspec

from rapc.analysis import suite
from rapc.analysis.again import Again, check_again
from rapc.analysis.cache_file import SUFFIX
from rapc.analysis.driver import CheckReport, Finding, examined
from rapc.analysis.kept import State, state_of
from rapc.analysis.selection import Selection
from rapc.base.diagnostics import Diagnostic
from rapc.base.source import SourceFile, Span
from rapc.base.version import VERSION
from rapc.base.writing import write_whole
from rapc.errors import WriteError
from rapc.ir import nodes
from rapc.library.loader import Loaded, Parse
from rapc.library.units import Units
from rapc.parser.unit import SourceUnit

MOST_FILES = 100
"""Of more files in a folder of caches the oldest are taken away."""

_DIGEST = 16
"""How many bytes tell a text, or a library, from all others."""

Load = Callable[[Parse], Sequence[Loaded]]
"""Loads some libraries, given what makes units of files."""


class _Needs(msgspec.Struct, frozen=True, array_like=True):
    """What a file requires for all, and each of its tests besides."""

    all: tuple[str, ...]
    tests: tuple[tuple[str, ...], ...]


class _Kept(msgspec.Struct, frozen=True, array_like=True):
    """What was found in a library, and how many RAPs its files have."""

    found: tuple[Diagnostic, ...]
    raps_in: Mapping[str, int]


class _Body(msgspec.Struct, frozen=True, array_like=True):
    """What a cache holds: for whom it is, and by digest what is known."""

    owner: str
    needs: Mapping[str, _Needs]
    kept: Mapping[str, _Kept]
    #: What the libraries tell form by form, in the order in which they are checked.
    states: Mapping[int, msgspec.Raw]


class Cache:
    """The cache of one way to check some paths.

    Args:
        file: where it is on disk, or is to be.
        paths: the paths that are checked.
        selection: the rules that report.
        units: makes units of files.
    """

    def __init__(
        self, file: Path, paths: Sequence[str], selection: Selection, units: Units
    ) -> None:
        self._file = file
        self._units = units
        self._owner = _owner(paths, selection)
        self._rules = {n: selection.graded(r) for n, r in suite.rules().items()}
        self._old = _read(file, self._owner)
        self._needs: dict[str, _Needs] = {}
        self._kept: dict[str, _Kept] = {}
        self._states: dict[int, msgspec.Raw] = {}
        self._selection = selection
        self._checked = 0

    def reports(self, load: Load) -> list[CheckReport]:
        """Return a report on each library; what is known of none is found out.

        Args:
            load: loads the libraries; it is called again where one is not known.

        Raises:
            LoadError: as `load`.
        """
        sketched = load(self._sketch)
        first, self._checked = self._checked, self._checked + len(sketched)
        found = [self._known(first + at, one) for at, one in enumerate(sketched)]
        if all(found):
            return [report for report in found if report is not None]
        whole = load(self._units)
        if not _same(sketched, whole):  # a file changed in between
            return [examined(loaded, self._selection).report for loaded in whole]
        return [
            self._found(first + at, sketched[at], whole[at])
            if report is None
            else report
            for at, report in enumerate(found)
        ]

    def save(self) -> None:
        """Write what was found to disk, unless it is known there."""
        if self._old.kept.keys() >= self._kept.keys():
            return
        body = _Body(self._owner, self._needs, self._kept, self._states)
        payload = msgspec.msgpack.encode(body)
        folder = self._file.parent
        with suppress(OSError, WriteError):  # it is as if there were no cache
            if not folder.is_dir():
                folder.mkdir(parents=True, exist_ok=True)
                (folder / ".gitignore").write_text("*\n", encoding="ascii")
            write_whole(self._file, _checksum(payload) + payload)
            _thin_out(folder)

    def _known(self, number: int, sketched: Loaded) -> CheckReport | None:
        """Return what is known of a library, or can be told from what is.

        Args:
            number: how many libraries are checked before it.
            sketched: the library, of which no more is true than what it requires.
        """
        key = _key(sketched)
        if key is None:
            return None
        state = self._old.states.get(number)
        kept = self._old.kept.get(key)
        if kept is not None:
            self._kept[key] = kept
            if state is not None:
                self._states[number] = state
            return self._report(kept, sketched.files)
        again = None if state is None else self._again(state, sketched)
        if again is None:
            return None
        self._keep(key, number, again.report, again.state)
        return again.report

    def _again(self, state: msgspec.Raw, sketched: Loaded) -> Again | None:
        try:
            old = msgspec.msgpack.decode(state, type=State)
        except msgspec.DecodeError:
            return None
        return check_again(old, sketched, self._units, self._selection, _digest)

    def _found(self, number: int, sketched: Loaded, whole: Loaded) -> CheckReport:
        """Return what is found in a library of which nothing is known."""
        made = examined(whole, self._selection)
        key = _key(sketched)
        if key is not None:
            digest = {unit.file.name: _digest(unit.file) for unit in whole.units}
            self._keep(key, number, made.report, state_of(made, digest))
        return made.report

    def _keep(
        self, key: str, number: int, report: CheckReport, state: State | None
    ) -> None:
        found = tuple([finding.diagnostic for finding in report.findings])
        self._kept[key] = _Kept(found, report.raps_in)
        if state is not None:
            self._states[number] = msgspec.Raw(msgspec.msgpack.encode(state))
        elif number in self._old.states:  # of use when what is wrong has been mended
            self._states[number] = self._old.states[number]

    def _report(self, kept: _Kept, files: Mapping[str, SourceFile]) -> CheckReport:
        findings = tuple([Finding(self._rules[d.rule], d) for d in kept.found])
        return CheckReport(findings, files, kept.raps_in)

    def _sketch(self, source: SourceFile) -> SourceUnit:
        """Make a unit that holds no more than what its file requires."""
        digest = _digest(source)
        needs = self._needs.get(digest) or self._old.needs.get(digest)
        if needs is None:
            needs = _needs(self._units(source))
        self._needs[digest] = needs
        return _unit(source, needs)


def _read(file: Path, owner: str) -> _Body:
    """Return what a file holds for somebody; nothing if it holds anything else."""
    empty = _Body(owner, {}, {}, {})
    try:
        data = file.read_bytes()
        payload = data[_DIGEST:]
        if data[:_DIGEST] != _checksum(payload):
            return empty
        body = msgspec.msgpack.decode(payload, type=_Body)
    except (OSError, msgspec.DecodeError):
        return empty
    return body if body.owner == owner else empty


def _checksum(payload: bytes) -> bytes:
    return hashlib.blake2b(payload, digest_size=_DIGEST).digest()


def _thin_out(folder: Path) -> None:
    """Take the oldest caches away, and what processes that died have left."""
    with os.scandir(folder) as entries:
        listed = [(e.stat().st_mtime_ns, e.path) for e in entries if SUFFIX in e.name]
    for _, path in sorted(listed)[:-MOST_FILES]:
        os.unlink(path)


# --- for whom -------------------------------------------------------------------------


def _owner(paths: Sequence[str], selection: Selection) -> str:
    """Return the digest of all that findings depend on besides texts.

    The working folder is part of it, from which patterns of files are seen.
    """
    said = (VERSION, _stamps(), os.getcwd(), paths, selection)
    told = msgspec.json.encode(said, order="sorted")
    return hashlib.blake2b(told, digest_size=_DIGEST).hexdigest()


def _stamps() -> list[tuple[str, int, int]]:
    """Return the files of rapc, with their sizes and when they were changed.

    Of a copy that is worked on the version alone says little.
    """
    found: list[tuple[str, int, int]] = []
    waiting = [str(Path(__file__).parents[1])]
    while waiting:
        with os.scandir(waiting.pop()) as entries:
            for entry in entries:
                if entry.is_dir(follow_symlinks=False):
                    waiting.append(entry.path)
                elif entry.name.endswith((".py", ".so", ".pyd")):
                    status = entry.stat()
                    found.append((entry.path, status.st_size, status.st_mtime_ns))
    return sorted(found)


# --- what is told by what -------------------------------------------------------------


def _digest(source: SourceFile) -> str:
    text = source.text.encode("utf-8", "surrogatepass")
    return hashlib.blake2b(text, digest_size=_DIGEST).hexdigest()


def _key(sketched: Loaded) -> str | None:
    """Return what tells a library from others; None for one that is not kept."""
    if sketched.diagnostics:
        return None
    units = [(unit.file.name, _digest(unit.file)) for unit in sketched.units]
    tests = [(test.span.file, test.name) for test in sketched.library.tests]
    told = msgspec.json.encode((units, tests, sketched.required))
    return hashlib.blake2b(told, digest_size=_DIGEST).hexdigest()


def _same(sketched: Sequence[Loaded], whole: Sequence[Loaded]) -> bool:
    """Whether files had the same texts when they were read twice."""
    return [_texts(one) for one in sketched] == [_texts(one) for one in whole]


def _texts(loaded: Loaded) -> list[tuple[str, str]]:
    return [(unit.file.name, unit.file.text) for unit in loaded.units]


def _needs(unit: SourceUnit) -> _Needs:
    tests = [tuple([form.name for form in test.requires]) for test in unit.tests]
    return _Needs(tuple(_required(unit)), tuple(tests))


def _required(unit: SourceUnit) -> Iterator[str]:
    for form in unit.forms:
        if isinstance(form, nodes.Require):
            yield form.name
        elif isinstance(form, nodes.DefineAgenda):
            yield from (one.name for one in form.requires)


def _unit(source: SourceFile, needs: _Needs) -> SourceUnit:
    """Return a unit of which nothing is true but what it requires."""
    forms = tuple([nodes.Require(name) for name in needs.all])
    tests = [_test(source, at, names) for at, names in enumerate(needs.tests)]
    return SourceUnit(source, forms, tuple(tests))


def _test(source: SourceFile, at: int, names: Sequence[str]) -> nodes.DefineTest:
    return nodes.DefineTest(
        name=str(at),
        doc="",
        requires=tuple([nodes.Require(name) for name in names]),
        world=None,
        options=(),
        seed=None,
        agenda=None,
        answers=(),
        facts=(),
        script=(),
        ats=(),
        tasks=(),
        until=None,
        expectations=(),
        span=Span(source.name, at, at),
    )
