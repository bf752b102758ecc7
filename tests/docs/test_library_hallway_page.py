"""docs/library-hallway.md names each RAP of the hallway library, in its file."""

from __future__ import annotations

import re
from pathlib import Path

from rapc.library.loader import load

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "library-hallway.md").read_text(encoding="utf-8")


def test_the_table_of_layers_has_every_rap_in_its_file() -> None:
    raps = load([ROOT / "stdlib" / "hallway"]).library.raps
    [table] = re.findall(r"^\| layer \|.*?\n(?=\n)", PAGE, re.M | re.S)
    told: dict[str, str] = {}
    file = ""
    for row in table.strip().splitlines()[2:]:
        _, named, does, _ = row.strip("|").split("|")
        file = "".join(re.findall(r"`([^`]+)`", named)) or file
        told |= dict.fromkeys(re.findall(r"`([^`]+)`", does), file)
    assert told == {name: Path(rap.span.file).name for name, rap in raps.items()}
