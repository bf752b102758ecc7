"""Find and read RAP files, follow `require`, and link what was read.

A `require` means a file or folder beside its own, or a standard library. A test runs
its file, what that requires, and what the test itself requires; what other tests
require is left out, so two tests of one file may run libraries that could not be linked
into one.

What cannot be read at all is a `LoadError` (`rapc.base.files`), one line for the user;
everything else that is wrong is a diagnostic, and what could be made of the rest is
there as well.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

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
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library import library
from rapc.library.library import Library
from rapc.parser.parse import parse
from rapc.parser.unit import SourceUnit

Parse = Callable[[SourceFile], SourceUnit]
"""What makes a unit of a file: `rapc.parser.parse.parse`, or what remembers units."""

Names = dict[Identity, str]
"""The name of each file, under which it was read first.

Loads that share one give a file the same name, whatever path leads to it.
"""

STANDARD_INPUT = "<stdin>"
"""What spans call the text on standard input."""


class Units:
    """Reads files, and remembers what it made of them as long as they stay the same.

    For `load` and its like, as their `parser`.
    """

    def __init__(self) -> None:
        self._made: dict[str, SourceUnit] = {}

    def __call__(self, source: SourceFile) -> SourceUnit:
        """Return the unit of a file; it is parsed unless its text is as before."""
        made = self._made.get(source.name)
        if made is None or made.file.text != source.text:
            made = self._made[source.name] = parse(source)
        return made


_LONG = 60
"""How much of a required name is repeated in messages."""

UNRESOLVED = Rule(
    code="RAP062",
    name="unresolved-require",
    summary="a `require` names neither a file, nor a folder, nor a standard library",
    why="""`(require "name")` means the file `name.rap` or the folder `name` beside the
requiring file, else the standard library of that name. What it should have brought in
is missing, so most of what uses it would be reported as unknown too.""",
    source="L 1",
    example="""\
(require "no-such-library")
""",
    better="""\
(declare-memory-proposition seen (?thing))
""",
)

RULES = (UNRESOLVED,)
"""The rules that loading can break."""


class Loaded(msgspec.Struct, frozen=True):
    """A library that was read and linked, not yet checked."""

    #: The definitions of all files.
    library: Library
    #: The files, each after those that it requires.
    units: tuple[SourceUnit, ...]
    #: What the reader, the forms, `require` and linking found.
    diagnostics: tuple[Diagnostic, ...]
    #: The files that files require themselves, by their names.
    required: Mapping[str, tuple[str, ...]] = {}

    @property
    def files(self) -> Mapping[str, SourceFile]:
        """Every file read, by the name that spans carry, first read first."""
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
    """Read files and folders, all they require, and link them into one library.

    Args:
        paths: files, folders (all `.rap` files below, sorted) or `-` for standard
            input. Folders whose name begins with a dot are left out below a folder.
        tests: whether `*.test.rap` files found in folders are read as well.
        texts: what stands for the texts of some files, by the names they would get; a
            path among them need not exist.
        parser: what makes units of files.
        names: the names of files that are read more than once.

    Raises:
        LoadError: for a path that is missing, unreadable, not UTF-8 or not text, and
            for folders that lead back into themselves.
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
    """Link what a test runs: its file, and what that and the test itself require.

    What other tests of the file require is left out. There may be more than one file
    of tests. Raises LoadError as `load`.
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
    """Read the files named, and all `*.test.rap` files below the folders named.

    A path may be `-` for standard input; `texts` stand for files of these names.

    Raises:
        LoadError: for what cannot be read, and as `load` for folders.
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
def load_text(text: str, name: str = "<text>") -> Loaded:
    """Link one text as if it were a file in the working folder; see `load`."""
    reading = _Reading(tests=False)
    reading.add(SourceFile(name, fold_line_ends(text)))
    return reading.finish()


@gc_paused()
def load_sources(sources: Iterable[SourceFile]) -> Loaded:
    """Link texts that are a whole library: what they require is not looked for."""
    reading = _Reading(tests=False, follow=False)
    for source in sources:
        reading.add(source)
    return reading.finish()


class _Opened(msgspec.Struct, frozen=True):
    """A file that was parsed while the files that it requires are being read."""

    unit: SourceUnit
    #: The names of files.
    required: Iterator[str]


