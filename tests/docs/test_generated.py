"""The generated parts of the manual are fresh and complete."""

from __future__ import annotations

import re
import subprocess
import sys

from rapc import events, world
from rapc.cli.main import COMMANDS
from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.heads import rules_by_head

from .pages import CHECKOUT, page

GENERATE = CHECKOUT / "docs" / "generate.py"


def parts(name: str, kind: str) -> list[str]:
    """Return the words of the markers of a kind on a page."""
    found = re.findall(rf"^<!-- generated: {kind} (.+) -->$", page(name), re.M)
    return " ".join(found).split()


def test_no_generated_page_is_stale() -> None:
    """If this fails: `python docs/generate.py`."""
    done = subprocess.run(
        [sys.executable, GENERATE, "--check"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.stdout, done.stderr, done.returncode) == ("", "", 0)


def test_pages_have_the_parts_of_all_commands_and_events() -> None:
    assert parts("reference/cli", "command") == [*COMMANDS]
    named = parts("reference/trace", "events")
    assert len(named) == len({*named})
    assert {*named} == {*events.kinds()}


def test_page_of_worlds_has_the_parts_of_all_names() -> None:
    named = [one for one in parts("reference/worlds-api", "api") if one != "rapc.world"]
    assert sorted(named) == sorted(world.__all__)


def test_each_list_with_a_head_has_a_meaning() -> None:
    groups = (
        "_form",
        "define_rap",
        "method",
        "formula",
        "call",
        "_test_clause",
        "expectation",
    )
    heads = {rule for group in groups for rule in rules_by_head(group).values()}
    lists = {rule for rule in heads if RULES[rule][0] == "list"}
    assert lists <= {rule for rule, row in GRAMMAR.items() if row.says}


def test_figures_are_drawn_before_the_site_is_built() -> None:
    """A browser would draw a Mermaid block with a script of another host."""
    pages = (CHECKOUT / "docs").rglob("*.md")
    assert [file for file in pages if "```mermaid" in file.read_text("utf-8")] == []
