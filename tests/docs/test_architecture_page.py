"""docs/architecture.md draws the house as it stands, every module in its order."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
WHOLE = ("parser/forms", "analysis/passes", "worlds/truck")
"""Folders that the page describes without naming each file."""


def _drawing() -> str:
    page = (CHECKOUT / "docs" / "architecture.md").read_text(encoding="utf-8")
    return page.split("```")[1]


def _modules() -> set[str]:
    package = CHECKOUT / "rapc"
    files = {path.relative_to(package) for path in package.rglob("*.py")}
    return {
        path.name
        for path in files
        if path.name != "__init__.py" and path.parent.as_posix() not in WHOLE
    }


def test_drawing_names_every_module_and_no_other() -> None:
    named = set(re.findall(r"\b[a-z_]+\.py\b", _drawing()))
    assert named == _modules() | {"table.py"}


def test_drawing_has_the_order_of_the_import_contract() -> None:
    config = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = config["tool"]["importlinter"]["contracts"]
    [layers] = [c["layers"] for c in contracts if c["id"] == "layers"]
    drawn = re.findall(r"^  ([a-z]+)(?:\.py|/) ", _drawing(), re.M)
    assert list(reversed(drawn)) == layers
