"""Plans in runs: determinism, replay, saved states."""

from __future__ import annotations

from typing import NoReturn

import pytest

import rapc
from rapc import events

ROUND = """(define-rap (evening-round)
  (succeed (and (delivered medicine ward-3) (delivered meals ward-4)
                (not (call ward-2)) (docked)))
  (plan))"""
TASKS = ("(stay-charged) :priority 4 :background true", "(evening-round)")


@pytest.fixture(scope="module")
def courier() -> rapc.CheckedLibrary:
    return rapc.load("examples/courier").extend(ROUND)


def started(library: rapc.CheckedLibrary, seed: int = 3) -> rapc.Interpreter:
    facts = [("call", "ward-2")]
    return library.start("courier", tasks=TASKS, seed=seed, facts=facts)


def told(library: rapc.CheckedLibrary, seed: int) -> list[events.Event]:
    facts, found = [("call", "ward-2")], list[events.Event]()
    run = library.start(
        "courier", tasks=TASKS, seed=seed, facts=facts, listeners=[found.append]
    )
    run.run(until=2000)
    return found


def test_two_runs_make_the_same_plans(courier: rapc.CheckedLibrary) -> None:
    first = told(courier, 3)
    plans = [one for one in first if isinstance(one, events.PlanMade)]
    assert [len(one.steps) for one in plans] == [8, 7]
    assert told(courier, 3) == first


def test_replay_does_not_plan(
    courier: rapc.CheckedLibrary, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = started(courier)
    run.keep_answers()
    saved = run.save()
    run.run(until=2000)

    def broken(request: object) -> NoReturn:
        raise AssertionError("planned during a replay")

    again = started(courier)
    again.planner = broken
    again.answers = run.answers
    found: list[events.Event] = []
    again.restore(saved)
    again.listen(found.append, events.PlanMade)
    again.run(until=2000)
    assert again.results() == run.results()
    assert [len(one.steps) for one in found if isinstance(one, events.PlanMade)] == [
        8,
        7,
    ]


def test_run_with_a_plan_can_be_saved(courier: rapc.CheckedLibrary) -> None:
    run = started(courier)
    while run.now < 40:
        run.step()
    assert [m.name for m in run.added_methods["evening-round"]] == ["plan-1"]
    other = started(courier, seed=1)
    other.restore(run.save())
    assert run.run(until=2000) == other.run(until=2000)
    assert run.results() == other.results()


def test_task_without_a_planner_fails(courier: rapc.CheckedLibrary) -> None:
    run = started(courier)
    run.planner = None
    run.run(until=100)
    assert run.results()[1].result == "no-method"


GOAL = "(and (delivered medicine ward-3) (docked))"


def test_run_achieves_a_goal_without_a_rap() -> None:
    run = rapc.load("examples/courier").start("courier", seed=1)
    assert run.achieve(GOAL, priority=2) == "achieve-1"
    assert run.achieve("(docked)") == "achieve-2"
    run.run(until=1000)
    assert [one.outcome for one in run.results()] == ["succeeded", "succeeded"]


def test_plan_is_false_without_steps_to_the_goal() -> None:
    library = rapc.load("examples/courier")
    plan = rapc.plan(library, GOAL, facts=["(robot-at kitchen)"])
    assert plan
    assert plan.steps[0].goal == "(fetch medicine ward-3)"
    assert plan.steps[-1].purpose == "for the goal: (docked)"
    assert not rapc.plan(library, GOAL, use=["travel-to"])


def test_plan_refuses_what_is_no_operator() -> None:
    with pytest.raises(rapc.PlanError, match="`deliver`: it has no `effects`"):
        rapc.plan(rapc.load("examples/courier"), GOAL, use=["deliver"])
