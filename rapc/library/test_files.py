"""What the tests of a file run: a library for each set of files that tests require.

A test runs its file, what that requires, and what the test itself requires; what other
tests require is left out. So two tests of one file may run libraries that could not be
linked into one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import msgspec

from rapc.base.source import SourceFile
from rapc.ir.nodes import DefineTest
from rapc.library import loader
from rapc.library.loader import Loaded, Parse
from rapc.parser.parse import parse


class TestFile(msgspec.Struct, frozen=True):
    """A file of tests, and the libraries that they run."""

    __test__ = False

    #: The tests that stand in the file itself, in the order of the text.
    tests: tuple[DefineTest, ...]
    #: A library for each set of required files; it holds the tests that run it alone.
    libraries: tuple[Loaded, ...]


def load_tests(
    source: SourceFile, texts: Mapping[str, str] | None = None, parser: Parse = parse
) -> TestFile:
    """Link what the tests of a file run; there is a library even if it has no tests.

    Args:
        source: the file.
        texts: what stands for the texts of required files, by name.
        parser: what makes units of files.

    Raises:
        LoadError: as `rapc.library.loader.load`.
    """
    whole = loader.load_for_test(source, (), texts, parser)
    own = [test for test in whole.library.tests if test.span.file == source.name]
    groups: dict[tuple[str, ...], list[DefineTest]] = {}
    for test in own:
        names = tuple([form.name for form in test.requires])
        groups.setdefault(names, []).append(test)
    libraries = []
    for names, tests in (groups or {(): []}).items():
        loaded = whole
        if names:
            loaded = loader.load_for_test(source, tests[0].requires, texts, parser)
        libraries.append(_with_tests(loaded, tests))
    return TestFile(tuple(own), tuple(libraries))


def _with_tests(loaded: Loaded, tests: Sequence[DefineTest]) -> Loaded:
    library = msgspec.structs.replace(loaded.library, tests=tuple(tests))
    return msgspec.structs.replace(loaded, library=library)
