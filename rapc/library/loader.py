"""Loading of RAP files: find and read files, follow `require`, and link the units.

A `require` means a file or folder beside the requiring file, or a standard library. The
library of a test has the test's file, the files that it requires, and the files that
the test itself requires. Files that only other tests require are left out: two tests of
a file may run libraries that could not be linked into one.

A path that cannot be read raises `LoadError` (`rapc.base.files`), one line for the
user. All other faults are findings, and the result has the valid rest.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from threading import Lock

import msgspec

from rapc.base.diagnostics import Diagnostic, Rule
from rapc.base.files import (
    STANDARD,
    SUFFIX,
    TEST_SUFFIX,
    Identity,
    fold_line_ends,
    identity_of,
    name_beside,
    names_at,
    path_of,
    read_standard_input,
    read_text,
    same_file,
)
from rapc.base.gc_paused import gc_paused
from rapc.base.names import nearest
from rapc.base.source import SourceFile
from rapc.base.visible import visible
from rapc.errors import LoadError
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library import library
from rapc.library.library import Library
from rapc.parser.parse import parse
from rapc.parser.unit import SourceUnit

Parse = Callable[[SourceFile], SourceUnit]
"""A parser of files: `rapc.parser.parse.parse`, or a cache such as `Units`."""

Names = dict[Identity, str]
"""The name of each file at its first read.

