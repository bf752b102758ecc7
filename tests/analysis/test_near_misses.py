"""Programs that a slip of the pen turns into ones with a finding, and each such slip.

`tests/analysis/near/*.rap` tell of slips in comments (`tests.slips_said`): as it stands
a program is a near miss of each rule that it names, with the slip it triggers the rule.
A rule's own page is one more such pair (`test_rules`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from rapc.analysis.driver import check_library
from rapc.analysis.registry import rules
from rapc.analysis.selection import Selection, by_default, rule_names
from rapc.library.loader import load_text
from tests.expected import assert_page_tells_of_the_fix, expected, opted_in
from tests.slips_said import slips, without

PROGRAMS = sorted((Path(__file__).parent / "near").glob("*.rap"))


def _stem(path: Path) -> str:
    return path.stem


def _found(text: str, selection: Selection) -> Counter[tuple[int, str]]:
    """Count the findings in a text, by row and rule."""
    report = check_library(load_text(text), selection)
    for finding in report.findings:
        assert_page_tells_of_the_fix(finding)
    own = [f for f in report.findings if f.diagnostic.span.file == "<text>"]
    file = report.files["<text>"]
    return Counter(
        (file.position(f.diagnostic.span.start).row, f.rule.name) for f in own
    )


@pytest.mark.parametrize("program", PROGRAMS, ids=_stem)
def test_each_slip_has_the_findings_that_are_told_of_it(program: Path) -> None:
    text = program.read_text(encoding="utf-8")
    selection = Selection(by_default() | rule_names(opted_in(text)))
    standing = Counter(expected(text))
    assert _found(without(text), selection) == standing
    wrong = {
        (program.name, slip.row): found
        for slip in slips(text)
        if (found := _found(slip.text, selection)) != standing + Counter(slip.findings)
    }
    assert wrong == {}


def test_each_rule_has_three_triggers_and_three_near_misses() -> None:
    pairs = Counter(dict.fromkeys(rules(), 1))
    pairs.update(_named())
    few = {name: count for name, count in pairs.items() if count < _LEAST}
    assert few == {}


_LEAST = 3
"""So many pairs of a near miss and a trigger a rule has, that of its page included."""


def _named() -> Iterator[str]:
    """Yield the rules that slips trigger, each once for a slip.

    What is wrong in libraries of several files is right there when it is mended
    (`test_missing_require`).
    """
    for file in PROGRAMS[0].parents[1].glob("several/*/*.rap"):
        yield from {name for _, name in expected(file.read_text(encoding="utf-8"))}
    for program in PROGRAMS:
        for slip in slips(program.read_text(encoding="utf-8")):
            yield from {name for _, name in slip.findings}
