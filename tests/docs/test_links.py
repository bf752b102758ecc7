"""Every link between the pages leads to a file, and to a heading that it has."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[2]
PAGES = sorted({*CHECKOUT.glob("*.md"), *(CHECKOUT / "docs").rglob("*.md")})


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page: those of headings as shown, and `<a id=...>`."""
    text = page.read_text(encoding="utf-8")
    return {
        re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        for heading in re.findall(r"^#+ (.*)$", text, re.M)
    } | {*re.findall(r'<a id="([^"]+)">', text)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.name))
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8"))
    for link in links:
        if link.startswith("https://"):
            continue
        name, _, anchor = link.partition("#")
        there = page.parent / name if name else page
        assert there.exists(), link
        if anchor:
            assert anchor in anchors(there), link


def test_pages_named_by_the_program_exist() -> None:
    sections = "|".join(path.name for path in (CHECKOUT / "docs").iterdir())
    named = re.compile(rf"\b(?:{sections})/[a-z0-9-]+(?![\w/.-])")
    found = {
        name
        for path in (CHECKOUT / "rapc").rglob("*")
        if path.suffix in (".py", ".lark", ".md", ".txt")
        for name in named.findall(path.read_text(encoding="utf-8"))
    }
    assert {"tutorials/first-robot", "how-to/ci", "reference/cli"} <= found
    assert [n for n in sorted(found) if not (CHECKOUT / f"docs/{n}.md").exists()] == []
