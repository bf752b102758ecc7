"""JUnit XML of findings and of outcomes of tests.

All times are 0, and there are no dates: equal cases give equal bytes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple
from xml.etree import ElementTree

_ILLEGAL = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class JUnitCase(NamedTuple):
    """A test, or a finding in the form of a failed test."""

    name: str
    #: `failure`, `error`, or no text for a case that passed.
    kind: str = ""
    #: The texts of a failure: attributes, and the full text.
    told: Mapping[str, str] = {}
    text: str = ""


Suites = Sequence[tuple[str, Sequence[JUnitCase]]]
"""The cases of each file."""

COUNTS = ("tests", "failures", "errors", "time")
"""The attributes of a suite that are counts."""


def junit(
    name: str,
    suites: Suites,
    of_all: Sequence[str] = COUNTS,
    of_each: Sequence[str] = COUNTS,
) -> str:
    """Return a whole file: a suite for each file with its cases.

    Args:
        name: the name of the whole.
        suites: the cases.
        of_all: the counts of all suites together, of `COUNTS`.
        of_each: the counts of each suite.
    """
    all_ = [case for _, cases in suites for case in cases]
    top = ElementTree.Element("testsuites", {"name": name, **_counts(all_, of_all)})
    for file, cases in suites:
        named = {"name": _legal(file), **_counts(cases, of_each)}
        suite = ElementTree.SubElement(top, "testsuite", named)
        for case in cases:
            named = {"classname": _legal(file), "name": _legal(case.name), "time": "0"}
            made = ElementTree.SubElement(suite, "testcase", named)
            if case.kind:
                told = {key: _legal(value) for key, value in case.told.items()}
                failure = ElementTree.SubElement(made, case.kind, told)
                failure.text = _legal(case.text)
    ElementTree.indent(top)
    text = ElementTree.tostring(top, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _counts(cases: Iterable[JUnitCase], names: Sequence[str]) -> dict[str, str]:
    kinds = [case.kind for case in cases]
    counts = (len(kinds), kinds.count("failure"), kinds.count("error"), 0)
    found = dict(zip(COUNTS, map(str, counts), strict=True))
    return {name: found[name] for name in names}


def _legal(text: str) -> str:
    """Return text without the characters that XML 1.0 cannot hold."""
    return _ILLEGAL.sub("\N{REPLACEMENT CHARACTER}", text)
