"""The layers in docs/developers/architecture.md are those of the import contract."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

CHECKOUT = Path(__file__).parents[2]


def _drawing() -> str:
    page = (CHECKOUT / "docs" / "developers" / "architecture.md").read_text(
        encoding="utf-8"
    )
    return page.split("```")[1]


def test_drawing_has_the_order_of_the_import_contract() -> None:
    config = tomllib.loads((CHECKOUT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = config["tool"]["importlinter"]["contracts"]
    [layers] = [c["layers"] for c in contracts if c["id"] == "layers"]
    drawn = re.findall(r"^  ([a-z_]+)(?:\.py|/) ", _drawing(), re.M)
    assert list(reversed(drawn)) == layers
