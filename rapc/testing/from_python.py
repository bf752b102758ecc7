"""Tests run by a Python program: `rapc.test`."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import ClassVar

import msgspec

from rapc.base.source import place
from rapc.errors import ArgumentError
from rapc.host import CheckError
from rapc.language.atoms import kind
from rapc.runtime.arguments import need_call, need_seed
from rapc.runtime.events.recorder import Listener
from rapc.testing.discover import find
from rapc.testing.run import Outcome, run_case

TEXT = "<text>"
"""The file name of tests in a text."""


class TestResult(msgspec.Struct, frozen=True):
    """The result of one `define-test` under one seed."""

    #: Keeps pytest from collecting the class as a test.
    __test__: ClassVar[bool] = False

    name: str
    #: The file and row of the test.
    file: str
    row: int
    #: The seed of the run: the seed of the test, if it has one.
    seed: int
    #: `passed`, `failed`, or `error` if the test itself has an error.
    outcome: str
    #: The reasons why the test did not pass, each line with its file, row and column.
    reasons: tuple[str, ...] = ()
    #: The last lines of the trace of a run that did not pass.
    trace: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether the test passed."""
        return self.outcome == "passed"


def test(
    *sources: str | os.PathLike[str],
    seed: int = 0,
    listener: Listener | None = None,
    modules: Iterable[str] = (),
) -> tuple[TestResult, ...]:
    """Run the tests of some files, folders, compiled libraries or texts.

    Args:
        sources: paths, as for `rapc test`, or a text with tests: a `str` that begins
            with `(` or `;`.
        seed: the seed of each test without its own seed.
        listener: called with every event of every run.
        modules: the modules of which tests may name worlds, as `module:Class`.

    Returns:
        A result for each test, in the order of the text.

    Raises:
        ArgumentError: for no source, a source of another type, and no test in any
            source.
        LoadError: for a path that cannot be read.
        SavedError: for a compiled library that this rapc cannot run.
        CheckError: for errors in a library that tests run.
    """
    need_seed(seed)
    if listener is not None:
        need_call(listener, "`listener`")
    if isinstance(modules, str) or not isinstance(modules, Iterable):
        raise ArgumentError(f"`modules` is {kind(modules)}, not a list of names")
    permitted = tuple(modules)
    found = find(*_named(sources))
    for report in found.reports:
        raise CheckError(report)
    if not found.cases:
        raise ArgumentError("no tests found in the sources given")
    return tuple(
        _result(run_case(case, seed, listener=listener, modules=permitted))
        for case in found.cases
    )


test.__test__ = False  # type: ignore[attr-defined]  # pytest is not to collect it


def _named(sources: tuple[object, ...]) -> tuple[list[str], dict[str, str]]:
    """Return the names of sources, in order, and the texts among the sources."""
    names: list[str] = []
    texts: dict[str, str] = {}
    for source in sources:
        if not isinstance(source, str | os.PathLike):
            raise ArgumentError(f"a source is {kind(source)}, neither path nor text")
        name = os.fspath(source)
        if isinstance(source, str) and source.lstrip().startswith(("(", ";")):
            name = f"<text-{len(texts) + 1}>" if texts else TEXT
            texts[name] = source
        names.append(str(name))
    if not names:
        raise ArgumentError("no tests are given")
    return names, texts


def _result(outcome: Outcome) -> TestResult:
    case = outcome.case
    files, span = case.library.library.files, case.test.span
    file = files.get(span.file)
    reasons = [
        f"{place(failure.span, files)}: {line}"
        for failure in outcome.failures
        for line in failure.happened
    ]
    return TestResult(
        case.test.name,
        span.file,
        0 if file is None else file.row(span.start),
        outcome.seed,
        outcome.status.value,
        (*reasons, outcome.note) if outcome.note else tuple(reasons),
        outcome.trace,
    )
