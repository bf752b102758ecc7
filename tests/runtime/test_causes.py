"""Why tasks fail: every way there is, with its clause, line, culprit and bindings."""

from __future__ import annotations

import json
from io import StringIO
from typing import Any

import pytest

from rapc import events
from rapc.events import Cause, KnownFact, MethodEnded, TaskFailed
from rapc.runtime.events.report import cause_lines
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import read_task_request
from rapc.runtime.tasks.causes import LONGEST, following
from rapc.worlds.scripted import ScriptedWorld
from tests.runtime.helpers import ANY, DECLARATIONS, Play, at, compiled, fact, row
from tests.runtime.ways_to_fail import WAYS, Way


def _play(way: Way) -> Play:
    given = Play(way.text, "(top a)", facts=way.facts, rows=way.rows, times=way.times)
    return given.run(until=50)


def _chain(play: Play) -> list[Cause]:
    """All causes told in a run, each with those it came from."""
    found: list[Cause] = []
    for event in play.events:
        cause = getattr(event, "because", None)
        while isinstance(cause, Cause):
            found.append(cause)
            cause = cause.because
    return found


@pytest.mark.parametrize("name", WAYS)
def test_each_way_to_fail_is_told(name: str) -> None:
    way = WAYS[name]
    play = _play(way)
    found = [cause for cause in _chain(play) if cause.clause == way.clause]
    assert found, [cause.clause for cause in _chain(play)]
    cause = found[0]
    lines = (DECLARATIONS + way.text).splitlines()
    [line] = [at for at, line in enumerate(lines, 1) if "; here" in line]
    assert cause.place == f"t.rap:{line}"
    assert (cause.part, dict(cause.bindings)) == (way.part, dict(way.bindings))
    assert cause.note == way.note
    assert tuple(f"{m.clause} {m.part}" for m in cause.methods) == way.methods


@pytest.mark.parametrize("name", WAYS)
def test_the_task_given_has_the_chain_down_to_it(name: str) -> None:
    """The last link of what is told of the top-level task is a cause of its own."""
    [result] = _play(WAYS[name]).interpreter.results()
    if result.outcome != "failed":
        assert name == "constraints of a method"
        return
    lines = list(cause_lines(result.because))
    assert lines
    assert all(line.startswith(("because of ", "  ", "...")) for line in lines)


@pytest.mark.parametrize("name", WAYS)
def test_finding_it_out_changes_nothing(name: str) -> None:
    """The same events but for the causes, whether or not anybody is told of them."""
    way = WAYS[name]
    told = StringIO()
    kinds = [e for e in _kinds() if e not in (TaskFailed, MethodEnded)]
    loud = _play(way)
    trace = JsonTrace(told)
    for event in loud.events:
        trace(event)
    seen: list[object] = []
    other = _quiet(way, kinds, seen)
    assert seen == [e for e in loud.events if type(e) in kinds]
    assert [(r.outcome, r.result) for r in other.interpreter.results()] == [
        (r.outcome, r.result) for r in loud.interpreter.results()
    ]
    for line in told.getvalue().splitlines():
        json.loads(line)


def _kinds() -> list[Any]:
    return [
        kind
        for kind in vars(events).values()
        if isinstance(kind, type)
        and issubclass(kind, events.Event)
        and kind not in (events.Event, events.ItemEvent, events.RunEnded)
    ]


def _quiet(way: Way, kinds: list[Any], seen: list[object]) -> Play:
    """A run of which nobody is told why anything failed."""
    play = Play.__new__(Play)
    library = compiled(way.text)
    play.world = ScriptedWorld((*way.rows, *ANY), way.times, declared=library.library)
    play.interpreter = Interpreter(library, play.world, 0)
    play.interpreter.listen(seen.append, *kinds)
    play.interpreter.start()
    for one in way.facts:
        play.interpreter.assert_fact(*fact(one))
    play.interpreter.submit(read_task_request("(top a)"))
    play.interpreter.run(until=50)
    return play


def test_a_saved_run_still_knows_why() -> None:
    """What a task remembers of its last method is saved with it."""
    way = WAYS["a futile choice"]
    rows = (row("(act b)", "dropped"),)
    play = Play(way.text, "(top a)", facts=way.facts, rows=rows)
    play.interpreter.step()
    other = play.interpreter.fork()
    told: list[Any] = []
    other.listen(told.append)
    play.run()
    other.run()
    [one] = [e for e in told if type(e) is TaskFailed]
    [same] = play.of(TaskFailed)
    assert one.because == same.because
    assert one.because is not None
    assert one.because.because is not None
    assert one.because.because.note == "the world answered `dropped`"


OLD = """(define-rap (top ?x)
  (succeed (go))
  (method first (context (not (p ?x))) (primitive (act a)))
  (method other (context otherwise) (task-net (t1 (later))))
  (method never (context (prepared ?x)) (primitive (act b))))
(define-rap (later) (method (task-net (t1 (pause) (window now 5 5)))))
(define-rap (pause) (succeed true))
(define-query (prepared ?y)
  (or (q ?y ready)
      (and (p ?y) (q ?y ?state) (go))))"""


def test_a_futile_choice_has_excluded_methods_with_old_facts() -> None:
    play = Play(OLD, "(top a)", facts=("(p a)", "(q a idle)")).run(until=50)
    [failed] = [e for e in play.of(TaskFailed) if e.goal.name == "top"]
    assert failed.because is not None
    first, never = failed.because.methods
    assert first.part == "(not (p ?x))"
    assert first.facts == (KnownFact("(p a)", 10),)
    assert first.line().endswith("does not hold: memory has (p a), 10 old")
    [query] = never.inside
    either, both = query.inside
    assert (either.clause, either.part) == ("branch", "(q ?y ready)")
    assert (both.part, both.bindings) == ("(go)", {})
    line = (DECLARATIONS + OLD).count("\n")
    assert [one.place for one in (query, either, both)] == [
        f"t.rap:{line}",
        f"t.rap:{line}",
        f"t.rap:{line + 1}",
    ]


def test_a_false_property_is_reported_with_its_value() -> None:
    text = """(declare-memory-property at ((?who symbol) (?where symbol)) nowhere)
      (define-rap (top ?x) (preconditions (at ?x hall)) (method (primitive (act ?x))))
    """
    play = Play(text, "(top a)", facts=("(at a cellar)",)).run(until=50)
    [failed] = play.of(TaskFailed)
    assert failed.because is not None
    assert failed.because.facts == (KnownFact("(at a cellar)", 0),)


def test_a_long_chain_loses_its_middle() -> None:
    """The nearest causes and the first one stay."""
    chain = None
    for n in range(100):
        chain = following(Cause(str(n)), chain)
    found = []
    skipped = 0
    while chain is not None:
        found.append(chain.clause)
        skipped += chain.skipped
        chain = chain.because
    assert found[0] == "99"
    assert found[-1] == "0"
    assert len(found) <= LONGEST + 1
    assert len(found) + skipped == 100


def test_times_of_tasks_stand_in_the_results() -> None:
    """When a task came and when it ended."""
    play = Play(
        "(define-rap (top ?x) (succeed (p ?x)) (method (primitive (slow ?x))))",
        "(top a) :at 3",
        rows=[row("(slow a)", after=4, asserts=["(p a)"])],
        times=[at(1, "(go)")],
    ).run()
    [result] = play.interpreter.results()
    assert (result.came, result.ended) == (3, 7)
