"""Whoever asks from outside changes nothing: no event, no serial, no draw."""

from __future__ import annotations

from typing import Any

import pytest

import rapc
from rapc.base.values import Fact
from rapc.debug.history import History
from rapc.debug.questions import state, tasks
from rapc.events import Event, TaskBlocked
from rapc.runtime.interpreter import Interpreter
from rapc.world import HandlerMemory, Handlers, Kit
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld
from tests.effort import first
from tests.reference.case import begin, interpreter_of, stepwise
from tests.reference.generate import generate
from tests.reference.vocabulary import UNBROKEN
from tests.runtime import saving
from tests.runtime.helpers import Play

FAULTY = ("(< ?never 3)", "(= (/ 1 0) 2)", "(not (< nothing 3))")
"""Formulas that meet an unbound variable, or what is no number."""


def _ask_everything(run: Interpreter) -> None:
    """Ask all that a host can ask."""
    run.agenda()
    run.goals()
    run.waiting()
    run.results()
    run.save()
    for text in FAULTY:
        question = run.question(text)
        question.holds()
        question.first()
        question.all()
    _ask_memory(run)
    for ask in (state.monitors, state.claims, state.items, tasks.tree):
        ask(History(run))


def _ask_memory(run: Interpreter) -> None:
    memory = run.memory
    for name in ("p", "q", "location", "class"):
        for fact in memory.query(name, None, None):
            memory.age(*fact)
            memory.value(*fact[:-1])
            memory.kind(fact[1])
            memory.count("rock", fact[-1])
        memory.spread(name, 1)


@pytest.mark.parametrize("cycles", first(1, [100, 400]))
def test_truck_run_is_unchanged_by_debugger_queries(cycles: int) -> None:
    asked, alone = saving.Truck(2), saving.Truck(2)
    for _ in range(cycles):
        _ask_everything(asked.run)
        assert asked.run.step() == alone.run.step()
    assert asked.trace == alone.trace
    assert asked.run.save() == alone.run.save()


def _told(run: Interpreter) -> list[Event]:
    found: list[Event] = []
    run.listen(found.append)
    return found


@pytest.mark.parametrize("chunk", first(1, range(15), 5))
def test_generated_runs_are_unchanged_by_debugger_queries(chunk: int) -> None:
    for seed in range(chunk * 10, (chunk + 1) * 10):
        case = stepwise(generate(seed, UNBROKEN))
        asked, alone = interpreter_of(case), interpreter_of(case)
        heard, expected = _told(asked), _told(alone)
        begin(case, asked)
        begin(case, alone)
        for _ in range(40):
            _ask_everything(asked)
            asked.step()
            alone.step()
        assert heard == expected, f"seed {seed}"
        assert asked.save() == alone.save(), f"seed {seed}"


def test_a_fault_in_a_question_is_the_hosts_alone() -> None:
    play = Play("(define-rap (idle) (succeed (p a)) (method (primitive (act a))))")
    before = len(play.events)
    assert not play.interpreter.question("(< ?x 3)").holds()
    assert len(play.events) == before


DEPOT = """
(declare-primitive look (?which) (okay))
(declare-sensor-datum drum-seen (?drum ?color))
(declare-sensor-datum moved-on ())
(declare-memory-property class (?item ?class ?value) false)
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property color (?item ?color) unknown)
(declare-memory-proposition emptied (?item))
(declare-indistinct-class drum)
(define-rap (look-at ?which) (method (primitive (look ?which))))
(define-rap (watch ?item)
  (monitor-state (emptied ?item))
  (method (primitive (look ?item))))
"""


def _drum_seen(memory: HandlerMemory, datum: Fact) -> None:
    _, drum, color = datum
    name = memory.introduce(str(drum), "drum", "depot")
    if color != "unknown":
        memory.assert_fact("color", name, color)


def _moved_on(memory: HandlerMemory, datum: Fact) -> None:
    memory.expire()


def _depot() -> rapc.Interpreter:
    """Return a run that has seen a red drum and a blue one, and one of the two again.

    Whether `item-3` is the red one, `item-1`, or the blue one is not known yet.
    """
    library = rapc.loads(DEPOT)
    data = {"drum-seen": _drum_seen, "moved-on": _moved_on}
    rows = (
        Row(
            ("look", "all"),
            data=(("drum-seen", "a", "red"), ("drum-seen", "b", "blue")),
        ),
        Row(("look", "one"), data=(("moved-on",), ("drum-seen", "c", "unknown"))),
    )
    declared, kit = library.program.library, Kit(handlers=Handlers(data=data))
    world = ScriptedWorld(rows, declared=declared, kit=kit)
    run = library.start(world, tasks=["(watch nothing)", "(look-at all)"])
    run.run_ready()
    run.submit("(look-at one)")
    run.run_ready()
    return run


@pytest.mark.parametrize("asking", [False, True])
def test_task_waits_for_a_merged_item_by_its_kept_name(asking: bool) -> None:
    run = _depot()
    told: list[Any] = []
    run.listen(told.append, TaskBlocked)
    run.submit("(watch item-3)")
    if asking:
        asked = state.monitors(History(run))
        assert asked.rows[-1]["waits for"] == "(emptied item-3)"
    run.assert_fact("color", "item-3", "red")
    run.step()
    assert [event.on for event in told] == ["(emptied item-1)"]
