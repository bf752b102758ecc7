"""docs/architecture.md draws the house as it stands, every module in its order."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]
WHOLE = (
    "analysis/passes",
    "parser/forms",
    "runtime/memory/recognition",
    "testing",
    "worlds/truck",
)
"""Folders that the page describes without naming each file."""


def _drawing() -> str:
    page = (CHECKOUT / "docs" / "architecture.md").read_text(encoding="utf-8")
    return page.split("```")[1]


def _modules() -> Iterator[tuple[str, str]]:
    """Each module's folder below `rapc/` and its file name."""
    package = CHECKOUT / "rapc"
    for path in package.rglob("*.py"):
        if path.name != "__init__.py":
            yield path.relative_to(package).parent.as_posix(), path.name


def test_drawing_names_every_module_and_no_other() -> None:
    named = set(re.findall(r"\b[a-z_]+\.py\b", _drawing()))
    assert named <= {name for _, name in _modules()}
    assert {name for folder, name in _modules() if folder not in WHOLE} <= named


def test_drawing_has_the_order_of_the_import_contract() -> None:
    config = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = config["tool"]["importlinter"]["contracts"]
    [layers] = [c["layers"] for c in contracts if c["id"] == "layers"]
    drawn = re.findall(r"^  ([a-z]+)(?:\.py|/) ", _drawing(), re.M)
    assert list(reversed(drawn)) == layers
