"""docs/library-truck-beyond.md names each RAP of the library in its file."""

from __future__ import annotations

import re
from pathlib import Path

from rapc.library.loader import load

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "library-truck-beyond.md").read_text(encoding="utf-8")
FOLDER = ROOT / "stdlib" / "truck-beyond"
_NAMES = re.compile(r"`([^`]+)`")


def test_the_table_has_every_rap_in_its_file() -> None:
    raps = load([FOLDER]).library.raps
    own = {
        name: Path(rap.span.file).name
        for name, rap in raps.items()
        if Path(rap.span.file).parent.name == FOLDER.name
    }
    [table] = re.findall(r"^\| file \|.*?\n(?=\n)", PAGE, re.M | re.S)
    told: dict[str, str] = {}
    file = ""
    for row in table.strip().splitlines()[2:]:
        named, listed, _ = row.strip("|").split("|")
        file = "".join(_NAMES.findall(named)) or file
        told |= dict.fromkeys(_NAMES.findall(listed), file)
    assert own
    assert told == own
