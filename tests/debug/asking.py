"""Whoever asks a run or its debugger changes nothing: asked at random moments.

    python -m tests.debug.asking --points 100

goes through a run of the truck, one of the hallway and a shift of the courier, stops at
that many random moments of each and asks ten random questions there, of the interpreter
and of the debugger. After each the whole state is held against the one before, byte for
byte. A listener asks in the middle of cycles as well. In the end events and state must
be those of the same run that nobody has asked anything.
"""

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import msgspec

from rapc import events
from rapc.base.values import Fact, format_list
from rapc.debug import acts, find, recorded
from rapc.debug.acts import AssertFact, EraseFacts, FailTask
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.names import definition_names
from rapc.debug.questions import (
    beliefs,
    commitments,
    differences,
    ends,
    facts,
    idle,
    state,
    tasks,
    times,
    what_if,
    why,
    why_not,
)
from rapc.errors import Error
from rapc.events import Event, FactAsserted, TaskCreated
from rapc.ir.nodes import Proposition
from rapc.ir.printer import format_formula
from rapc.runtime.task_request import TaskRequest
from rapc.world import Adjustable, Drawable
from tests.debug.moments import RUNS, asked_for

_QUESTIONS_EACH = 10
"""How many questions are asked at a moment."""

_BETWEEN = 0.5
"""The share of moments that may be between two cycles."""

_IN_CYCLES = 0.05
"""The share of events at which a listener asks something."""

_FAULTY = ("(< ?never 3)", "(= (/ 1 0) 2)", "(last-result ?result)", "(believe p ?age)")
"""Formulas that bind nothing, have a fault in them, or no meaning outside a task."""


class Asker:
    """Somebody with a session and dice: what is asked about is drawn."""

    def __init__(self, session: History, dice: random.Random) -> None:
        self.session = session
        self.dice = dice
        self.formulas = [*_formulas(session), *_FAULTY]

    def task(self) -> int:
        """Return the number of a live task, or now and then of any."""
        run = self.session.run
        live = run.state.live_tasks()
        if live and self.dice.random() < 0.7:
            return self.dice.choice(live).number
        return self.dice.randrange(1, run.state.numbers + 2)

    def cycle(self) -> int:
        """Return a cycle of the past."""
        return self.dice.randrange(self.session.cycle + 1)

    def fact(self) -> Fact:
        """Return a fact that is believed and says something of something."""
        facts = self.session.run.beliefs.facts
        return self.dice.choice([fact for fact in facts if len(fact) > 1])

    def named(self) -> str:
        """Return the name of a definition."""
        library = self.session.library.program.library
        return self.dice.choice([name for name, _ in definition_names(library)])

    def pattern(self) -> str:
        """Return a fact with gaps in it, as text."""
        name, *args = self.fact()
        gaps = ["?" if self.dice.random() < 0.5 else arg for arg in args]
        return format_list((name, *gaps))


def _formulas(session: History) -> Iterator[str]:
    """The formulas that stand in the clauses of the library."""
    for rap in session.run.library.library.raps.values():
        contexts = [method.context for method in rap.methods]
        for formula in (rap.succeed, rap.preconditions, *contexts):
            if formula is not None:
                yield format_formula(formula)


def _past(one: Asker) -> None:
    run = one.session.run
    events = run.past()
    assert [event.n for event in events] == [*range(run.serial)][-len(events) :]
    assert [event.time for event in events] == sorted(event.time for event in events)
    facts = [event.fact for event in events if isinstance(event, FactAsserted)]
    assert sorted(map(format_list, facts)) == sorted(map(format_list, run.memory))
    made = [event.task for event in events if isinstance(event, TaskCreated)]
    assert sorted(made) == [entry.task for entry in run.agenda()]


def _formula(one: Asker) -> None:
    text = one.dice.choice(one.formulas)
    question = one.session.run.question(text)
    assert question.given == ()
    question.first(), question.all(), question.holds()
    one.session.question(text).all()


def _memory(one: Asker) -> None:
    memory, (name, *args) = one.session.run.memory, one.fact()
    assert memory.now == one.session.run.now
    assert memory.place is None or memory.place != ""
    memory.query(name, *args[:-1], None)
    memory.age(name, *args)
    memory.spread(str(name), 1)
    assert name in memory.names()
    assert (name, *args) in memory
    assert memory.facts(str(name))[(name, *args)] == memory.since((name, *args))
    assert memory.canonical((name, *args)) == (name, *args)
    for item in memory.items():
        assert item.name in memory.names_of(item.name)
    for arg in args:
        memory.value(name, *args[:-1])
        memory.kind(arg)
        memory.count("rock", arg)
    for relation in one.session.run.library.signatures.relations:
        memory.query(relation)
        memory.spread(relation)
        state.beliefs(one.session, relation)