Loads that share the mapping use the same name for a file, for each path to the file.
"""

STANDARD_INPUT = "<stdin>"
"""The name in spans of the text on standard input."""


class Units:
    """A `parser` for `load` and similar functions that caches the units of files.

    Threads may share the cache.
    """

    def __init__(self) -> None:
        self._made: dict[str, SourceUnit] = {}
        self._lock = Lock()

    def __call__(self, source: SourceFile) -> SourceUnit:
        """Return the unit of a file, from the cache if its text is unchanged.

        A form with the same text at the same place is the same node as before.
        """
        with self._lock:
            made = self._made.get(source.name)
            if made is None or made.file.text != source.text:
                new = parse(source)
                made = new if made is None else _with_nodes_of(made, new)
                self._made[source.name] = made
            return made


def _with_nodes_of(old: SourceUnit, new: SourceUnit) -> SourceUnit:
    """Return a unit with the nodes of an earlier unit for forms with the same text.

    A form with a part left out is not determined by its text and keeps its new node.
    """
    before = {form.span: form for form in old.forms}
    for one in (*old.partial, *new.partial):
        before.pop(one.form.span, None)

    def known(form: nodes.TopForm) -> nodes.TopForm:
        text = slice(form.span.start, form.span.end)
        same = old.file.text[text] == new.file.text[text]
        return before.get(form.span, form) if same else form

    return msgspec.structs.replace(new, forms=tuple(map(known, new.forms)))


_LONG = 60
"""The number of characters of a required name that messages repeat."""

UNRESOLVED = Rule(
    code="RAP062",
    name="unresolved-require",
    summary="unknown file, folder or standard library in a `require`",
    source="L 1",
)

RULES = (UNRESOLVED,)
"""The rules that loading reports."""


class Loaded(msgspec.Struct, frozen=True):
    """A library that was read and linked, not yet checked."""

    #: The definitions of all files.
    library: Library
    #: The files, each after those that it requires.
    units: tuple[SourceUnit, ...]
    #: The findings of the reader, the forms, `require` and linking.
    diagnostics: tuple[Diagnostic, ...]
    #: The directly required files of each file, by name.
    required: Mapping[str, tuple[str, ...]] = {}

    @property
    def files(self) -> Mapping[str, SourceFile]:
        """Every file read, by its name in spans, first read first."""
        return self.library.files


@gc_paused()
def load(
    paths: Iterable[str | Path],
    *,
    tests: bool = False,
    texts: Mapping[str, str] | None = None,
    parser: Parse = parse,
    names: Names | None = None,
) -> Loaded:
    """Read files and folders with all required files, and link them into a library.

    Args:
        paths: files, folders (all `.rap` files below, sorted) or `-` for standard
            input. Folders whose name begins with a dot are left out below a folder.
        tests: whether `*.test.rap` files found in folders are read as well.
        texts: replacements for the texts of some files, by file name; a file among
            them need not exist.
        parser: the parser of files.
        names: the names of files, shared by several loads.

    Raises:
        LoadError: for a path that is missing, unreadable, not UTF-8 or not text, and
            for folders with a link to a folder above.
    """
    typed = list(dict.fromkeys(map(str, paths)))
    given = [Path(n) for n in typed if n != "-" and not n.startswith(STANDARD)]
    reading = _Reading(tests, given=given, texts=texts, parser=parser, names=names)
    for path in typed:
        if path == "-":
            reading.add(reading.source(STANDARD_INPUT))
        elif path in reading.texts:
            reading.add_first(reading.source(path))
        else:
            reading.read_all(names_at(path, tests))
    return reading.finish()


@gc_paused()
def load_for_test(
    sources: Iterable[SourceFile],
    requires: Iterable[nodes.Require],
    texts: Mapping[str, str] | None = None,
    parser: Parse = parse,
    names: Names | None = None,
) -> Loaded:
    """Link the library of a test: its file with the required files of both.

    Files that only other tests of the file require are left out. Several files of tests
    are allowed. Raises LoadError as `load`.
    """
    wanted = frozenset(form.name for form in requires)
    reading = _Reading(
        tests=False, of_tests=wanted, texts=texts, parser=parser, names=names
    )
    for source in sources:
        reading.add_first(source)
    return reading.finish()


def read_tests(
    paths: Iterable[str | Path], texts: Mapping[str, str] | None = None
) -> Iterator[SourceFile]:
    """Read files, and all `*.test.rap` files below folders.

    A path may be `-` for standard input; `texts` replace the files of their names.

    Raises:
        LoadError: for an unreadable file, and for folders as in `load`.
    """
    seen: set[Identity] = set()
    for path in dict.fromkeys(map(str, paths)):
        if path == "-":
            yield SourceFile(STANDARD_INPUT, read_standard_input())
            continue
        if texts is not None and path in texts:
            yield SourceFile(path, texts[path])
            continue
        for name in names_at(path, tests=True):
            file = path_of(name)
            if file != path_of(path) and not name.endswith(TEST_SUFFIX):
                continue
            if identity_of(file) not in seen:
                seen.add(identity_of(file))
                yield SourceFile(name, read_text(file))


@gc_paused()
def required_files(
    path: str,
    texts: Mapping[str, str] | None = None,
    parser: Parse = parse,
    names: Names | None = None,
) -> Mapping[str, tuple[str, ...]]:
    """Return the files that each file below a folder requires; tests are included.

    The result has the files that are required from outside of the folder, too. A file
    that cannot be read requires no file.

    Raises:
        LoadError: if the folder cannot be read.
    """
    reading = _Reading(tests=False, texts=texts, parser=parser, names=names)
    for name in names_at(path, tests=True):
        with suppress(LoadError):
            reading.read_all([name])
    found = reading.finish().required
    return {name: found.get(name, ()) for name in reading.seen.values()}


def names_below(path: str) -> Names:
    """Return the names of the files below a folder, for loads that share the files.

    A file that is also part of a standard library keeps its name below the folder.

    Raises:
        LoadError: if the folder cannot be read.
    """
    return {identity_of(path_of(name)): name for name in names_at(path, tests=True)}


@gc_paused()
def load_text(text: str, name: str = "<text>") -> Loaded:
    """Link a text like a file in the working directory; see `load`."""
    reading = _Reading(tests=False)
    reading.add(SourceFile(name, fold_line_ends(text)))
    return reading.finish()


@gc_paused()
def load_sources(sources: Iterable[SourceFile]) -> Loaded:
    """Link the texts of a complete library; `require` is not followed."""
    reading = _Reading(tests=False, follow=False)
    for source in sources:
        reading.add(source)
    return reading.finish()


class _Opened(msgspec.Struct, frozen=True):
    """A parsed file whose required files are being read."""

    unit: SourceUnit
    #: The names of the required files.
    required: Iterator[str]


class _Reading:
    """The files of a load; a file follows the files that it requires.

    Args:
        tests: whether test files in required folders are read as well.
        of_tests: the names that are followed among the `require` of tests; None for
            all.
        given: the paths that the user named; a copy of a standard library may be among
            them.
        follow: whether `require` is followed.
        texts: replacements for the texts of some files, by name.
        parser: the parser of files.
        names: the names of files, shared by several loads.
    """

    def __init__(  # options of the kinds of load, each with a default
        self,
        tests: bool,
        of_tests: frozenset[str] | None = None,
        given: Sequence[Path] = (),
        follow: bool = True,
        texts: Mapping[str, str] | None = None,
        parser: Parse = parse,
        names: Names | None = None,
    ) -> None:
        self.tests = tests
        self.names = {} if names is None else names
        self.parser = parser
        self.of_tests = of_tests
        self.given = given
        self.follow = follow
        self.texts = texts or {}
        self.units: list[SourceUnit] = []
        self.missing: list[Diagnostic] = []
        #: The files that were read or are being read, with their names.
        self.seen: dict[Identity, str] = {}
        #: The files that each file requires, by its name.
        self.required: dict[str, list[Identity]] = {}

    def read_all(self, names: Iterable[str]) -> None:
        """Read the files that were not read before, under any name."""
        for name in filter(None, map(self._new, names)):
            self.add(self.source(name))

    def source(self, name: str) -> SourceFile:
        """Read a file or standard input, unless `texts` has a replacement."""
        text = self.texts.get(name)
        if text is None:
            is_input = name == STANDARD_INPUT
            text = read_standard_input() if is_input else read_text(path_of(name))
        return SourceFile(name, text)

    def add_first(self, source: SourceFile) -> None:
        """Parse a file that was already read, or a text; see `add`.

        A file that an earlier file requires is not parsed again.
        """
        path = path_of(source.name)
        if os.path.lexists(path):
            identity = identity_of(path)
            if identity in self.seen:
                return
            self.seen.setdefault(identity, source.name)
            self.names.setdefault(identity, source.name)
        self.add(source)

    def add(self, source: SourceFile) -> None:
        """Parse a text, and add its unit after the units of all required files."""
        opened = [self._open(source)]
        while opened:
            name = next(opened[-1].required, None)
            if name is None:
                self.units.append(opened.pop().unit)
            elif new := self._new(name):
                opened.append(self._open(self.source(new)))

    def finish(self) -> Loaded:
        """Link the units."""
        linked, names = library.link(self.units)
        required = {
            name: tuple([self.seen[one] for one in there])
            for name, there in self.required.items()
        }
        own = [found for unit in self.units for found in unit.diagnostics]
        found = (*own, *self.missing, *names)
        return Loaded(linked, tuple(self.units), found, required)

    def _new(self, name: str) -> str | None:
        """Return the name of a new file; None if it was read, under any name."""
        identity = identity_of(path_of(name))
        if identity in self.seen:
            return None
        self.seen[identity] = self.names.setdefault(identity, name)
        return self.seen[identity]

    def _open(self, source: SourceFile) -> _Opened:
        unit = self.parser(source)
        required = self._required(unit, source.name) if self.follow else iter(())
        return _Opened(unit, required)

    def _required(self, unit: SourceUnit, requiring: str) -> Iterator[str]:
        for form in self._requires(unit):
            target = resolve(form.name, requiring, self.given)
            found = [] if target is None else list(names_at(target, self.tests))
            if not found:
                self.missing.append(unresolved(form, path_of(requiring)))
            for name in found:
                there = self.required.setdefault(unit.file.name, [])
                there.append(identity_of(path_of(name)))
                yield name

    def _requires(self, unit: SourceUnit) -> Iterator[nodes.Require]:
        for form in unit.forms:
            if isinstance(form, nodes.Require):
                yield form
            elif isinstance(form, nodes.DefineAgenda):
                yield from form.requires
        for test in unit.tests:
            for form in test.requires:
                if self.of_tests is None or form.name in self.of_tests:
                    yield form


# --- resolution of `require` -------------------------------------------------------


def standard_libraries() -> tuple[str, ...]:
    """Return the names of the installed standard libraries, sorted."""
    folder = path_of(STANDARD)
    if not folder.is_dir():
        return ()
    return tuple(sorted(e.name.removesuffix(SUFFIX) for e in folder.iterdir()))


def resolve(name: str, requiring: str, given: Sequence[Path]) -> str | None:
    """Return the file or folder a `require` means; never the requiring file itself.

    The result has the form of the name of the requiring file, without `..` if that is
    the same file; a standard library is `rapc:truck`. A copy of a standard library
    replaces the installed library if the copy is among the paths `given` or contains
    the requiring file. The same holds for single files of the library. Otherwise all
    names of the library would be defined twice.
    """
    if os.path.isabs(name):
        return None
    here = path_of(requiring)
    beside = _in_folder(name, here.parent, here)
    if beside is not None:
        return name_beside(requiring, _without_detour(beside))
    installed = _in_folder(name, path_of(STANDARD), here)
    if installed is None:
        return None
    library, _, inner = name.partition("/")
    own = None if requiring.startswith(STANDARD) else here
    for copy in _copies(library, path_of(STANDARD + library), own, given):
        meant = _in_folder(inner, copy, here) if inner else copy
        if meant is not None:
            return str(meant)
    return name_beside(STANDARD, installed)


def _without_detour(path: Path) -> Path:
    """Return a path without `..`, unless a link makes that a different file."""
    plain = Path(os.path.normpath(path))
    return plain if os.pardir in path.parts and same_file(plain, path) else path


def _copies(
    name: str, installed: Path, requiring: Path | None, given: Sequence[Path]
) -> Iterator[Path]:
    """Yield the copies that replace an installed library.

    Args:
        name: the library.
        installed: the folder of the installed library.
        requiring: the file that requires the library; None for an installed file.
        given: the paths that the user named.
    """
    for path in given:
        real = path.resolve()
        for folder in (path, path / name):
            same = folder is not path or real.name == name
            if same and _is_copy(folder, installed):
                yield folder
    if requiring is None:
        return
    for folder in requiring.resolve().parents:
        if folder.name == name and _is_copy(folder, installed):
            yield folder if requiring.is_absolute() else Path(os.path.relpath(folder))


def _is_copy(folder: Path, installed: Path) -> bool:
    """Return whether a folder has all the RAP files of an installed library."""
    try:
        there, here = set(os.listdir(installed)), set(os.listdir(folder))
    except OSError:  # not a folder, or not readable
        return False
    return {name for name in there if name.endswith(SUFFIX)} <= here


def _in_folder(name: str, folder: Path, requiring: Path) -> Path | None:
    file = folder / (name + SUFFIX)
    if os.path.isfile(file) and file != requiring:
        return file
    return folder / name if name and os.path.isdir(folder / name) else None


def unresolved(form: nodes.Require, requiring: Path) -> Diagnostic:
    """Return the finding for a `require` that cannot be resolved."""
    names = [name for name in names_beside(requiring) if name != requiring.stem]
    known = [*names, *standard_libraries()]
    without = form.name.removesuffix(SUFFIX)
    close = without if without in known else nearest(form.name, known)
    name = visible(form.name)
    name = name if len(name) <= _LONG else f"{name[:_LONG]}..."
    return UNRESOLVED.at(
        form.span,
        f"cannot find `{name}`",
        notes=(
            f"neither a file `{name}{SUFFIX}` nor a folder `{name}` with "
            f"RAP files is beside this file, and `{name}` is not a standard "
            "library",
        ),
        help=_advice(form.name, close),
    )


def _advice(name: str, close: str | None) -> str:
    """Return the help for the unknown `name` with the similar name `close`."""
    if close is None:
        return ""
    if name == close + SUFFIX:
        return f"omit the suffix: `{close}`"
    return f"did you mean `{close}`?"


def names_beside(requiring: Path) -> list[str]:
    """Return the names of files and folders beside a file, valid for `require`."""
    try:
        with os.scandir(requiring.parent) as entries:
            listed = [(entry.name, entry.is_dir()) for entry in entries]
    except OSError:
        return []
    found = [name for name, is_folder in listed if is_folder or name.endswith(SUFFIX)]
    return [name.removesuffix(SUFFIX) for name in found]


# --- libraries of tests ------------------------------------------------------------


class FilesOfTests(msgspec.Struct, frozen=True):
    """Files of tests, with the libraries of the tests."""

    #: The tests in the files themselves, in the order of the text.
    tests: tuple[DefineTest, ...]
    #: A library for each set of required files, only with the tests that run it.
    libraries: tuple[Loaded, ...]


def alike(
    sources: Iterable[SourceFile], parser: Parse = parse
) -> Iterator[Sequence[SourceFile]]:
    """Yield groups of test files: files with only tests and equal `require` forms.

    `load_tests` returns the same libraries for a file alone and for its group.
    """
    found: dict[tuple[str, ...], list[SourceFile]] = {}
    for source in sources:
        forms = parser(source).forms
        key: tuple[str, ...] = (source.name,)
        requires = [form for form in forms if isinstance(form, nodes.Require)]
        if len(requires) == len(forms):
            key = (os.path.dirname(source.name), *(form.name for form in requires))
        found.setdefault(key, []).append(source)
    yield from found.values()


def load_tests(
    sources: Sequence[SourceFile],
    texts: Mapping[str, str] | None = None,
    parser: Parse = parse,
    names: Names | None = None,
) -> FilesOfTests:
    """Link the libraries of the tests in files; one library even without tests.

    Args:
        sources: the files; several only if they are a group of `alike`.
        texts: replacements for the texts of required files, by name.
        parser: the parser of files.
        names: the names of files, shared by several loads.

    Raises:
        LoadError: as `load`.
    """
    whole = load_for_test(sources, (), texts, parser, names)
    files = {source.name for source in sources}
    own = [test for test in whole.library.tests if test.span.file in files]
    groups: dict[tuple[str, ...], list[DefineTest]] = {}
    for test in own:
        wanted = tuple([form.name for form in test.requires])
        groups.setdefault(wanted, []).append(test)
    libraries = []
    for wanted, tests in (groups or {(): []}).items():
        loaded = whole
        if wanted:
            requires = tests[0].requires
            loaded = load_for_test(sources, requires, texts, parser, names)
        libraries.append(_with_tests(loaded, tests))
    return FilesOfTests(tuple(own), tuple(libraries))


def _with_tests(loaded: Loaded, tests: Sequence[DefineTest]) -> Loaded:
    library = msgspec.structs.replace(loaded.library, tests=tuple(tests))
    return msgspec.structs.replace(loaded, library=library)
