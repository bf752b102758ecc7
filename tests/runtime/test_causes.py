"""Why tasks fail: every way there is, with its clause, line, culprit and bindings.

In each library the comment `; here` marks the line that the cause names. The table of
docs/trace.md lists the same ways.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from io import StringIO
from types import MappingProxyType
from typing import Any, NamedTuple

import pytest

from rapc.runtime.events import events
from rapc.runtime.events.events import Cause, MethodEnded, TaskFailed
from rapc.runtime.events.report import cause_lines
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import read_task_request
from rapc.runtime.tasks.causes import LONGEST, following
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld
from tests.runtime.helpers import ANY, DECLARATIONS, Play, at, compiled, fact, row


class Way(NamedTuple):
    """A library whose task `(top a)` fails, and the first cause expected of it."""

    text: str
    clause: str
    part: str = ""
    bindings: Mapping[str, str] = MappingProxyType({})
    note: str = ""
    facts: tuple[str, ...] = ()
    rows: tuple[Any, ...] = ()
    times: tuple[Any, ...] = ()
    methods: tuple[str, ...] = ()


WAYS = {
    "preconditions": Way(
        """(define-rap (top ?x)
             (preconditions (and (q ?x ?y)
                                 (p ?y)  ; here
                                 (go)))
             (method (primitive (act ?x))))""",
        "preconditions of `top`",
        "(p ?y)",
        {"?y": "b"},
        facts=("(q a b)",),
    ),
    "constraints of its own": Way(
        """(define-rap (top ?x)
             (constraints (not (p ?x)))  ; here
             (method (primitive (act ?x))))""",
        "constraints of `top`",
        "(not (p ?x))",
        {"?x": "a"},
        facts=("(p a)",),
    ),
    "constraints of a task above": Way(
        """(define-rap (top ?x) (succeed (go))
             (constraints (not (p ?x)))  ; here
             (method (task-net (t1 (one) (for t2)) (t2 (one)))))
           (define-rap (one) (method (primitive (act x))))""",
        "constraints of `top`",
        "(not (p ?x))",
        {"?x": "a"},
        rows=(row("(act x)", asserts=["(p a)"]),),
    ),
    "constraints of a method": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (context (q ?x ?y)) (constraints (not (p ?y)))  ; here
               (task-net (t1 (one) (for t2)) (t2 (one)))))
           (define-rap (one) (method (primitive (act x))))""",
        "constraints of method `#1` of `top`",
        "(not (p ?y))",
        {"?y": "b"},
        facts=("(q a b)",),
        rows=(row("(act x)", asserts=["(p b)"]),),
    ),
    "a `for` formula": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (one) ((and (q ?x ?y)
                               (p ?y)) for t2))  ; here
               (t2 (one)))))
           (define-rap (one) (method (primitive (act x))))""",
        "`for` formula of step `t1` of `top`",
        "(p ?y)",
        {"?y": "b"},
        facts=("(q a b)",),
    ),
    "an input that is not bound": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (one ?y)))))  ; here
           (define-rap (one ?z) (method (primitive (act ?z))))""",
        "inputs of step `t1` of `top`",
        "(one ?y)",
        note="?y not bound",
    ),
    "resources that cannot be": Way(
        """(define-rap (top ?x)
             (resources (counter ?c ?x))  ; here
             (method (primitive (act ?x))))""",
        "resources of `top`",
        "?x",
        {"?x": "a"},
        note="is no counter",
    ),
    "a window that is no time": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (one) (window now ?x 9)))))  ; here
           (define-rap (one) (method (primitive (act x))))""",
        "window of step `t1`",
        "?x",
        {"?x": "a"},
        note="`a` is not a number",
    ),
    "repeat-while": Way(
        """(define-rap (top ?x)
             (repeat-while (q ?x ?y))  ; here
             (method (primitive (act ?x))))""",
        "repeat-while of `top`",
        "(q ?x ?y)",
        {"?x": "a"},
    ),
    "no method": Way(
        """(define-rap (top ?x)  ; here
             (method one (context (p ?x)) (primitive (act ?x)))
             (method two (context (and (q ?x ?y) (p ?y))) (primitive (act ?x))))""",
        "methods of `top`",
        facts=("(q a b)",),
        methods=("context of method `one` (p ?x)", "context of method `two` (p ?y)"),
    ),
    "no method at all": Way(
        "(define-rap (top ?x) (succeed (go)))  ; here",
        "methods of `top`",
        note="none",
    ),
    "a futile choice": Way(
        """(define-rap (top ?x) (succeed (go))
             (method try (context (q ?x ?y))  ; here
               (primitive (act ?y))))""",
        "method `try` of `top`",
        bindings={"?x": "a", "?y": "b"},
        note="chosen 2 times with the same bindings",
        facts=("(q a b)",),
    ),
    "a goal that stands above": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (top ?x)))))  ; here""",
        "step `t1`",
        "(top ?x)",
        {"?x": "a"},
        note="repeats (top a) [1]",
    ),
    "a goal that turns out to stand above": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (find => ?y) (for t2))
               (t2 (top ?y)))))  ; here
           (define-rap (find => ?w) (succeed (q found ?w))
             (method (primitive (act x))))""",
        "step `t2`",
        "(top ?y)",
        {"?y": "a"},
        note="repeats (top a) [1]",
        rows=(row("(act x)", asserts=["(q found a)"]),),
    ),
    "outputs": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (find => ?x)))))  ; here
           (define-rap (find => ?w) (succeed (q found ?w))
             (method (primitive (act x))))""",
        "outputs of step `t1` of `top`",
        "?x",
        {"?x": "a"},
        note="is not `b`",
        facts=("(q found b)",),
    ),
    "effects": Way(
        """(define-rap (top ?x) (succeed (go)) (resources (counter ?c 0))
             (method (task-net
               (t1 (one) (counter-add ?c ?x)))))  ; here
           (define-rap (one) (succeed (go2)) (method (primitive (act x))))
           (declare-memory-proposition go2 ())""",
        "effects of step `t1` of `top`",
        bindings={"?c": "#counter(0)", "?x": "a"},
        note="one of them cannot be made",
        rows=(row("(act x)", asserts=["(go2)"]),),
    ),
    "a notation that is not bound": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (notations (q ?x ?free))  ; here
               (primitive (act ?x))))""",
        "notation of `top`",
        "(q ?x ?free)",
        {"?x": "a"},
        note="?free is not bound",
    ),
    "a request that is not bound": Way(
        """(define-rap (top ?x) (succeed (go))
             (method
               (primitive (act ?free))))  ; here""",
        "request of `top`",
        "(act ?free)",
        note="?free is not bound",
    ),
    "a claim that is not bound": Way(
        """(define-rap (top ?x) (succeed (go))
             (method
               (claims (arm ?x) (arm ?free))  ; here
               (primitive (act ?x))))""",
        "claims of method `#1` of `top`",
        "(arm ?free)",
        note="?free is not bound",
    ),
    "a resource that is to be noted": Way(
        """(define-rap (top ?x) (succeed (go))
             (resources (counter ?c))
             (method
               (notations (q ?x ?c))  ; here
               (primitive (act ?x))))""",
        "notation of `top`",
        "(q ?x ?c)",
        {"?x": "a", "?c": "#counter(0)"},
        note="?c is a resource",
    ),
    "a delay that is no time": Way(
        """(define-rap (top ?x) (succeed (go))
             (monitor-time now ?x 9)  ; here
             (method (primitive (act ?x))))""",
        "monitor-time of `top`",
        "?x",
        {"?x": "a"},
        note="`a` is not a number",
    ),
    "a skill that is not bound": Way(
        """(declare-skill :hum (?x))
           (declare-event :done ())
           (define-rap (top ?x) (succeed (go))
             (method (primitive
               (wait-for (:done) :succeed)
               (enable (:hum ?x) (:hum ?free)))))  ; here""",
        "skill of `top`",
        "(:hum ?free)",
        note="?free is not bound",
    ),
    "an event that fails a primitive": Way(
        """(declare-skill :hum (?x))
           (declare-event :stuck (?where))
           (define-rap (top ?x) (succeed (go))
             (method (primitive
               (enable (:hum ?x))
               (wait-for (:stuck ?where) :fail))))  ; here""",
        "wait-for of `top`",
        "(:stuck ?where)",
        {"?where": "b"},
        note="its event came",
        rows=(Row((":hum", "?"), kind="enable", after=2, signals=((":stuck", "b"),)),),
    ),
    "a request that the world refuses": Way(
        """(define-rap (top ?x) (succeed (go))
             (method
               (primitive (slow ?x))))  ; here""",
        "primitive of `top`",
        "(slow ?x)",
        {"?x": "a"},
        note="the world refused it, and nothing could be waited for",
        rows=(Row(("slow", "?"), refused=True),),
    ),
    "skills that the world refuses": Way(
        """(declare-skill :hum (?x))
           (declare-event :done ())
           (define-rap (top ?x) (succeed (go))
             (method (primitive
               (wait-for (:done) :succeed)
               (enable (:hum ?x)))))  ; here""",
        "skill of `top`",
        "(:hum ?x)",
        {"?x": "a"},
        note="the world refused it, and nothing could be waited for",
        rows=(Row((":hum", "?"), kind="enable", refused=True),),
    ),
    "what the world answers": Way(
        """(define-rap (top ?x) (succeed (go))
             (method
               (primitive (act ?x))))  ; here""",
        "primitive of `top`",
        "(act ?x)",
        {"?x": "a"},
        note="the world answered `dropped`",
        rows=(row("(act a)", "dropped"),),
    ),
    "a signal": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net
               (t1 (one) (wait-for (:bump) :fail)))))  ; here
           (define-rap (one) (method (primitive (slow x))))
           (declare-event :bump ())""",
        "wait-for of step `t1`",
        note="its signal came",
        rows=(row("(slow x)", after=9, signals=((":bump",),)),),
    ),
    "a step of a step": Way(
        """(define-rap (top ?x) (succeed (go))
             (method (task-net (t1 (middle ?x)))))
           (define-rap (middle ?x) (succeed (go))
             (method (task-net (t2 (low ?x)))))
           (define-rap (low ?x)
             (preconditions (p ?x))  ; here
             (method (primitive (act ?x))))""",
        "preconditions of `low`",
        "(p ?x)",
        {"?x": "a"},
    ),
}
"""Every way to fail; the clause is that of some cause in the chain."""


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
