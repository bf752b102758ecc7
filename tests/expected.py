"""Programs that say in comments what is to be found in them.

`; expect: rule, rule` at the end of a line names the findings on that line. A line
`;;; Opt-in rules: rule, rule` names rules that report there besides the usual ones.
"""

from __future__ import annotations

import re

from rapc.analysis.driver import Finding

_EXPECTED = re.compile(r"; expect: (.*)$")
_OPT_IN = re.compile(r"^;;; Opt-in rules: (.*)$", re.MULTILINE)


def expected(text: str) -> list[tuple[int, str]]:
    """Return the row and the rule of each finding that a program names, sorted."""
    return sorted(
        (row, name.strip())
        for row, line in enumerate(text.split("\n"), start=1)
        if (found := _EXPECTED.search(line))
        for name in found[1].split(",")
    )


def opted_in(text: str) -> frozenset[str]:
    """Return the opt-in rules that a program names."""
    return frozenset(
        name.strip() for row in _OPT_IN.findall(text) for name in row.split(",")
    )


def assert_page_tells_of_the_fix(finding: Finding) -> None:
    """Fail if a finding has a fix whose safety its rule's page does not name."""
    fix, told = finding.diagnostic.fix, finding.rule.fix
    assert fix is None or fix.applicability.value in re.findall(r"\w+", told)
