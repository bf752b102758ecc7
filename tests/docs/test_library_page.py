"""docs/libraries/truck.md counts the RAPs of the truck library rightly."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

from rapc.library.loader import load

from .pages import CHECKOUT, page, ticked

PAGE = page("libraries/truck")
RAPS = load([CHECKOUT / "stdlib" / "truck"]).library.raps
_JOB = re.compile(r"^\| [^|]+ \| \d+ \| (\d+) \| (\d+) \| (.*) \|$", re.M)


def test_the_jobs_are_counted() -> None:
    raps: Counter[str] = Counter()
    methods: Counter[str] = Counter()
    for rap in RAPS.values():
        raps[Path(rap.span.file).name] += 1
        methods[Path(rap.span.file).name] += len(rap.methods)
    jobs = _JOB.findall(PAGE)
    for told_raps, told_methods, files in jobs:
        names = ticked(files)
        assert sum(raps[name] for name in names) == int(told_raps), files
        assert sum(methods[name] for name in names) == int(told_methods), files
    assert len(jobs) == 8
    assert f"by {len(RAPS)}\nRAPs with {sum(methods.values())} methods" in PAGE
