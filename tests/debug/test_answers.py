"""Runs in worlds that cannot be saved are repeated from the kept answers."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Mapping
from typing import Any

import pytest

import rapc
from rapc.debug.acts import AssertFact, CancelTasks, SubmitTask
from rapc.debug.history import History
from rapc.debug.questions.why import why
from rapc.debug.questions.why_not import why_not
from rapc.errors import StateError
from rapc.events import Pictured
from rapc.runtime.answers import RecordedWorld
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import read_task_request
from rapc.spec import RunSpec
from rapc.world import OPTIONAL, Fact, Savable, World, Wrapper, methods_of
from rapc.worlds.scripted import ScriptedWorld
from tests.debug.sessions import TRUCK, row

TASKS = ("(rock-order red 1)", "(rock-order blue 1) :priority 1 :at 30")


class Machine(Wrapper):
    """A simulator that cannot be saved, and counts what it is asked."""

    def __init__(self, world: World) -> None:
        self.asked: Counter[str] = Counter()
        super().__init__(world)

    def enclose(self, world: World) -> None:
        """Replace the simulator."""
        super().enclose(world)
        del self.save, self.restore  # type: ignore[attr-defined]

    def perform(self, ticket: int, request: Fact) -> Any:
        """Count the request."""
        self.asked["perform"] += 1
        return super().perform(ticket, request)

    def advance(self, to: Any) -> None:
        """Count the move of the clock."""
        self.asked["advance"] += 1
        super().advance(to)

    def messages(self) -> Any:
        """Count the question."""
        self.asked["messages"] += 1
        return super().messages()


def machine() -> Machine:
    return Machine(rapc.open_world("truck", seed=7))


def _session(tasks: tuple[str, ...] = TASKS, **more: Any) -> tuple[History, Machine]:
    world = machine()
    library = rapc.load(TRUCK)
    return History.open(library, world, tasks=tasks, seed=7, **more), world


def _memory(run: Interpreter) -> Mapping[Any, Any]:
    return {fact: run.memory.since(fact) for fact in run.memory}


def test_the_machine_cannot_be_saved_without_a_history() -> None:
    assert not isinstance(machine(), Savable)
    run = rapc.load(TRUCK).start(machine(), tasks=TASKS, seed=7)
    with pytest.raises(StateError, match="cannot be saved"):
        run.save()


def test_keeping_answers_leaves_the_trace_unchanged() -> None:
    session, _ = _session()
    told = [one.event() for one in session.scan()]
    session.follow(lambda one: told.append(one.event()))
    session.go()
    heard: list[Any] = []
    run = rapc.load(TRUCK).start(
        machine(), tasks=TASKS, seed=7, listeners=[heard.append]
    )
    run.run()
    assert told == heard


def test_every_moment_is_reached_again_without_the_machine() -> None:
    session, world = _session()
    states = [_memory(session.run)]
    while session.step().kind == "asked":
        states.append(_memory(session.run))
    events, asked = [*session.scan()], Counter(world.asked)
    dice = random.Random(3)
    for _ in range(15):
        cycle = dice.randrange(len(states))
        session.goto(cycle)
        assert session.cycle == cycle
        assert _memory(session.run) == states[cycle]
    session.go()
    assert [*session.scan()] == events
    assert world.asked == asked
    assert len(states) > 300


def test_pictures_of_the_past_come_from_the_kept_answers() -> None:
    session, _ = _session(settings=Settings(pictures=True))
    session.go()
    told = [*session.scan(Pictured)]
    session.goto(session.cycle // 2)
    half = [*session.scan(Pictured)]
    session.go()
    assert 10 < len(half) < len(told)
    assert half == told[: len(half)]
    assert [*session.scan(Pictured)] == told


def test_stops_at_arrivals_ask_the_machine_nothing_more() -> None:
    session, world = _session()
    session.go()
    other, asked = [*session.scan()], Counter(world.asked)
    session, world = _session()
    stood = []
    while session.wait().kind == "asked":
        stood.append((session.moment, _memory(session.run)))
    assert [*session.scan()] == other
    assert world.asked == asked
    between = [one for one in stood if one[0].arrivals]
    assert between
    for moment, state in between:
        session.goto(moment.cycle)
        for _ in range(moment.arrivals):
            session.wait()
        assert (session.moment, _memory(session.run)) == (moment, state)
    session.go()
    assert [*session.scan()] == other
    assert world.asked == asked


def test_questions_about_the_past_do_not_ask_the_machine() -> None:
    session, world = _session()
    session.step(150)
    asked = Counter(world.asked)
    why(session, "1")
    why_not(session, "1")
    live = {task.number for task in session.run.tasks()}
    ended = next(number for number in range(2, 99) if number not in live)
    why_not(session, str(ended))
    assert session.ahead((), 5) == []
    assert world.asked == asked
    session.step()
    assert session.cycle == 151


def test_the_present_goes_on_after_a_look_at_the_past() -> None:
    session, world = _session()
    session.step(100)
    session.goto(40)
    asked = Counter(world.asked)
    session.goto(100)
    assert world.asked == asked
    session.step()
    assert world.asked != asked
    assert session.branch.name == "main"


def test_a_branch_ends_where_the_machine_was_not_asked_the_same() -> None:
    session, world = _session()
    session.step(100)
    asked = Counter(world.asked)
    session.goto(60)
    session.act(SubmitTask(read_task_request("(rock-order green 1) :priority 9")))
    stop = session.go()
    assert stop.kind == "broken"
    assert "the answer of the world to `" in stop.said
    assert 60 <= session.cycle < 100
    here = session.moment
    assert session.go().kind == "broken"
    assert session.moment == here
    assert world.asked == asked
    session.switch("main")
    session.goto(100)
    session.step()
    assert session.cycle == 101


def test_an_act_that_asks_the_machine_is_refused_in_the_past() -> None:
    text = """
    (declare-primitive act (?x) (okay) :atomic false)
    (define-rap (top) (method (task-net (t1 (act-on a) (for t2)) (t2 (act-on b)))))
    (define-rap (act-on ?x) (method (primitive (act ?x))))
    """
    library = rapc.loads(text, "small.rap")
    script = ScriptedWorld([row("(act ?)", after=5)], declared=library.program.library)
    session = History.open(library, Machine(script), tasks=["(top)"])
    session.go()
    assert session.reason == "done"
    session.goto(2)
    here = session.moment
    assert session.run.requests()
    with pytest.raises(StateError, match="the answer of the world to `cancel`"):
        session.act(CancelTasks(("top",)))
    assert session.moment == here
    assert session.run.requests()
    assert session.go().kind == "over"
    assert session.reason == "done"


def test_readings_that_say_nothing_new_are_counted() -> None:
    session, world = _session()
    session.step(200)
    kept = session.answers.kept
    calls = Counter(one.call for one in kept)
    assert calls["perform"] == world.asked["perform"]
    assert calls["messages"] < world.asked["messages"] / 4
    assert sum(one.readings for one in kept) > len(kept)


def test_a_machine_that_failed_is_not_asked_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session, world = _session()
    perform = Machine.perform

    def fail(self: Machine, ticket: int, request: Fact) -> Any:
        answer = perform(self, ticket, request)
        if self.asked["perform"] == 20:
            raise OSError("the motor is off")
        return answer

    monkeypatch.setattr(Machine, "perform", fail)
    first = session.go()
    assert first.kind == "broken"
    assert "the motor is off" in first.said
    asked = Counter(world.asked)
    session.goto(3)
    again = session.go()
    assert (again.kind, "the motor is off" in again.said) == ("broken", True)
    assert world.asked == asked


_OBSERVED = {"picture", "figures", "adjustable", "resume", "acknowledge"}
"""The methods of worlds that the interpreter never calls in a run."""


def test_all_that_the_interpreter_asks_of_a_world_is_kept() -> None:
    for protocol in (World, *OPTIONAL):
        for name in methods_of(protocol):
            own = {name, f"_{name}"} & set(vars(RecordedWorld))
            assert own or name in _OBSERVED, name


def test_first_facts_are_kept_if_the_run_has_not_begun() -> None:
    library = rapc.load(TRUCK).program
    run = Interpreter.prepared(library, machine(), RunSpec(tasks=TASKS, seed=7))
    answers = run.keep_answers()
    assert run.keep_answers() is answers
    run.start()
    assert answers.kept[0].call == "facts"
    assert set(answers.kept[0].told) <= set(run.memory)


def test_a_simulator_is_not_recorded() -> None:
    library = rapc.load(TRUCK)
    session = History.open(library, "truck", tasks=TASKS, seed=7)
    session.step(20)
    assert session.answers.kept == []
    assert session.spec.seed == 7
    assert session.spec.tasks == TASKS
    assert session.spec.digest == library.program.digest


def test_solvers_are_not_called_again_for_the_past() -> None:
    text = """
    (declare-memory-proposition p (?x))
    (declare-primitive act (?x) (okay dropped))
    (define-rap (top) (method (task-net (t1 (act-on a) (for t2)) (t2 (act-on b)))))
    (define-rap (act-on ?x) (method (context (p no)) (task-net)))
    """
    goals: list[Any] = []

    def solver(goal: Any, memory: Any) -> Any:
        goals.append(goal)
        return rapc.methods(f"(method m{len(goals)} (primitive (act {len(goals)})))")

    library = rapc.loads(text, "small.rap")
    world = ScriptedWorld([row("(act ?)")], declared=library.program.library)
    session = History.open(library, world, tasks=["(top)"], solvers={"act-on": solver})
    session.go()
    events, called = [*session.scan()], len(goals)
    assert called > 0
    session.goto(1)
    session.go()
    assert [*session.scan()] == events
    assert len(goals) == called
    session.goto(1)
    session.act(AssertFact(("p", "c")))
    session.go()
    assert len(goals) > called
    session.switch("main")
    session.go()
    assert [*session.scan()] == events
