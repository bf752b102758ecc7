"""The pytest plug-in: collects `*.test.rap`, one item for each `define-test`.

pytest loads this module in every run, so nothing of rapc is imported before a file is
found. The items are in `rapc.console.testing.pytest_items`.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

SUFFIX = ".test.rap"


COVERAGE = "rap_coverage"
"""The name under which the configuration has what the tests exercise, if asked for."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add a setting that permits worlds of some modules, and options for coverage."""
    group = parser.getgroup("rapc", "tests in RAP")
    said = "say what the tests in RAP exercise of their libraries; write it as JSON"
    group.addoption(
        "--rap-coverage", nargs="?", const="", metavar="FILE.json", help=said
    )
    said = "fail if the tests in RAP exercise less than N per cent"
    group.addoption("--rap-coverage-min", type=float, metavar="N", help=said)
    told = "modules of which tests in RAP may name worlds, as `module:Class`"
    parser.addini("rap_world_modules", told, type="linelist", default=[])


def pytest_collect_file(
    file_path: Path, parent: pytest.Collector
) -> pytest.Collector | None:
    """A collector for a file of tests; None for any other file."""
    if not file_path.name.endswith(SUFFIX):
        return None
    items = import_module("rapc.console.testing.pytest_items")
    collector: pytest.Collector = items.RapFile.from_parent(parent, path=file_path)
    return collector


def pytest_configure(config: pytest.Config) -> None:
    """Have coverage gathered and told, where one of the options asks for it."""
    options = (config.option.rap_coverage, config.option.rap_coverage_min)
    if options != (None, None):
        told = import_module("rapc.console.testing.pytest_coverage")
        config.pluginmanager.register(told.PytestCoverage(config), COVERAGE)
