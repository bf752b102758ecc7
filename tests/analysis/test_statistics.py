"""Thresholds and limits of checks: all of them stand in one module."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import rapc.analysis
from rapc.analysis.facts.statistics import Limits, Thresholds

ANALYSIS = Path(rapc.analysis.__file__).parent

MODULES = sorted([*ANALYSIS.glob("facts/*.py"), *ANALYSIS.glob("checks/*.py")])


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_numbers_stand_in_the_module_of_statistics(path: Path) -> None:
    numbers = [
        target.id
        for node in ast.parse(path.read_text("utf-8")).body
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant)
        for target in node.targets
        if isinstance(node.value.value, int) and isinstance(target, ast.Name)
    ]
    shown = [name for name in numbers if name.startswith("_SHOWN")]
    assert numbers == shown, "write thresholds and limits in facts/statistics.py"


@pytest.mark.parametrize("record", [Thresholds, Limits])
def test_each_number_is_used_by_a_check(record: type) -> None:
    texts = "".join(path.read_text("utf-8") for path in MODULES)
    name = record.__name__.upper()
    unused = [
        field for field in record.__annotations__ if f"{name}.{field}" not in texts
    ]
    assert not unused
