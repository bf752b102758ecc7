"""`rapc.test`: tests in RAP, run by a Python program."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

import rapc
from rapc.events import RunStarted

LIBRARY = """
(declare-primitive warm (?oven) (okay cold))
(define-rap (cook ?dish)
  (succeed (last-result okay))
  (method (primitive (warm oven))))
"""

TEXT = f"""{LIBRARY}
(define-test cooks
  (script ((warm oven))) (task (cook pie)) (expect (succeeds (cook pie))))
(define-test burns (seed 5)
  (script ((warm oven))) (task (cook pie)) (expect (fails (cook pie))))
"""


def test_results_of_a_text_tell_outcomes_and_reasons() -> None:
    cooks, burns = rapc.test(TEXT, seed=3)
    assert (cooks.name, cooks.outcome, cooks.seed) == ("cooks", "passed", 3)
    assert (cooks.passed, cooks.reasons, cooks.trace) == (True, (), ())
    assert (burns.name, burns.outcome, burns.seed) == ("burns", "failed", 5)
    assert (burns.file, burns.row, burns.passed) == ("<text>", 9, False)
    assert burns.reasons[0].startswith("<text>:10:")
    assert any("(warm oven)" in line for line in burns.trace)


def test_results_stand_in_the_order_of_the_sources(tmp_path: Path) -> None:
    (tmp_path / "kitchen.rap").write_text(LIBRARY)
    (tmp_path / "one.test.rap").write_text(
        '(require "kitchen")\n(define-test rests (task (cook pie) :at 5) (until 1))'
    )
    found = rapc.test(TEXT, tmp_path, "(define-rap (a)) (define-test a (task (a)))")
    assert [(one.name, Path(one.file).name) for one in found] == [
        ("cooks", "<text>"),
        ("burns", "<text>"),
        ("rests", "one.test.rap"),
        ("a", "<text-2>"),
    ]


def test_the_listener_gets_the_events_of_each_run() -> None:
    events: list[Any] = []
    rapc.test(TEXT, listener=events.append)
    started = [event for event in events if isinstance(event, RunStarted)]
    assert [event.spec.seed for event in started] == [0, 5]


def test_unrunnable_test_is_an_error() -> None:
    lacking = '(define-test lacks (world "no-such:World") (task (cook pie)))'
    (found,) = rapc.test(LIBRARY + lacking)
    assert found.outcome == "error"
    assert "the module `no-such` may not be imported" in found.reasons[0]


def test_worlds_of_a_permitted_module_may_be_named() -> None:
    test = (
        '(define-test loads (world "tests.rap.language_world:Words") (task (cook a)))'
    )
    for modules in ((), ("tests.rap.language_world",)):
        (found,) = rapc.test(LIBRARY + test, modules=modules)
        assert ("may not be imported" in found.reasons[0]) == (not modules)


@pytest.mark.parametrize(
    ("sources", "more", "kind"),
    [
        ((), {}, rapc.ArgumentError),
        ((3,), {}, rapc.ArgumentError),
        (("(define-rap (a))",), {}, rapc.ArgumentError),
        ((TEXT,), {"seed": "x"}, rapc.ArgumentError),
        ((TEXT,), {"listener": 3}, rapc.ArgumentError),
        ((TEXT,), {"modules": "lamps"}, rapc.ArgumentError),
        (("no/such/file",), {}, rapc.LoadError),
        (("(define-rap (a)) (define-rap (a))",), {}, rapc.CheckError),
    ],
    ids=ascii,
)
def test_wrong_arguments_raise_an_error(
    sources: Iterable[Any], more: Any, kind: type[rapc.Error]
) -> None:
    with pytest.raises(kind):
        rapc.test(*sources, **more)