def _results(one: Asker) -> None:
    run = one.session.run
    given = [task.goal for task in run.results()]
    run.check([TaskRequest((goal.name, *goal.inputs)) for goal in given])
    assert run.succeeded >= 0
    assert run.reason is None or run.settings.patience


def _observe(one: Asker) -> None:
    run = one.session.run
    assert run.created >= len(run.tasks())
    assert set(run.candidates()) <= {task.number for task in run.tasks()}
    assert all(claim.task.live for claim in run.claims())
    assert (run.cycle, run.serial) == (one.session.cycle, one.session.serial)
    assert run.spec == one.session.spec
    run.families(), run.deadlocks(), run.requests(), run.skills()
    for task in filter(lambda task: task.bound, run.tasks()):
        run.monitored(task)
        for _, query, asker, env in run.conditions(task):
            asked = [*run.explain(query, asker, env, 3)]
            run.solution(query, asker, env)
            for fact in run.supporting(query.formula, env):
                assert fact in run.memory
            for part in asked:
                run.opposing(part.part, env)
                if isinstance(part.part, Proposition):
                    run.pattern(part.part, env)
            assert all(part.solutions for part in asked[:-1])
        methods = run.methods(task.plan)
        assert set(methods).issuperset(run.added_methods.get(task.plan.name, ()))
        for method in methods:
            run.obstacle(task, method, task.env)
        run.notations(task)


def _stand(one: Asker) -> None:
    session = one.session
    assert f"cycle {session.moment.cycle}, time " in session.stand()
    assert session.seen >= session.cycle
    assert session.seen_over in (True, False)
    assert session.now == session.run.now
    assert session.over == bool(session.reason)
    assert session.selected is None or session.selected > 0


def _repeat(one: Asker) -> None:
    cycle = one.cycle()

    def hear(event: ToldEvent) -> None:
        assert event.cycle == cycle
        _memory(one)

    one.session.repeat(cycle, hear)


def _what_if(one: Asker) -> None:
    fact, task = one.fact(), one.task()
    act = one.dice.choice((AssertFact(fact), EraseFacts(fact), FailTask(task)))
    what_if.ahead(one.session, [act], one.dice.randrange(1, 6))


def _find_before(one: Asker) -> None:
    here, kind = one.session.moment, one.dice.choice(sorted(events.kinds()))
    find.find_event(one.session, kind, back=True)
    one.session.goto(here)


def _there_and_back(one: Asker) -> None:
    here = one.session.moment
    one.session.goto(one.cycle())
    one.session.goto(here)


def _world(one: Asker) -> None:
    world = one.session.run.port
    if isinstance(world, Drawable):
        world.picture()
    one.session.run.wrong_beliefs()
    one.session.run.figures()
    if isinstance(world, Adjustable):
        world.adjustable()


def _write(one: Asker) -> None:
    with tempfile.TemporaryDirectory() as folder:
        recorded.write_trace(one.session, Path(folder) / "run.jsonl")


OF_RUNS: Mapping[str, Callable[[Asker], object]] = {
    "agenda": lambda one: one.session.run.agenda(),
    "goals": lambda one: one.session.run.goals(),
    "past": _past,
    "waiting": lambda one: one.session.run.waiting(),
    "results": _results,
    "check_fact": lambda one: one.session.run.check_fact(*one.fact()),
    "question": _formula,
    "memory": _memory,
    "observe": _observe,
    "tree": lambda one: tasks.tree(one.session),
    "chain": lambda one: tasks.chain(one.session, str(one.task())),
    "items": lambda one: state.items(one.session),
    "monitors": lambda one: state.monitors(one.session),
    "claims": lambda one: state.claims(one.session),
    "requests": lambda one: state.requests(one.session),
    "stack": lambda one: state.stack(one.session),
    "skills": lambda one: state.skills(one.session),
    "names": lambda one: state.names_with_facts(one.session),
    "options": lambda one: acts.changeable_options(one.session.run),
}
"""What can be asked of a run, in the middle of a cycle too."""

