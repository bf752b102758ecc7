"""The pytest plug-in: collects `*.test.rap`, one item for each `define-test`.

pytest loads this module in every run, so the module imports the rest of rapc only when
a file is found. The items are in `rapc.console.testing.under_pytest`.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest

SUFFIX = ".test.rap"

_ITEMS = "rapc.console.testing.under_pytest"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add a setting that permits worlds of some modules, and options for coverage."""
    group = parser.getgroup("rapc", "tests in RAP")
    said = "report the coverage of RAP tests; with FILE.json, also as JSON"
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
    """Return a collector for a file of tests; None for any other file."""
    if not file_path.name.endswith(SUFFIX):
        return None
    made = import_module(_ITEMS).RapFile.from_parent(parent, path=file_path)
    collector: pytest.Collector = made
    return collector


def pytest_configure(config: pytest.Config) -> None:
    """Collect and report coverage if one of the options requests it."""
    options = (config.option.rap_coverage, config.option.rap_coverage_min)
    if options != (None, None):
        import_module(_ITEMS).gather_coverage(config)
