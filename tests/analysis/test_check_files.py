"""What `rapc check` finds in files of tests: all that `rapc test` finds beforehand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rapc.analysis import driver
from rapc.analysis.check_files import check_files
from rapc.analysis.driver import Finding
from rapc.analysis.selection import Selection
from rapc.base.diagnostics import Severity
from rapc.library.loader import Loaded
from rapc.testing.discover import find

LIBRARIES = {
    "lamps.rap": """
        (declare-memory-proposition lit (?lamp))
        (declare-primitive switch (?lamp) (okay broken))
        (define-rap (light ?lamp) (succeed (lit ?lamp))
          (method (primitive (switch ?lamp))))
    """,
    "doors.rap": """
        (declare-memory-property door (?door ?state) unknown)
        (declare-primitive switch (?door ?way) (okay))
        (define-rap (light ?door) (method (primitive (switch ?door on))))
        (define-rap (shut ?door) (method (primitive (switch ?door off))))
    """,
    "bad.rap": """
        (define-rap (lost) (method (primitive (nobody knows))))
    """,
}
"""Libraries that cannot be linked into one: both have `light` and `switch`."""

TESTS = [
    '(require "lamps") (script ((switch l1))) (task (light l1)) '
    "(expect (succeeds (light l1)))",
    '(require "doors") (script ((switch d1 on))) (task (light d1)) '
    "(expect (succeeds (light d1)))",
    '(require "lamps") (script ((switch l1) burnt)) (task (light l1))',
    '(require "lamps") (script ((switch l1 on))) (task (light l1))',
    '(require "doors") (script ((switch d1 on) broken)) (task (light d1))',
    '(require "doors") (task (shut d1 now))',
    '(require "lamps") (task (shut d1))',
    '(require "lamps") (script ((turn l1))) (task (light l1))',
    '(require "doors") (fact (lit l1)) (task (shut d1))',
    '(require "lamps") (task (light l1)) (expect (memory (lit l1 l2)))',
    '(require "lamps") (task (light l1)) (expect (task-lost (light l1)))',
    '(require "nowhere") (task (light l1))',
    '(require "bad") (task (lost))',
    "(task (light l1))",
    "(script ((switch l1)) (task (light l1))",
]
"""Clauses of tests: the first two are right, each of the others has a slip."""


def _put(folder: Path, tests: list[str]) -> Path:
    for name, text in LIBRARIES.items():
        (folder / name).write_text(text, encoding="utf-8")
    forms = [f"(define-test t{n} {clauses})\n" for n, clauses in enumerate(tests)]
    file = folder / "all.test.rap"
    file.write_text("".join(forms), encoding="utf-8")
    return file


def _of_test(file: Path) -> set[tuple[str, str, int]]:
    """The errors that `rapc test` tells before it runs anything."""
    found = find([file])
    told = [fault for case in found.cases for fault in case.faults]
    told += [one for report in found.reports for one in report.findings]
    return {_key(finding) for finding in told}


def _of_check(file: Path) -> set[tuple[str, str, int]]:
    found = check_files([str(file)]).findings
    return {_key(one) for one in found if one.severity is Severity.ERROR}


def _key(finding: Finding) -> tuple[str, str, int]:
    place = finding.diagnostic.span
    return finding.diagnostic.message, place.file, place.start


@pytest.mark.parametrize("slip", TESTS[2:])
def test_check_finds_in_a_test_what_the_runner_finds(tmp_path: Path, slip: str) -> None:
    """Beside two right tests whose libraries could not be linked into one."""
    file = _put(tmp_path, [*TESTS[:2], slip])
    assert _of_check(file)
    assert _of_check(file) == _of_test(file)


def test_tests_that_require_different_libraries_are_right_side_by_side(
    tmp_path: Path,
) -> None:
    file = _put(tmp_path, TESTS[:2])
    assert _of_check(file) == _of_test(file) == set()


def test_all_slips_of_a_file_are_found_at_once(tmp_path: Path) -> None:
    file = _put(tmp_path, TESTS)
    alone = set()
    for at, slip in enumerate(TESTS[2:-1]):
        folder = tmp_path / str(at)
        folder.mkdir()
        alone |= {message for message, _, _ in _of_check(_put(folder, [slip]))}
    assert {message for message, _, _ in _of_check(file)} >= alone
    assert _of_check(file) == _of_test(file)


def test_a_suppression_is_used_if_one_of_the_tests_has_a_use_for_it(
    tmp_path: Path,
) -> None:
    file = _put(tmp_path, TESTS[:2])
    slip = '(define-test s (require "lamps")\n'
    slip += "  (task (shut d1))) ; rapc: ignore[unknown-rap]\n"
    file.write_text(file.read_text(encoding="utf-8") + slip, encoding="utf-8")
    assert [one.rule.name for one in check_files([str(file)]).findings] == []


def test_a_suppression_in_a_file_that_is_required_may_serve_another_library(
    tmp_path: Path,
) -> None:
    """What it silences may be due to an agenda that the tests do not require."""
    file = _put(tmp_path, TESTS[:1])
    lamps = tmp_path / "lamps.rap"
    comment = (
        "; rapc: ignore[priority-out-of-band] it is no reaction\n(define-rap (light"
    )
    text = lamps.read_text(encoding="utf-8").replace("(define-rap (light", comment)
    lamps.write_text(text, encoding="utf-8")
    assert check_files([str(file)]).findings == ()
    found = check_files([str(file), str(lamps)]).findings
    assert [one.rule.name for one in found] == ["unused-suppression"]


def test_a_library_named_beside_its_tests_is_checked_once(tmp_path: Path) -> None:
    file = _put(tmp_path, [TESTS[-3]])
    found = check_files([str(tmp_path / "bad.rap"), str(file)])
    assert [one.rule.name for one in found.findings] == ["undeclared-primitive"]
    assert found.raps == 1


LACKING = [
    ("(options (fuel-capacity 3))", "options of a world require a world"),
    ("(script ((look) okay :data ((seen))))", "datum `seen` has no handler"),
    ("(answers ((near) 3))", "unknown function `far`"),
]


@pytest.mark.parametrize(("clause", "message"), LACKING)
def test_what_a_test_lacks_without_a_world_is_found_before_it_runs(
    tmp_path: Path, clause: str, message: str
) -> None:
    file = tmp_path / "it.test.rap"
    file.write_text(
        """
        (declare-sensor-datum seen ())
        (declare-primitive look () (okay))
        (declare-memory-function far ())
        (declare-memory-function near ())
        (define-rap (go) (method (primitive (look))))
        (define-test it (answers ((far) 3) ((near) 3)) (task (go)))
        """
    )
    assert _of_check(file) == _of_test(file) == set()
    text = file.read_text().replace("(answers ((far) 3) ((near) 3))", clause)
    if "answers" not in clause:
        text = text.replace(clause, f"(answers ((far) 3) ((near) 3)) {clause}")
    file.write_text(text)
    (found,) = _of_check(file)
    assert found[0].startswith(message)
    assert _of_test(file) == {found}


def _project(folder: Path) -> None:
    """Put a library with a finding, and its tests in a folder beside it."""
    for name in ("library", "tests"):
        (folder / name).mkdir()
    (folder / "library" / "go.rap").write_text("(define-rap (go) (succeed (at home)))")
    for name in ("one", "two"):
        test = f'(require "../library/go") (define-test {name} (task (go)))'
        (folder / "tests" / f"{name}.test.rap").write_text(test)


@pytest.mark.parametrize("root", [True, False])
def test_a_library_required_through_the_folder_above_is_checked_once(
    root: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _project(tmp_path)
    monkeypatch.chdir(tmp_path)
    before = f"{tmp_path}/" if root else ""
    names = [f"{before}{name}" for name in ("library", "tests/one.test.rap")]
    found = check_files([*names, f"{before}tests/two.test.rap"])
    assert list(found.files) == [
        f"{before}library/go.rap",
        f"{before}tests/one.test.rap",
        f"{before}tests/two.test.rap",
    ]
    assert [one.diagnostic.span.file for one in found.findings] == [
        f"{before}library/go.rap"
    ]
    assert found.raps == 1


def test_a_file_required_through_a_link_keeps_the_name_that_finds_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Behind a link `..` is not the folder that the link is in."""
    _project(tmp_path)
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "linked").symlink_to("../tests")
    monkeypatch.chdir(tmp_path / "here")
    found = check_files(["linked/one.test.rap"])
    assert [one.diagnostic.span.file for one in found.findings] == [
        "linked/../library/go.rap"
    ]


