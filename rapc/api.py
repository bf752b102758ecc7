"""From paths to a library in executable form, for commands and programs that run RAPs.

A compiled library (`rapc.compiler.artifact`) may stand in the place of its sources.
A library with errors becomes an exception that carries the findings; printing them is
for who catches it.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rapc.analysis.driver import Report, check_library
from rapc.base import files
from rapc.base.diagnostics import Severity
from rapc.base.source import SourceFile
from rapc.compiler.artifact import Artifact
from rapc.compiler.program import Program
from rapc.library import loader
from rapc.library.loader import Loaded

PLAN = "<plan>"
"""The file name of what `extend` adds, in findings and faults."""


class CheckError(Exception):
    """A library with findings of severity error; `report` holds them alone."""

    def __init__(self, report: Report) -> None:
        first = report.findings[0].diagnostic
        count = len(report.findings) - 1
        more = f", and {count} more" if count else ""
        super().__init__(f"{first.span.file}: {first.message}{more}")
        self.report = report


def compile_library(*paths: str | Path) -> Program:
    """Load, check and compile files and folders as one library, or read a compiled one.

    Raises:
        LoadError: for what cannot be read.
        SavedError: for a compiled library that this rapc cannot run.
        CheckError: if anything of severity error is found.
    """
    artifact = read_artifact(*paths)
    if artifact is not None:
        return artifact.library
    return compile_loaded(loader.load(paths), ", ".join(map(str, paths)))


def load(paths: Iterable[str | Path], *, tests: bool = False) -> Loaded:
    """As `loader.load`; of a compiled library without diagnostics and comments.

    Raises:
        LoadError: for what cannot be read.
        SavedError: for a compiled library that this rapc cannot run.
    """
    paths = list(paths)
    artifact = read_artifact(*paths)
    if artifact is not None:
        return Loaded(artifact.whole(), (), ())
    return loader.load(paths, tests=tests)


def read_artifact(*paths: str | Path) -> Artifact | None:
    """The compiled library that a single path leads to; None for anything else.

    Raises:
        LoadError: if it cannot be read.
        SavedError: if this rapc cannot run it.
    """
    data = files.read_compiled(paths[0]) if len(paths) == 1 else None
    return None if data is None else Artifact(data, str(paths[0]))


def compile_loaded(loaded: Loaded, name: str) -> Program:
    """Check and compile what was loaded; `name` is what traces call it.

    Raises:
        CheckError: if anything of severity error is found.
    """
    report = check_library(loaded)
    errors = tuple(f for f in report.findings if f.severity is Severity.ERROR)
    if errors:
        raise CheckError(Report(errors, report.library))
    return Program(report.library, name)


def extend(library: Program, text: str) -> Program:
    """A library with the RAPs of a text added, checked together: a sketchy plan.

    `Interpreter.extend` takes it up while a run goes on (T 4.10.1).

    Raises:
        CheckError: if anything of severity error is found.
    """
    sources = [*library.library.files.values(), SourceFile(PLAN, text)]
    return compile_loaded(loader.load_sources(sources), library.name)
