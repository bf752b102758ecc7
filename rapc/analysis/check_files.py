"""Check files by path: a test file alone, all other files as one library.

`rapc.library.loader` determines which files a test file runs with. The library of all
other files decides about the files in that library. A test may require a part of the
library; there only errors count, because an error prevents the test from running.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping

from rapc.analysis.driver import CheckReport, check_libraries
from rapc.analysis.selection import Selection
from rapc.base.files import TEST_SUFFIX, path_of
from rapc.library import loader
from rapc.library.loader import Loaded, Names, Parse, Units, alike, load_tests


def check_files(
    paths: Iterable[str],
    selection: Selection | None = None,
    texts: Mapping[str, str] | None = None,
    *,
    parser: Parse | None = None,
) -> CheckReport:
    """Check files and folders; a test file is checked as it is run.

    Args:
        paths: files, folders (all `.rap` files below), `-` for standard input.
        selection: the rules that may report; None for all rules that are not opt-in.
        texts: by file name, a text that replaces the text of the file.
        parser: the function that parses a file; None to parse each file once.

    Raises:
        LoadError: if a path cannot be read.
    """
    given = list(paths)
    loads = loaded_libraries(given, texts, parser or Units())
    return check_libraries(loads, selection, given)


def loaded_libraries(
    paths: Iterable[str],
    texts: Mapping[str, str] | None,
    parser: Parse,
    names: Names | None = None,
) -> Iterator[Loaded]:
    """Yield the library of all files, then a library for each test file.

    For the arguments and errors see `check_files`; `names` are the names of files,
    shared by several libraries.
    """
    given = list(dict.fromkeys(paths))
    named = [path for path in given if path.endswith(TEST_SUFFIX)]
    others = [path for path in given if path not in named]
    folders = [path for path in others if os.path.isdir(path_of(path))]
    names = {} if names is None else names
    yield loader.load(others, texts=texts, parser=parser, names=names)
    for sources in alike(loader.read_tests([*named, *folders], texts), parser):
        yield from load_tests(sources, texts, parser, names).libraries
