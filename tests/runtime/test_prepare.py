"""How runs begin: what is refused before anything happens, and what is told first."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

import rapc
from rapc import events
from rapc.errors import FactError, RefusedError, SettingError, TextError
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest
from rapc.spec import RunSpec
from rapc.testing import discover
from rapc.testing.run import run_case
from rapc.worlds.scripted import ScriptedWorld

from .helpers import DECLARATIONS, compiled

RAPS = "(define-rap (do ?x) (succeed (p ?x)) (method (primitive (act ?x))))"
TEST = """
(define-test it
  (script ((act ?x) okay :asserts ((p ?x))))
  (facts (go) (q a 4))
  (task (do a) :background true :deadline 90 :priority 2)
  (task (do b))
  (expect (memory (p b))))
"""
LIBRARY = compiled(RAPS)
DO_B = TaskRequest(("do", "b"))


def told_first(told: list[events.Event]) -> tuple[object, object]:
    """Return the tasks and facts of which the first event tells."""
    begun = told[0]
    assert isinstance(begun, events.RunStarted)
    return begun.spec.tasks, begun.spec.facts


def test_exported_test_has_the_start_of_the_program(tmp_path: Path) -> None:
    path = tmp_path / "it.test.rap"
    path.write_text(DECLARATIONS + RAPS + TEST, encoding="utf-8")
    [case] = discover.find([path]).cases
    of_test: list[events.Event] = []
    of_program: list[events.Event] = []
    run_case(case, listener=of_test.append)
    library = rapc.loads(DECLARATIONS + RAPS)
    library.start(
        ScriptedWorld([], declared=library.program.library),
        tasks=["(Do  a)  :background true :deadline 90.0 :priority 2", DO_B],
        facts=["(go)", ("q", "a", 4)],
        listeners=[of_program.append],
    )
    assert told_first(of_test) == told_first(of_program)
    assert told_first(of_test) == (
        ("(do a) :priority 2 :deadline 90 :background true", "(do b)"),
        ("(go)", "(q a 4)"),
    )


@pytest.mark.parametrize(
    ("spec", "later", "error", "message"),
    [
        (RunSpec(tasks=("(dance)",)), (), RefusedError, "unknown RAP `dance`"),
        (RunSpec(), [TaskRequest(("do",))], RefusedError, "has 1 input, not 0"),
        (RunSpec(facts=("(p a)", "(p)")), (), FactError, "takes 1 argument, not 0"),
        (RunSpec(agenda="day"), (), RefusedError, "unknown agenda `day`"),
        (RunSpec(settings={"patience": -1}), (), SettingError, "takes 0 or more"),
        (RunSpec(tasks=("(do",)), (), TextError, "do"),
    ],
)
def test_invalid_library_is_refused_before_the_run(
    spec: RunSpec, later: Sequence[TaskRequest], error: type[Exception], message: str
) -> None:
    world = ScriptedWorld([], declared=LIBRARY.library)
    with pytest.raises(error, match=message):
        Interpreter.prepared(LIBRARY, world, spec, later=later)


def test_tasks_of_later_are_not_submitted() -> None:
    world = ScriptedWorld([], declared=LIBRARY.library)
    ready = Interpreter.prepared(
        LIBRARY, world, RunSpec(tasks=("(do a)",)), later=[DO_B]
    )
    assert ready.agenda() == ()
    ready.start()
    assert [str(entry.goal) for entry in ready.agenda()] == ["(do a)"]
