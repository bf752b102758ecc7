"""Programs that say in comments what is to be found in them.

`; expect: rule, rule` at the end of a line names the findings on that line. Missing and
surplus ones both fail. A new pass brings `tests/analysis/<fault>.rap`, no new test.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from rapc.analysis import suite
from rapc.analysis.driver import check_library
from rapc.analysis.selection import Selection, by_default, rule_names
from rapc.library.loader import load
from tests.expected import expected, opted_in

PROGRAMS = sorted(Path(__file__).parent.glob("*.rap"))


def _stem(path: Path) -> str:
    return path.stem


def test_there_are_programs() -> None:
    assert len(PROGRAMS) > 5


@pytest.mark.parametrize("program", PROGRAMS, ids=_stem)
def test_program_has_the_findings_it_names(program: Path) -> None:
    text = program.read_text(encoding="utf-8")
    selection = Selection(by_default() | rule_names(opted_in(text)))
    report = check_library(load([program]), selection)
    found_there = [
        (report.files[f.diagnostic.span.file], f.diagnostic.span.start, f.rule.name)
        for f in report.findings
    ]
    actual = [(file.position(at).row, name) for file, at, name in found_there]
    assert sorted(actual) == expected(text)


def test_each_rule_of_a_pass_has_three_triggers() -> None:
    """Rules that look at several files at once have tests of their own."""
    texts = [program.read_text(encoding="utf-8") for program in PROGRAMS]
    often = Counter(name for text in texts for _, name in expected(text))
    rules = [rule.name for analyzer in suite.ANALYZERS for rule in analyzer.rules]
    few = {name: often[name] for name in rules if often[name] < _LEAST}
    assert few == {}


_LEAST = 3
