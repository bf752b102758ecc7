"""A tour of the weapon trace of T 6.2.1: each `why` and `why-not` held against it."""

from __future__ import annotations

import pytest

from rapc import events
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.questions.why import reasons
from rapc.debug.questions.why_not import TaskAnswer, task_asked
from rapc.host import CheckedLibrary
from rapc.runtime.task_request import of_node
from rapc.testing.discover import find
from rapc.testing.patterns import flat
from rapc.testing.setting import row_of
from rapc.worlds import registry
from rapc.worlds.scripted import ScriptedWorld
from tests.truck.runs import STDLIB

pytestmark = pytest.mark.xdist_group("tour")


@pytest.fixture(scope="module")
def tour() -> History:
    """The run of the trace, at its end."""
    file = STDLIB / "truck" / "weapon.test.rap"
    [case] = [c for c in find([file]).cases if c.test.name.startswith("thesis-trace-1")]
    test, library = case.test, case.library
    assert test.world is not None
    helper = registry.build_world(registry.find_world(test.world), 0, {})
    world = ScriptedWorld(
        [row_of(row, library.signatures) for row in test.script],
        declared=library.library,
        kit=helper.kit,
    )
    session = History.open(
        CheckedLibrary(library),
        world,
        tasks=[of_node(task) for task in test.tasks],
        facts=[flat(fact) for fact in test.facts],
    )
    assert session.go().kind == "over"
    return session


def _by_cycle(session: History) -> dict[int, list[ToldEvent]]:
    found: dict[int, list[ToldEvent]] = {}
    for told in session.scan():
        found.setdefault(told.cycle, []).append(told)
    return found


def _selected(told: list[ToldEvent]) -> int | None:
    for one in told:
        if one.kind is events.TaskSelected:
            number: int = one.keys["task"]
            return number
    return None


def test_why_agrees_with_the_trace_in_each_cycle(tour: History) -> None:
    outcomes = {
        events.MethodChosen: "method",
        events.TaskSucceeded: "succeeded",
        events.TaskFailed: "failed",
        events.TaskBlocked: "blocked",
    }
    seen = set()
    for cycle, told in _by_cycle(tour).items():
        task = _selected(told)
        if task is None:
            continue
        choice, doing = reasons(tour, task, cycle)
        own = [o for o in told if o.kind in outcomes and o.keys["task"] == task]
        assert doing.outcome == (outcomes[own[0].kind] if own else "nothing")
        seen.add(doing.outcome)
        left = choice.candidates
        for _, kept in choice.rules:
            assert set(kept) < set(left)
            left = kept
        assert left == (task,)
        if own and own[0].kind is events.MethodChosen:
            assert doing.said == own[0].keys["method"]
            assert doing.bindings == own[0].keys["bindings"]
    assert seen >= {"method", "succeeded", "failed"}


def test_why_not_agrees_with_the_choice(tour: History) -> None:
    methods = 0
    for cycle, told in _by_cycle(tour).items():
        task = _selected(told)
        if task is None:
            continue
        answer = _before(tour, task, cycle)
        succeeds = any(
            o.kind is events.TaskSucceeded and o.keys["task"] == task for o in told
        )
        asked = [one for one in answer.clauses if one.clause.startswith("succeed of")]
        if asked:
            assert asked[0].holds == succeeds
        chosen = [
            o for o in told if o.kind is events.MethodChosen and o.keys["task"] == task
        ]
        solved = any(one.kind is events.SolverCalled for one in told)
        for one in chosen:
            holding = [method.name for method in answer.methods if method.holds]
            assert solved or one.keys["method"] in holding
            methods += 1
        failed = [
            o for o in told if o.kind is events.TaskFailed and o.keys["task"] == task
        ]
        if failed and failed[0].keys["reason"] == "no-method":
            assert not any(method.holds for method in answer.methods)
    assert methods > 20


def _before(session: History, task: int, cycle: int) -> TaskAnswer:
    """Return what is said of a task when it is about to come up."""
    with session.at(cycle - 1):
        session.run.come_to_choice()
        return task_asked(session, task)
