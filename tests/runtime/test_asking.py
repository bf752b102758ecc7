"""Whoever asks from outside changes nothing: no event, no serial, no draw."""

from __future__ import annotations

import pytest

from rapc.runtime.events.events import Event
from rapc.runtime.interpreter import Interpreter
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
def test_a_run_of_the_truck_does_not_notice_who_asks(cycles: int) -> None:
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


@pytest.mark.parametrize("chunk", first(1, range(15)))
def test_generated_programs_do_not_notice_who_asks(chunk: int) -> None:
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


def test_a_fault_in_a_question_is_the_hosts_alone() -> None:
    play = Play("(define-rap (idle) (succeed (p a)) (method (primitive (act a))))")
    before = len(play.events)
    assert not play.interpreter.question("(< ?x 3)").holds()
    assert len(play.events) == before
