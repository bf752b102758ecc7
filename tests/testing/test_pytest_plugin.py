"""The pytest plug-in: what it collects, what a failure looks like, what it costs."""

from __future__ import annotations

import subprocess
import sys
from xml.etree import ElementTree

import pytest

from .small_suite import GRAB, LIBRARY

pytest_plugins = ["pytester"]

GOOD = (
    f"(define-test good (script {GRAB}) (task (fetch box)) (expect (never (look ?))))"
)
BAD = f"""\
(define-test bad (script {GRAB}) (task (fetch box))
  (expect (never (grab ?))))
"""


def _run(pytester: pytest.Pytester, *args: str) -> pytest.RunResult:
    return pytester.runpytest_inprocess(
        *("-p", "no:xdist", "-p", "no:asyncio", "-p", "no:pytest-lsp"),
        *("-W", "error"),
        *args,
    )


def test_each_test_is_an_item(pytester: pytest.Pytester) -> None:
    (pytester.path / "arms.test.rap").write_text(LIBRARY + GOOD + BAD)
    (pytester.path / "arms.rap").write_text(LIBRARY + BAD)
    result = _run(pytester)
    result.assert_outcomes(passed=1, failed=1)
    rows = len(LIBRARY.splitlines())
    result.stdout.fnmatch_lines(
        [
            "*FAILURES*",
            "*bad*",
            f"arms.test.rap:{rows + 2}:11",
            "*(expect (never (grab [?]))))*",
            "*what happened: (grab box) was requested at time 0 by (fetch box) [[]1]",
            "*the last cycles:",
            "*FAILED arms.test.rap::bad*",
        ]
    )


REASON = "(grab box) was requested at time 0 by (fetch box) [1]"


@pytest.mark.parametrize("how", [(), ("-q",), ("-rA", "--tb=no"), ("--tb=short",)])
def test_the_summary_says_why(
    how: tuple[str, ...], pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "150")
    (pytester.path / "arms.test.rap").write_text(LIBRARY + BAD)
    (pytester.path / "odd.test.rap").write_text("(define-rap (x) (succeed (y))")
    result = _run(pytester, "--continue-on-collection-errors", *how)
    told = result.stdout.str()
    assert f"\nFAILED arms.test.rap::bad - {REASON}\n" in told
    assert "\nERROR odd.test.rap - odd.test.rap:1:1: error[RAP" in told
    assert told.count("what happened") == ("--tb=no" not in how)


def test_a_line_for_each_failure_says_where_and_why(pytester: pytest.Pytester) -> None:
    (pytester.path / "arms.test.rap").write_text(LIBRARY + BAD)
    result = _run(pytester, "--tb=line")
    row = len((LIBRARY + BAD).splitlines())
    told = result.stdout.str()
    assert f"\narms.test.rap:{row}: {REASON}\n" in told


def test_junit_of_pytest_says_why(pytester: pytest.Pytester) -> None:
    (pytester.path / "arms.test.rap").write_text(LIBRARY + BAD)
    _run(pytester, "--junit-xml=out.xml")
    text = (pytester.path / "out.xml").read_text()
    found = ElementTree.fromstring(text)  # noqa: S314  # pytest wrote it
    [failure] = found.iter("failure")
    assert failure.get("message") == REASON
    assert "what happened: (grab box)" in (failure.text or "")


def test_items_are_chosen_by_name(pytester: pytest.Pytester) -> None:
    (pytester.path / "arms.test.rap").write_text(LIBRARY + GOOD + BAD)
    _run(pytester, "arms.test.rap::good").assert_outcomes(passed=1)
    _run(pytester, "-k", "bad").assert_outcomes(failed=1, deselected=1)


def test_a_file_with_errors_is_an_error(pytester: pytest.Pytester) -> None:
    (pytester.path / "arms.test.rap").write_text("(define-rap (x) (succeed (y))")
    result = _run(pytester)
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["arms.test.rap:1:*: error[[]RAP*"])


def test_unreadable_file_is_an_error(pytester: pytest.Pytester) -> None:
    (pytester.path / "arms.test.rap").write_bytes(b"\xff")
    result = _run(pytester)
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*`arms.test.rap` is not UTF-8*"])


def test_other_files_are_left_alone(pytester: pytest.Pytester) -> None:
    (pytester.path / "arms.rap").write_text(LIBRARY + BAD)
    assert _run(pytester).ret == pytest.ExitCode.NO_TESTS_COLLECTED


def test_loading_it_imports_nothing_else() -> None:
    code = "import sys, rapc.testing.pytest_plugin; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    loaded = [name for name in done.stdout.split() if name.startswith("rapc")]
    plugin = ["rapc.testing", "rapc.testing.pytest_plugin"]
    assert sorted(loaded) == ["rapc", "rapc.base", "rapc.base.version", *plugin]
    assert "pytest" not in done.stdout.split()


def test_a_damaged_library_is_told_of_in_a_line(pytester: pytest.Pytester) -> None:
    (pytester.path / "odd.test.rap").write_bytes(b"rapc-library what\n")
    result = _run(pytester)
    result.assert_outcomes(errors=1)
    result.stdout.fnmatch_lines(["*`odd.test.rap` is damaged: its first line is*"])
    assert "Traceback" not in result.stdout.str()


@pytest.mark.parametrize("permitted", [False, True])
def test_worlds_of_modules_are_permitted_by_a_setting(
    permitted: bool, pytester: pytest.Pytester
) -> None:
    world = "tests.rap.language_world"
    (pytester.path / "it.test.rap").write_text(
        f'(define-rap (idle) (succeed t)) (define-test it (world "{world}:'
        'LanguageWorld") (task (idle)) (expect (succeeds (idle))))'
    )
    setting = ("-o", f"rap_world_modules={world}") if permitted else ()
    result = _run(pytester, *setting)
    result.assert_outcomes(passed=permitted, failed=not permitted)


@pytest.mark.parametrize("name", ["arms.py", "notes.json"])
def test_coverage_replaces_no_file_of_another_kind(
    name: str, pytester: pytest.Pytester
) -> None:
    (pytester.path / "arms.test.rap").write_text(LIBRARY + GOOD)
    (pytester.path / name).write_text("mine = 1\n")
    result = _run(pytester, "--rap-coverage", name)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: --rap-coverage: cannot write `{name}`: *"])
    assert (pytester.path / name).read_text() == "mine = 1\n"
