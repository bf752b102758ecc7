"""Other texts of a library: files read again, definitions that were typed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from rapc.analysis.driver import CheckReport, check_library
from rapc.base.diagnostics import Severity
from rapc.base.source import SourceFile
from rapc.compiler.program import Program
from rapc.host import CheckedLibrary, CheckError
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.loader import Loaded, load, load_sources
from rapc.parser.parse import parse

TYPED = "<typed>"
"""The file name of definitions that were typed."""


class Renewed(NamedTuple):
    """Another text of a library, and what was found in it."""

    library: CheckedLibrary
    report: CheckReport


def reread(paths: Iterable[str], typed: str, name: str) -> Renewed:
    """Read files again, with the definitions that were typed in place of theirs.

    Raises:
        LoadError: for what cannot be read.
        CheckError: if anything of severity error is found.
    """
    loaded = load(list(paths))
    if typed:
        loaded = load_sources(_with(loaded.files, typed))
    return _checked(loaded, name)


def typed_in(library: Library, typed: str, name: str) -> Renewed:
    """Return a library with typed definitions in place of those of the same names.

    Raises:
        CheckError: if anything of severity error is found.
    """
    return _checked(load_sources(_with(library.files, typed)), name)


def _checked(loaded: Loaded, name: str) -> Renewed:
    report = check_library(loaded)
    errors = [f for f in report.findings if f.severity is Severity.ERROR]
    if errors:
        raise CheckError(CheckReport(tuple(errors), report.files))
    return Renewed(CheckedLibrary(Program(loaded.library, name)), report)


def _with(files: Mapping[str, SourceFile], typed: str) -> list[SourceFile]:
    """Return files without the definitions that were typed anew, and those.

    What is left out is blanked, so that all else stays where it was.
    """
    source = SourceFile(TYPED, typed)
    names = names_of(typed)
    found = []
    for file in files.values():
        if file.name == TYPED:
            continue
        text = file.text
        for form in parse(file).forms:
            if _named(form) in names:
                start, end = form.span.start, form.span.end
                blank = "".join(c if c == "\n" else " " for c in text[start:end])
                text = text[:start] + blank + text[end:]
        found.append(file if text == file.text else SourceFile(file.name, text))
    return [*found, source]


def names_of(text: str) -> frozenset[tuple[str, str]]:
    """Return what tells the definitions of a text from others: kind and name."""
    return frozenset(map(_named, parse(SourceFile(TYPED, text)).forms))


def _named(form: nodes.TopForm) -> tuple[str, str]:
    return type(form).__name__, str(getattr(form, "name", ""))
