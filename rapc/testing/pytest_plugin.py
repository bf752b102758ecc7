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


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the setting that permits tests to name worlds of some modules."""
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
