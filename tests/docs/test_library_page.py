"""docs/library-truck.md names each RAP of the truck library and counts them rightly."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from rapc.library.loader import load

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "library-truck.md").read_text(encoding="utf-8")
RAPS = load([ROOT / "stdlib" / "truck"]).library.raps
_NAMES = re.compile(r"`([^`]+)`")
_JOB = re.compile(r"^\| [^|]+ \| \d+ \| (\d+) \| (\d+) \| (.*) \|$", re.M)


def test_the_table_of_layers_has_every_rap_in_its_file() -> None:
    [table] = re.findall(r"^\| layer \|.*?\n(?=\n)", PAGE, re.M | re.S)
    told: dict[str, str] = {}
    file = ""
    for row in table.strip().splitlines()[2:]:
        _, named, raps, _ = row.strip("|").split("|")
        file = "".join(_NAMES.findall(named)) or file
        told |= dict.fromkeys(_NAMES.findall(raps), file)
    assert told == {name: Path(rap.span.file).name for name, rap in RAPS.items()}


def test_the_jobs_are_counted() -> None:
    raps: Counter[str] = Counter()
    methods: Counter[str] = Counter()
    for rap in RAPS.values():
        raps[Path(rap.span.file).name] += 1
        methods[Path(rap.span.file).name] += len(rap.methods)
    jobs = _JOB.findall(PAGE)
    for told_raps, told_methods, files in jobs:
        names = _NAMES.findall(files)
        assert sum(raps[name] for name in names) == int(told_raps), files
        assert sum(methods[name] for name in names) == int(told_methods), files
    assert len(jobs) == 8
    assert f"by {len(RAPS)}\nRAPs with {sum(methods.values())} methods" in PAGE
