"""Plans in runs: determinism, replay, saved states."""

from __future__ import annotations

from typing import NoReturn

import pytest
from msgspec.structs import replace

import rapc
from rapc import events
from rapc.base import values
from rapc.base.source import SourceFile
from rapc.base.values import format_list
from rapc.host import find_plan
from rapc.ir import nodes
from rapc.library.operators import Model
from rapc.parser.parse import parse
from rapc.planning.solver import Solution, solve
from rapc.runtime.planner import Planned, PlanRequest
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

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


def plan_sizes(library: rapc.CheckedLibrary, seed: int) -> list[int]:
    """Compare two runs and a replay that must not plan; return the sizes of plans."""
    first = told(library, seed)
    assert told(library, seed) == first
    run = started(library, seed)
    run.keep_answers()
    saved = run.save()
    run.run(until=2000)

    def broken(request: object) -> NoReturn:
        raise AssertionError("planned during a replay")

    again = started(library, seed)
    again.planner = broken
    again.answers = run.answers
    found: list[events.Event] = []
    again.restore(saved)
    again.listen(found.append)
    again.run(until=2000)
    # The serial numbers begin with the first listener.
    last = [replace(one, n=0) for one in first[-len(found) :]]
    assert [replace(one, n=0) for one in found] == last
    assert found[0].cycle == 0
    return [len(one.steps) for one in found if isinstance(one, events.PlanMade)]


def test_two_runs_and_a_replay_make_the_same_plans(
    courier: rapc.CheckedLibrary,
) -> None:
    assert plan_sizes(courier, 3) == [8, 7]


@pytest.mark.nightly
def test_many_runs_and_replays_make_the_same_plans(
    courier: rapc.CheckedLibrary,
) -> None:
    found = [len(plan_sizes(courier, seed)) for seed in range(100)]
    assert min(found) == 1
    assert max(found) > 1


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
    facts = ["(robot-at kitchen)", "(gives-out pharmacy medicine)"]
    plan = rapc.plan(library, GOAL, facts=facts)
    assert plan
    assert plan.steps[0].goal == "(fetch medicine ward-3)"
    assert plan.steps[-1].purpose == "for the goal: (docked)"
    assert not rapc.plan(library, GOAL, use=["travel-to"])


def test_plan_refuses_what_is_no_operator() -> None:
    with pytest.raises(rapc.PlanError, match="`deliver`: it has no `effects`"):
        rapc.plan(rapc.load("examples/courier"), GOAL, use=["deliver"])


WAYS = """(declare-kind room (hall lab))
(declare-memory-proposition open ())
(declare-memory-property at ((?room room)) hall)
(declare-memory-proposition clean ((?room room)))
(declare-memory-proposition dry ((?room room)))
(define-rap (unlock) (effects (open)))
(define-rap (go-to (?room room)) (preconditions (open)) (effects (at ?room)))
(define-rap (broom (?room room)) (preconditions (at ?room)) (effects (clean ?room)))
(define-rap (mop (?room room)) (preconditions (at ?room)) (effects (clean ?room)))
(define-rap (wipe (?room room)) (preconditions (clean ?room)) (effects (dry ?room)))
(define-rap (prepare) (succeed (dry lab)) (plan))"""


def test_remaining_steps_of_a_broken_plan_are_used() -> None:
    program = rapc.loads(WAYS, check=False).program

    def solved(*facts: values.Fact, last: nodes.Method | None = None) -> Solution:
        model = Model(program.library, program.signatures)
        goal = model.goal(program.library.raps["prepare"], {})
        return solve(model, dict.fromkeys(facts), goal, limit=1000, last=last)

    def goals(found: Solution) -> list[str]:
        assert found.sketch is not None
        return [format_list(action.goal) for action in found.sketch.actions]

    way = ["(go-to lab)", "(broom lab)", "(wipe lab)"]
    first = solved(("open",))
    assert goals(first) == way
    other = [step.replace("broom", "mop") for step in way]
    steps = "".join(f" (t{at} {goal})" for at, goal in enumerate(other, 1))
    (form,) = parse(
        SourceFile("plan", f"(define-method prepare (task-net{steps}))")
    ).forms
    assert isinstance(form, nodes.DefineMethod)
    broken = solved(last=form.method)
    assert goals(broken) == ["(unlock)", *other]
    assert broken.expanded < solved().expanded
    assert goals(solved()) == ["(unlock)", *way]
    later = solved(("open",), ("at", "lab"), ("clean", "lab"), last=form.method)
    assert goals(later) == ["(wipe lab)"]


PAUSE = """(declare-memory-proposition held (?thing))
(declare-primitive grip (?thing) (okay slipped))
(declare-primitive rest () (okay))
(define-rap (take ?thing)
  (succeed (held ?thing))
  (effects (held ?thing))
  (method (context (not (last-result slipped))) (primitive (grip ?thing))))
(define-rap (fetch)
  (succeed (held box))
  (method rest (context (last-result slipped)) (primitive (rest)))
  (plan))"""


def test_plan_is_remembered_after_another_method() -> None:
    library = rapc.loads(PAUSE)
    rows = [
        Row(pattern=("grip", "?x"), result="slipped", takes=1, times=1),
        Row(pattern=("rest",), result="okay", takes=1),
        Row(pattern=("grip", "?x"), takes=1, asserts=(("held", "?x"),)),
    ]
    world = ScriptedWorld(rows, declared=library.program.library)
    run = library.start(world, tasks="(fetch)")
    asked: list[object] = []

    def spy(request: PlanRequest) -> Planned:
        asked.append(None if request.last is None else request.last.name)
        return find_plan(request)

    run.planner = spy
    assert run.run() == "done"
    assert run.results()[0].outcome == "succeeded"
    assert asked == [None, "plan-1"]


STORES = """(declare-kind room (hall yard))
(declare-kind tool (saw drill))
(declare-memory-property at ((?room room)) hall)
(declare-memory-property stored ((?tool tool) (?room room)) yard)
(declare-memory-proposition held ((?tool tool)))
(define-rap (go-to (?room room)) (effects (at ?room)))
(define-rap (pick-up (?tool tool))
  (preconditions (and (stored ?tool ?room) (at ?room)))
  (effects (held ?tool)))"""


def test_plan_begins_with_defaults_for_inputs() -> None:
    library = rapc.loads(STORES, check=False)
    goal = "(and (held saw) (held drill))"
    plan = rapc.plan(library, goal, facts=["(stored drill hall)"])
    steps = ["(pick-up drill)", "(go-to yard)", "(pick-up saw)"]
    assert [step.goal for step in plan.steps] == steps
