"""What files of tests run: a library for each set of files that tests require.

A test runs its file, what that requires, and what the test itself requires; what other
tests require is left out. So two tests of one file may run libraries that could not be
linked into one.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.base.source import SourceFile
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library import loader
from rapc.library.loader import Loaded, Names, Parse
from rapc.parser.parse import parse


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
        LoadError: as `rapc.library.loader.load`.
    """
    whole = loader.load_for_test(sources, (), texts, parser, names)
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
            loaded = loader.load_for_test(sources, requires, texts, parser, names)
        libraries.append(_with_tests(loaded, tests))
    return FilesOfTests(tuple(own), tuple(libraries))


def _with_tests(loaded: Loaded, tests: Sequence[DefineTest]) -> Loaded:
    library = msgspec.structs.replace(loaded.library, tests=tuple(tests))
    return msgspec.structs.replace(loaded, library=library)