def _found(*paths: str) -> list[tuple[str, str, int]]:
    return [_key(one) for one in check_files(paths).findings]


@pytest.fixture
def suite(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the names of test files in a folder, each with one of `TESTS`."""
    monkeypatch.chdir(tmp_path)
    _put(tmp_path, [])
    (tmp_path / "all.test.rap").unlink()
    for number, clauses in enumerate(TESTS):
        file = tmp_path / f"t{number:02}.test.rap"
        helper = "(define-rap (help) (succeed t))\n" if number % 2 else ""
        required = ' (require "doors") ' if '"doors"' in clauses else ""
        test = clauses.replace('(require "doors")', "")
        file.write_text(f"{required}{helper}(define-test it {test})\n")
    return sorted(file.name for file in tmp_path.glob("*.test.rap"))


def test_tests_below_a_folder_are_checked_as_if_they_were_named(
    suite: list[str], tmp_path: Path
) -> None:
    """Each by itself: half of them define the same RAP, all tests have one name."""
    (tmp_path / "lamps.rap").rename(tmp_path / "lamps.txt")  # `light` stands twice
    (tmp_path / "bad.rap").unlink()
    alone = {found for name in suite for found in _found(name)}
    assert len(alone) > len(TESTS)
    assert sorted(_found(".")) == sorted(alone)
    assert sorted(_found(".", *suite)) == sorted(alone)


def test_files_of_tests_that_require_the_same_are_checked_at_once(
    suite: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So a library is not checked as often as it has files of tests."""
    for name in suite:
        (tmp_path / name).write_text('(require "doors") (define-test it)')
    seen: list[list[str]] = []

    findings = driver._findings

    def check(loaded: Loaded, selection: Selection, *more: Any) -> list[Finding]:
        seen.append(list(loaded.files))
        return findings(loaded, selection, *more)

    monkeypatch.setattr(driver, "_findings", check)
    check_files(["doors.rap", *suite])
    assert seen == [["doors.rap"], ["doors.rap", *suite]]


def test_of_a_part_of_a_library_only_errors_are_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the library as a whole `lit` is used; for the first test `dark` is missing."""
    monkeypatch.chdir(tmp_path)
    texts = {
        "lit.rap": "(declare-primitive light () (okay))\n"
        "(define-rap (go) (method (claims lamp) (primitive (light))))"
        "(define-agenda day (task (go)))",
        "dark.rap": '(require "lit")'
        "(define-rap (stay) (method (claims lamp) (task-net (t1 (go)))))",
        "one.test.rap": '(require "lit") (define-test it (task (stay)))',
        "two.test.rap": '(require "dark") (define-test it (task (stay)))',
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    part = check_files(["one.test.rap"]).findings
    assert [one.rule.name for one in part] == ["unused-claim", "unknown-rap"]
    whole = check_files(["."]).findings
    assert [one.rule.name for one in whole] == ["unknown-rap"]


def test_a_file_has_one_name_whatever_paths_lead_to_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _project(tmp_path)
    monkeypatch.chdir(tmp_path)
    found = check_files(["library", str(tmp_path / "tests")])
    assert [one.diagnostic.span.file for one in found.findings] == ["library/go.rap"]
    assert len(found.files) == 3
