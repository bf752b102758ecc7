"""Rules and their pages: the example breaks the rule, the better program is clean."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import rapc
from rapc.analysis.driver import check_library
from rapc.analysis.registry import rules
from rapc.analysis.selection import Selection, by_default
from rapc.base.diagnostics import Rule, Severity
from rapc.library.loader import load, load_text
from tests.expected import assert_page_tells_of_the_fix

RULES = tuple(rules().values())


@pytest.fixture(params=RULES, ids=[rule.name for rule in RULES])
def rule(request: pytest.FixtureRequest) -> Rule:
    """Each rule in turn."""
    assert isinstance(request.param, Rule)
    return request.param


def _found(text: str, rule: Rule, folder: Path) -> list[str]:
    """The rules that a program breaks, of those that report by default and one more.

    Args:
        text: the program; a line `;;; name.rap` begins a file, if it has several.
        rule: the rule that reports besides.
        folder: where the files of a program of several are put.
    """
    selection = Selection(by_default() | {rule.name})
    _, *files = re.split(r"^;;; ([a-z-]+\.rap)\n", text, flags=re.MULTILINE)
    for name, inside in zip(files[::2], files[1::2], strict=True):
        (folder / name).write_text(inside, encoding="utf-8")
    loaded = load([folder]) if files else load_text(text)
    return [f.rule.name for f in check_library(loaded, selection).findings]


def test_example_breaks_the_rule_and_no_other(rule: Rule, tmp_path: Path) -> None:
    assert _found(rule.page.example, rule, tmp_path) == [rule.name]


def test_better_program_is_clean(rule: Rule, tmp_path: Path) -> None:
    assert _found(rule.page.better, rule, tmp_path) == []


def test_page_is_written_in_house_style(rule: Rule) -> None:
    assert re.fullmatch(r"RAP[0-9]{3}", rule.code)
    assert re.fullmatch(r"[a-z]+(-[a-z]+)*", rule.name)
    assert rule.summary
    assert not rule.summary.endswith(".")
    assert rule.page.why.rstrip().endswith((".", ")"))


def test_page_says_when_to_ignore_it_and_where_to_read_on(rule: Rule) -> None:
    assert rule.ignore or rule.severity is Severity.ERROR
    assert re.fullmatch(
        r"[TSL] [0-9A]+(\.[0-9]+)*(, ([0-9.]+|figure [0-9.]+))*", rule.source
    )
    assert not f"{rule.fix}{rule.ignore}".endswith(".")


def test_page_tells_of_the_fixes_of_its_example(rule: Rule) -> None:
    selection = Selection(by_default() | {rule.name})
    for finding in check_library(load_text(rule.page.example), selection).findings:
        assert_page_tells_of_the_fix(finding)


def test_messages_are_written_in_house_style(rule: Rule) -> None:
    selection = Selection(by_default() | {rule.name})
    for finding in check_library(load_text(rule.page.example), selection).findings:
        said = finding.diagnostic
        for text in (said.message, said.label, *(one.message for one in said.labels)):
            assert not text.endswith(".")
            assert text[:1] == text[:1].lower() or text.startswith("RAP")


def test_rules_and_pages_match() -> None:
    folder = Path(rapc.__file__).parent / "rules"
    assert {path.stem for path in folder.iterdir()} == {rule.name for rule in RULES}


def test_codes_and_names_are_unique() -> None:
    assert len({rule.code for rule in RULES}) == len(RULES)
    assert len({rule.name for rule in RULES}) == len(RULES)
