"""The items that pytest collects: files of tests, each `define-test`, coverage."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from rapc.base.outputs import COVERAGE, check_output
from rapc.console.findings import concise
from rapc.console.testing import explain
from rapc.errors import Error, WriteError
from rapc.testing import coverage, discover
from rapc.testing.run import Case, Outcome, Status, run_case

_COVERAGE = "rap_coverage"
"""The name of the coverage plug-in of a pytest session."""


def gather_coverage(config: pytest.Config) -> None:
    """Collect coverage in a session, and report it at the end."""
    config.pluginmanager.register(PytestCoverage(config), _COVERAGE)


class RapFile(pytest.File):
    """A `*.test.rap` file."""

    def collect(self) -> Iterator[RapTest]:
        """Yield its tests; raise an error if the file or a library has errors.

        Raises:
            CollectError: with the errors, one line each.
        """
        try:
            found = discover.find([os.path.relpath(self.path)])
        except Error as error:
            raise self.CollectError(str(error)) from None
        if found.reports:
            lines = [line for r in found.reports for line in concise(r)]
            raise self.CollectError("\n".join(lines))
        for case in found.cases:
            yield RapTest.from_parent(self, name=case.test.name, case=case)

    def repr_failure(  # type: ignore[override]  # pytest passes no style for a file
        self, excinfo: pytest.ExceptionInfo[BaseException]
    ) -> Any:
        """Return the errors of the file; the summary has the first line."""
        if not isinstance(excinfo.value, self.CollectError):
            return super().repr_failure(excinfo)
        first = str(excinfo.value).partition("\n")[0]
        return _shown(excinfo, (str(self.path), 1), first)


class RapTestFailure(Exception):
    """A test that did not pass, with its outcome."""

    def __init__(self, outcome: Outcome) -> None:
        lines = [line.text for line in explain.failure_lines(outcome)]
        super().__init__("\n".join(lines))
        self.outcome = outcome


class RapTest(pytest.Item):
    """One `define-test`, run under seed 0."""

    #: No fixtures; plug-ins for Python tests read this of every item.
    funcargs: Mapping[str, object] = {}

    def __init__(self, *, case: Case, **more: Any) -> None:
        super().__init__(**more)
        self.case = case

    def runtest(self) -> None:
        """Run the test. Raises RapTestFailure if it does not pass."""
        modules: list[str] = self.config.getini("rap_world_modules")
        told = self.config.pluginmanager.get_plugin(_COVERAGE)
        gathered = None if told is None else told.gathered
        outcome = run_case(self.case, coverage=gathered, modules=modules)
        if outcome.status is not Status.PASSED:
            raise RapTestFailure(outcome)

    def repr_failure(
        self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None
    ) -> Any:
        """Return the output of `rapc test`; the summary has the reason."""
        if not isinstance(excinfo.value, RapTestFailure):
            return super().repr_failure(excinfo, style)
        outcome = excinfo.value.outcome
        span = outcome.failures[0].span
        source = outcome.case.library.library.files.get(span.file)
        row = 1 if source is None else source.row(span.start)
        return _shown(excinfo, (span.file, row), explain.reason(outcome))

    def reportinfo(self) -> tuple[Path, int, str]:
        """Return the file, the row of the test from 0, and its name."""
        span = self.case.test.span
        source = self.case.library.library.files[span.file]
        return self.path, source.position(span.start).row - 1, self.name


def _shown(
    excinfo: pytest.ExceptionInfo[BaseException], where: tuple[str, int], reason: str
) -> Any:
    """Return the text of an exception, without a traceback, and a summary.

    Args:
        excinfo: the exception.
        where: the file and row of the failure, for `--tb=line`.
        reason: a line for the summary and for JUnit.
    """
    shown = excinfo.getrepr(style="value")
    if shown.reprcrash is not None:
        shown.reprcrash.path, shown.reprcrash.lineno = where
        shown.reprcrash.message = reason
    return shown


class PytestCoverage:
    """A collector of the coverage of one pytest session, reported at the end.

    Args:
        config: the output file, and the required coverage.

    Raises:
        UsageError: if several processes run the tests, because each would see only a
            part, and for a file that may not be written.
    """

    def __init__(self, config: pytest.Config) -> None:
        if getattr(config.option, "numprocesses", None) or hasattr(
            config, "workerinput"
        ):
            raise pytest.UsageError("--rap-coverage requires all tests in one process")
        self.gathered = coverage.Coverage()
        self._file: str | None = config.option.rap_coverage
        if self._file:
            try:
                check_output(self._file, COVERAGE)
            except WriteError as error:
                raise pytest.UsageError(
                    f"--rap-coverage: {error.message}; {error.help}"
                ) from None
        self._least: float | None = config.option.rap_coverage_min

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Write the file, and fail a session below the required coverage."""
        files = self.gathered.files()
        if self._file:
            Path(self._file).write_bytes(coverage.as_json(files))
        short = coverage.verdict(files, self._least or 0)[0]
        if short and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(
        self, terminalreporter: pytest.TerminalReporter
    ) -> None:
        """Print the report of `rapc test --coverage`."""
        files = self.gathered.files()
        terminalreporter.section("coverage of RAP libraries")
        for line in coverage.table(files):
            terminalreporter.write_line(line)
        if self._least is not None:
            terminalreporter.write_line(coverage.verdict(files, self._least)[1])
