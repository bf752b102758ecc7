"""Outcomes as JUnit XML, for the many programs that read it.

One `testcase` for each test, one `testsuite` for each file. All times are 0, and there
are no dates: the same outcomes give the same bytes.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from xml.etree import ElementTree

from rapc.console.testing import explain
from rapc.console.xml import as_xml, legal
from rapc.testing.run import Outcome, Status


def as_junit(outcomes: Sequence[Outcome]) -> bytes:
    """The whole file, in UTF-8."""
    top = ElementTree.Element("testsuites", {"name": "rapc", **_counts(outcomes)})
    for file, found in groupby(outcomes, key=lambda o: o.case.test.span.file):
        group = list(found)
        named = {"name": legal(file), **_counts(group)}
        suite = ElementTree.SubElement(top, "testsuite", named)
        for outcome in group:
            _case(suite, outcome)
    return as_xml(top).encode()


def _counts(outcomes: Sequence[Outcome]) -> dict[str, str]:
    failed = sum(outcome.status is Status.FAILED for outcome in outcomes)
    wrong = sum(outcome.status is Status.ERROR for outcome in outcomes)
    counts = {"tests": len(outcomes), "failures": failed, "errors": wrong, "time": 0}
    return {name: str(count) for name, count in counts.items()}


def _case(suite: ElementTree.Element, outcome: Outcome) -> None:
    test = outcome.case.test
    named = {"classname": legal(test.span.file), "name": legal(test.name)}
    case = ElementTree.SubElement(suite, "testcase", {**named, "time": "0"})
    if outcome.status is Status.PASSED:
        return
    kind = "error" if outcome.status is Status.ERROR else "failure"
    message = legal(explain.reason(outcome))
    told = ElementTree.SubElement(case, kind, {"message": message})
    lines = (
        explain.test_title(outcome),
        *(line.text for line in explain.failure_lines(outcome)),
    )
    told.text = legal("\n".join(lines))
