"""Our own RAP code, read as one library: no finding, no silence without a reason.

The laboratory is a library of its own: its words have other meanings.
"""

from __future__ import annotations

import re
from pathlib import Path

from rapc.analysis.driver import check_library
from rapc.library.loader import load

ROOT = Path(__file__).parent.parent.parent
FOLDERS = (ROOT / "stdlib", ROOT / "examples")
LABORATORY = ROOT / "examples" / "laboratory"
_SUPPRESSION = re.compile(r";+ *rapc: *(?:file-)?ignore\[[^]]*\](?P<reason>.*)")


def test_nothing_is_found_in_libraries_and_examples_together() -> None:
    examples = [path for path in (ROOT / "examples").iterdir() if path != LABORATORY]
    read = [path for path in examples if path.is_dir() or path.suffix == ".rap"]
    report = check_library(load([ROOT / "stdlib", *sorted(read)]))
    assert report.raps > 200
    assert [f.diagnostic.message for f in report.findings] == []


def test_each_suppression_says_why() -> None:
    reasons = {
        f"{path.name}: {found[0]}": len(found["reason"].split())
        for folder in FOLDERS
        for path in folder.rglob("*.rap")
        for found in _SUPPRESSION.finditer(path.read_text(encoding="utf-8"))
    }
    assert reasons
    assert {said: words for said, words in reasons.items() if words < _WORDS} == {}


_WORDS = 3
"""A reason of fewer words says none."""
