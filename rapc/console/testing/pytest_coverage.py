"""What tests in RAP exercise of libraries, gathered and told under pytest."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.base.outputs import COVERAGE, check_output
from rapc.console.testing import coverage_table
from rapc.errors import WriteError
from rapc.testing.coverage import Coverage


class PytestCoverage:
    """Gathers the coverage of one session of pytest, and tells it at the end.

    Args:
        config: says where it is written, and how much is asked for.

    Raises:
        UsageError: where several processes run the tests, each of which would see a
            part, and for a file that may not be written.
    """

    def __init__(self, config: pytest.Config) -> None:
        if getattr(config.option, "numprocesses", None) or hasattr(
            config, "workerinput"
        ):
            raise pytest.UsageError("--rap-coverage needs all tests in one process")
        self.gathered = Coverage()
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
        """Write the file, and fail a session that falls short of what is asked for."""
        files = self.gathered.files()
        if self._file:
            Path(self._file).write_bytes(coverage_table.as_json(files))
        short = coverage_table.verdict(files, self._least or 0)[0]
        if short and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(
        self, terminalreporter: pytest.TerminalReporter
    ) -> None:
        """Say what `rapc test --coverage` would say."""
        files = self.gathered.files()
        terminalreporter.section("coverage of RAP libraries")
        for line in coverage_table.table(files):
            terminalreporter.write_line(line)
        if self._least is not None:
            terminalreporter.write_line(coverage_table.verdict(files, self._least)[1])