class _Reading:
    """The files of one load; those that a file requires come before it.

    Args:
        tests: whether test files in folders that are required are read as well.
        of_tests: names what is read of that which tests require; all of it if None.
        given: the paths that the user named, among which a copy of a standard library
            may be.
        follow: whether what files require is read at all.
        texts: what stands for the texts of some files, by name.
        parser: what makes units of files.
        names: the names of files that were read before.
    """

    def __init__(  # what kind of load it is, each with a default
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
        """Read files that were not read before, under whatever name."""
        for name in filter(None, map(self._new, names)):
            self.add(self.source(name))

    def source(self, name: str) -> SourceFile:
        """Read a file, or standard input, unless another text stands for it."""
        text = self.texts.get(name)
        if text is None:
            is_input = name == STANDARD_INPUT
            text = read_standard_input() if is_input else read_text(path_of(name))
        return SourceFile(name, text)

    def add_first(self, source: SourceFile) -> None:
        """Parse a file that was read before this began, or a text; see `add`."""
        path = path_of(source.name)
        if os.path.lexists(path):
            identity = identity_of(path)
            self.seen.setdefault(identity, source.name)
            self.names.setdefault(identity, source.name)
        self.add(source)

    def add(self, source: SourceFile) -> None:
        """Parse a text, after all that it requires."""
        opened = [self._open(source)]
        while opened:
            name = next(opened[-1].required, None)
            if name is None:
                self.units.append(opened.pop().unit)
            elif new := self._new(name):
                opened.append(self._open(self.source(new)))

    def finish(self) -> Loaded:
        """Link what was read."""
        linked, names = library.link(self.units)
        required = {
            name: tuple([self.seen[one] for one in there])
            for name, there in self.required.items()
        }
        own = [found for unit in self.units for found in unit.diagnostics]
        found = (*own, *self.missing, *names)
        return Loaded(linked, tuple(self.units), found, required)

    def _new(self, name: str) -> str | None:
        """Return the name of a file that was not read before, by this name or another.

        None if it was read.
        """
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


# --- what a `require` means --------------------------------------------------------


def standard_libraries() -> tuple[str, ...]:
    """The names of the standard libraries that are installed, sorted."""
    folder = path_of(STANDARD)
    if not folder.is_dir():
        return ()
    return tuple(sorted(e.name.removesuffix(SUFFIX) for e in folder.iterdir()))


def resolve(name: str, requiring: str, given: Sequence[Path]) -> str | None:
    """Return the file or folder a `require` means; never the requiring file itself.

    It is named as the requiring file was, without `..` where that is the same file, or
    `rapc:truck` if it comes with rapc. A copy of a standard library among the paths
    `given`, or one that contains the requiring file, stands for the installed one, also
    where one file of it is required: else all its names were defined twice.
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
    """Return a path without `..`, unless a link makes that another file."""
    plain = Path(os.path.normpath(path))
    return plain if os.pardir in path.parts and same_file(plain, path) else path


def _copies(
    name: str, installed: Path, requiring: Path | None, given: Sequence[Path]
) -> Iterator[Path]:
    """Yield the copies of an installed library that a reader would take for it.

    Args:
        name: the library.
        installed: where it is installed.
        requiring: the file that requires it; None for one that is installed, too.
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
    """Whether a folder has all the RAP files that an installed library has."""
    try:
        there, here = set(os.listdir(installed)), set(os.listdir(folder))
    except OSError:  # no folder, or one that may not be read
        return False
    return {name for name in there if name.endswith(SUFFIX)} <= here


def _in_folder(name: str, folder: Path, requiring: Path) -> Path | None:
    file = folder / (name + SUFFIX)
    if os.path.isfile(file) and file != requiring:
        return file
    return folder / name if name and os.path.isdir(folder / name) else None


def unresolved(form: nodes.Require, requiring: Path) -> Diagnostic:
    """Return what is to be said of a `require` in a file that means nothing."""
    names = [name for name in _beside(requiring) if name != requiring.stem]
    known = [*names, *standard_libraries()]
    without = form.name.removesuffix(SUFFIX)
    close = without if without in known else nearest(form.name, known)
    name = form.name if len(form.name) <= _LONG else f"{form.name[:_LONG]}..."
    return UNRESOLVED.at(
        form.span,
        f"nothing is found for `{name}`",
        notes=(
            f"neither `{name}{SUFFIX}` nor a folder `{name}` with RAP files "
            "stands beside this file, and no standard library is called so",
        ),
        help=_advice(form.name, close),
    )


def _advice(name: str, close: str | None) -> str:
    """Return what to write for `name`, where `close` is what may be meant."""
    if close is None:
        return ""
    if name == close + SUFFIX:
        return f"leave the ending out: `{close}`"
    return f"did you mean `{close}`?"


def _beside(requiring: Path) -> list[str]:
    """Return what could be required from beside a file."""
    try:
        with os.scandir(requiring.parent) as entries:
            listed = [(entry.name, entry.is_dir()) for entry in entries]
    except OSError:
        return []
    found = [name for name, is_folder in listed if is_folder or name.endswith(SUFFIX)]
    return [name.removesuffix(SUFFIX) for name in found]


# --- libraries of tests ------------------------------------------------------------


class FilesOfTests(msgspec.Struct, frozen=True):
    """Files of tests, and the libraries that they run."""

    #: The tests that stand in the files themselves, in the order of the text.
    tests: tuple[DefineTest, ...]
    #: A library for each set of required files; it holds the tests that run it alone.
    libraries: tuple[Loaded, ...]


def alike(
    sources: Iterable[SourceFile], parser: Parse = parse
) -> Iterator[Sequence[SourceFile]]:
    """Yield files of tests, those together that hold tests alone and require the same.

    `load_tests` gives these the same libraries whether it gets one or all of them.
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
    """Link what the tests of files run; there is a library even if there is no test.

    Args:
        sources: the files; several only if they are `alike`.
        texts: what stands for the texts of required files, by name.
        parser: what makes units of files.
        names: the names of files that are read more than once.

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
