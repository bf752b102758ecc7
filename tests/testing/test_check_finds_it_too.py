"""`rapc check` finds in a test file all that `rapc test` finds before it runs.

Tests are made by putting slips into sound ones: names misspelt, arguments added or
taken away, results and keys replaced. What keeps a test from being run is compared with
what the checker says of the same file.
"""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from rapc.analysis.driver import CheckReport, check_library
from rapc.base.diagnostics import Severity
from rapc.library.loader import load
from rapc.testing import discover
from rapc.testing.run import Status, run_case

from .small_suite import LIBRARY

SOUND = """\
(define-test first
  (facts (have cup) (where cup kitchen))
  (script
    ((grab ?x) dropped :times 1)
    ((grab ?x) okay :takes 2 :asserts ((have ?x)) :erases ((where ?x)))
    ((look ?x) okay :asserts ((where ?x hall)) :signals ((:bump left))))
  (at 3 (asserts (where box hall)) (erases (have cup)) (signals (:bump left)))
  (task (fetch box))
  (until 30)
  (expect
    (succeeds (fetch box))
    (fails (find box) no-method)
    (primitives-include (grab box))
    (never (say box))
    (memory (and (have ?x) (not (where ?x hall))))
    (method fetch by-hand 2 times)
    (selected-before (fetch box) (fetch cup))
    (trace (task-failed :goal (fetch box) :reason interference))))
(define-test second
  (script ((look ?x) okay :asserts ((where ?x hall))))
  (at 5 (task (find cup)) (cancel (tidy)))
  (task (find cup))
  (until 9)
  (expect (succeeds (find cup) hall) (active (await left)) (ends-by 9 (tidy))))
"""
WORD = re.compile(r"(?<=[( :])[a-z][a-z-]+(?=[ )])")


def _checked(path: Path) -> CheckReport:
    return check_library(load([path]))


def _slip(text: str, dice: random.Random) -> str:
    """A text with one word of it misspelt, taken out or doubled."""
    found = dice.choice(list(WORD.finditer(text)))
    word = found[0]
    instead = dice.choice((word[:-1] + "qz", "", f"{word} {word}", "?other"))
    return text[: found.start()] + instead + text[found.end() :]


@pytest.mark.parametrize("seed", range(60))
def test_check_finds_unrunnable_tests(tmp_path: Path, seed: int) -> None:
    dice = random.Random(seed)
    text = SOUND
    for _ in range(dice.randint(1, 3)):
        text = _slip(text, dice)
    path = tmp_path / "it.test.rap"
    path.write_text(f"{LIBRARY}\n{text}", encoding="utf-8")
    said = {
        (f.diagnostic.span, f.diagnostic.message)
        for f in _checked(path).findings
        if f.severity is Severity.ERROR
    }
    found = discover.find([path])
    kept = {
        (f.diagnostic.span, f.diagnostic.message)
        for r in found.reports
        for f in r.findings
    }
    for case in found.cases:
        outcome = run_case(case)
        if outcome.status is Status.ERROR:
            assert case.faults, outcome.failures
            kept |= {(f.diagnostic.span, f.diagnostic.message) for f in case.faults}
    assert kept == said


def test_sound_tests_have_no_findings(tmp_path: Path) -> None:
    path = tmp_path / "it.test.rap"
    path.write_text(f"{LIBRARY}\n{SOUND}", encoding="utf-8")
    assert _checked(path).findings == ()


def test_a_slip_in_one_test_lets_the_other_run(tmp_path: Path) -> None:
    path = tmp_path / "it.test.rap"
    text = SOUND.replace("(never (say box))", "(never (grabb box))")
    path.write_text(f"{LIBRARY}\n{text}", encoding="utf-8")
    first, second = (run_case(case) for case in discover.find([path]).cases)
    assert [f.happened for f in first.failures] == [
        ("unknown primitive `grabb`; did you mean `grab`?",)
    ]
    assert second.status is not Status.ERROR
