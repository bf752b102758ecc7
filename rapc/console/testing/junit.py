"""Outcomes as JUnit XML, for the many programs that read it.

One `testcase` for each test, one `testsuite` for each file. All times are 0, and there
are no dates: the same outcomes give the same bytes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import groupby
from xml.etree import ElementTree

from rapc.console.testing import explain
from rapc.testing.run import Outcome, Status

_ILLEGAL = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def as_junit(outcomes: Sequence[Outcome]) -> bytes:
    """The whole file, in UTF-8."""
    top = ElementTree.Element("testsuites", {"name": "rapc", **_counts(outcomes)})
    for file, found in groupby(outcomes, key=lambda o: o.case.test.span.file):
        group = list(found)
        named = {"name": _legal(file), **_counts(group)}
        suite = ElementTree.SubElement(top, "testsuite", named)
        for outcome in group:
            _case(suite, outcome)
    ElementTree.indent(top)
    text = ElementTree.tostring(top, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()


def _counts(outcomes: Sequence[Outcome]) -> dict[str, str]:
    failed = sum(outcome.status is Status.FAILED for outcome in outcomes)
    wrong = sum(outcome.status is Status.ERROR for outcome in outcomes)
    counts = {"tests": len(outcomes), "failures": failed, "errors": wrong, "time": 0}
    return {name: str(count) for name, count in counts.items()}


def _case(suite: ElementTree.Element, outcome: Outcome) -> None:
    test = outcome.case.test
    named = {"classname": _legal(test.span.file), "name": _legal(test.name)}
    case = ElementTree.SubElement(suite, "testcase", {**named, "time": "0"})
    if outcome.status is Status.PASSED:
        return
    kind = "error" if outcome.status is Status.ERROR else "failure"
    message = outcome.failures[0].happened[0]
    told = ElementTree.SubElement(case, kind, {"message": _legal(message)})
    lines = (explain.title(outcome), *(line.text for line in explain.lines(outcome)))
    told.text = _legal("\n".join(lines))


def _legal(text: str) -> str:
    """Text without the characters that XML 1.0 cannot hold."""
    return _ILLEGAL.sub("\N{REPLACEMENT CHARACTER}", text)
