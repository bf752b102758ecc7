"""JUnit files: one case for each test, well-formed, the same each time."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from rapc.console.testing.explain import as_junit

from .small_suite import run


def _parsed(data: bytes) -> ElementTree.Element:
    return ElementTree.fromstring(data)  # noqa: S314  # written a line above


def test_cases_are_counted_and_told(tmp_path: Path) -> None:
    outcomes = [
        run(tmp_path, ""),
        run(tmp_path, "(expect (memory (have <box&co>)))"),
        run(tmp_path, "(world nowhere)"),
    ]
    top = _parsed(as_junit(outcomes))
    assert top.tag == "testsuites"
    counts = {"tests": "3", "failures": "1", "errors": "1", "time": "0"}
    assert top.attrib == {"name": "rapc", **counts}
    (suite,) = top
    assert suite.attrib == {"name": str(tmp_path / "it.test.rap"), **counts}
    assert [case.tag for case in suite] == ["testcase"] * 3
    assert [[told.tag for told in case] for case in suite] == [
        [],
        ["failure"],
        ["error"],
    ]
    assert suite[1][0].get("message") == "no fact `have` is in memory"
    assert "(memory (have <box&co>))" in (suite[1][0].text or "")
    assert suite[0].attrib == {
        "classname": str(tmp_path / "it.test.rap"),
        "name": "it",
        "time": "0",
    }


def test_invalid_xml_characters_are_replaced(tmp_path: Path) -> None:
    outcome = run(tmp_path, '(expect (memory (have "bell \x07")))')
    text = _parsed(as_junit([outcome]))[0][0][0].text or ""
    assert '(have "bell \N{REPLACEMENT CHARACTER}")' in text


def test_the_same_outcomes_give_the_same_bytes(tmp_path: Path) -> None:
    found = [as_junit([run(tmp_path, "(expect (memory false))")]) for _ in range(2)]
    assert found[0] == found[1]


def test_no_outcomes_make_a_file_too() -> None:
    assert _parsed(as_junit([])).get("tests") == "0"
