"""docs/research/hallway.md names tests of each paragraph."""

from __future__ import annotations

import re
from pathlib import Path

from tests.docs.pages import rows, ticked

ROOT = Path(__file__).parents[2]
FILE = ROOT / "docs" / "research" / "hallway.md"
PAGE = FILE.read_text(encoding="utf-8")


def test_every_test_of_the_table_of_paragraphs_is_there() -> None:
    listed = rows(PAGE, "paragraph")
    texts = [
        file.read_text(encoding="utf-8")
        for folder in ("stdlib/hallway", "tests/rap", "tests/hallway")
        for file in (ROOT / folder).iterdir()
        if file.name.endswith((".test.rap", ".py"))
    ]
    defined = set(
        re.findall(r"^(?:\(define-test|def) ([\w-]+)", "\n".join(texts), re.M)
    )
    named = {name for row in listed for name in ticked(row[-1])}
    assert named <= defined
    paragraphs = {row[0].strip() for row in listed}
    assert paragraphs == {"3", "3.1", "3.2", "3.3", "4", "4.1", "4.2", "4.2.1", "4.3"}