QUESTIONS: Mapping[str, Callable[[Asker], object]] = {
    **OF_RUNS,
    "save": lambda one: one.session.run.save(),
    "fork": lambda one: one.session.run.fork().step(),
    "world": _world,
    "why": lambda one: why.why(one.session),
    "why a task": lambda one: why.why(one.session, str(one.task())),
    "why not": lambda one: why_not.why_not(one.session, str(one.task())),
    "why not so": lambda one: why_not.why_not_query(
        one.session, one.dice.choice(one.formulas)
    ),
    "who": lambda one: facts.who(one.session, one.pattern()),
    "who in a cycle": lambda one: facts.who(
        one.session, f"{one.pattern()} in {one.cycle()}"
    ),
    "who uses a definition": lambda one: facts.who(one.session, one.named()),
    "history of a definition": lambda one: facts.history_(one.session, one.named()),
    "source": lambda one: state.source(one.session, one.named()),
    "repeat": _repeat,
    "what if": _what_if,
    "belief": lambda one: beliefs.belief(one.session),
    "belief of a fact": lambda one: beliefs.belief(one.session, one.pattern()),
    "commitment": lambda one: commitments.commitment(one.session, one.task()),
    "stale": lambda one: commitments.stale(one.session),
    "why failed": lambda one: why.why(one.session, "failed"),
    "why end": lambda one: why.why(one.session, "end"),
    "goals with obstacles": lambda one: ends.goals(one.session),
    "between": lambda one: differences.diff(
        one.session, f"{one.cycle()} {one.cycle()}"
    ),
    "another branch": lambda one: one.session.told_by("main"),
    "another seed": lambda one: differences.diff(one.session, "seed 3"),
    "timeline": lambda one: times.timeline(one.session),
    "idle": lambda one: idle.idle(one.session, "wheels"),
    "waits": lambda one: times.waits(one.session),
    "waits of a task": lambda one: times.waits(one.session, str(one.task())),
    "history": lambda one: facts.history_(one.session, one.pattern()),
    "history of an item": lambda one: facts.history_(one.session, str(one.fact()[1])),
    "retries": lambda one: times.retries(one.session),
    "deadlines": lambda one: times.deadlines(one.session),
    "stand": _stand,
    "scan": lambda one: [*one.session.scan(first=one.cycle())],
    "find": _find_before,
    "there and back": _there_and_back,
    "write": _write,
}
"""What can be asked of a run and its debugger between two cycles."""


class Asked(msgspec.Struct):
    """What came of a run that was asked."""

    cycles: int
    #: How often each question was asked and had an answer.
    answered: dict[str, int]
    #: Each question that has changed something, with its cycle.
    changed: list[tuple[str, int]]
    #: Whether events and state at the end are those of a run that nobody has asked.
    same: bool


def _ask_in_cycles(one: Asker) -> None:
    """Let a listener ask, at some events of what comes."""
    asking = False

    def hear(event: Event) -> None:
        nonlocal asking
        if not asking and one.dice.random() < _IN_CYCLES:
            asking = True
            _answer(one, one.dice.choice(list(OF_RUNS)))
            asking = False

    one.session.run.listen(hear)


def _answer(one: Asker, question: str) -> bool:
    """Ask a question; whether it had an answer: what was drawn may have none."""
    try:
        QUESTIONS[question](one)
    except (Error, ValueError):
        return False
    return True


def check(make: Callable[[int], History], cycles: int, points: int) -> Asked:
    """Run twice, ask in one of the two runs, and compare.

    Args:
        make: returns a session that ends after so many cycles.
        cycles: how many.
        points: at how many moments questions are asked.
    """
    alone, session = make(cycles), make(cycles)
    alone.go()
    dice = random.Random(cycles + points)
    one = Asker(session, dice)
    _ask_in_cycles(one)
    found = Asked(alone.cycle, {}, [], False)
    most = min(points, alone.cycle - 1)
    for cycle in sorted(dice.sample(range(1, alone.cycle), most)):
        session.goto(cycle)
        if dice.random() < _BETWEEN:
            session.wait()
        state, serial = session.run.save(), session.serial
        for question in dice.sample(list(QUESTIONS), _QUESTIONS_EACH):
            answered = _answer(one, question)
            found.answered[question] = found.answered.get(question, 0) + answered
            if (session.run.save(), session.serial) != (state, serial):
                found.changed.append((question, cycle))
                state, serial = session.run.save(), session.serial
    session.go()
    same = [*session.scan()] == [*alone.scan()]
    found.same = same and session.run.save() == alone.run.save()
    return found


def main() -> None:
    """Ask in all runs and tell what came of it."""
    given = asked_for(__doc__, points=100, cycles=1000)
    failed = False
    for name, make in RUNS.items():
        found = check(make, given.cycles, given.points)
        told = "same" if found.same else "NOT the same"
        print(
            f"{name}: {found.cycles} cycles, {sum(found.answered.values())} answers to "
            f"{len(found.answered)} questions, changed by {found.changed}, {told}",
            flush=True,
        )
        failed |= bool(found.changed) or not found.same
    raise SystemExit(failed)


if __name__ == "__main__":
    main()
