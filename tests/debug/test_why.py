"""What is said of choices is held against the run itself."""

from __future__ import annotations

import random

import pytest

from rapc import events
from rapc.debug.acts import AssertFact
from rapc.debug.history import History
from rapc.debug.questions.commitments import commitment, stale
from rapc.debug.questions.state import monitors
from rapc.debug.questions.what_if import ahead, what_if
from rapc.debug.questions.why import reasons, why
from rapc.debug.questions.why_not import (
    ClauseAsked,
    task_asked,
    why_not,
    why_not_query,
)
from rapc.errors import ArgumentError, FactError
from rapc.events import KnownFact
from tests.debug.sessions import row, scripted, truck
from tests.effort import first

CHOICES = """
(declare-primitive say (?word) (okay hoarse))
(declare-memory-proposition at (?who ?where))
(declare-memory-proposition warm (?where))
(declare-memory-proposition holds (?who ?thing))
(define-rap (greet ?who)
  (succeed (holds ?who note))
  (method shout
    (context (and (at ?who ?where) (warm ?where) (not (holds ?who bell))))
    (primitive (say loud)))
  (method whisper
    (context (and (at ?who ?where) (holds robot ?thing)))
    (primitive (say soft))))
(define-rap (idle) (method (primitive (say nothing))))
"""


def _small(*tasks: str) -> History:
    return scripted(
        CHOICES, *tasks, rows=(row("(say loud)", "hoarse"), row("(say ?word)"))
    )


def test_each_rule_of_choice_is_shown_with_remaining_methods() -> None:
    session = _small("(idle) :priority 1", "(idle) :priority 3", "(idle) :priority 3")
    session.step()
    selected = session.selected
    assert selected in (2, 3)
    choice, _ = reasons(session, selected)
    assert choice.candidates == (1, 2, 3)
    assert choice.rules == (("highest priority", (2, 3)), ("random", (selected,)))


def test_why_agrees_with_the_trace_of_every_cycle() -> None:
    session = truck("(rock-order red 1)", "(rock-order blue 1) :priority 1")
    session.step(150)
    told = session.scan(events.TaskSelected, events.MethodChosen)
    methods = {o.cycle: o.keys for o in told if o.kind is events.MethodChosen}
    chance = random.Random(3)
    selected = [one for one in told if one.kind is events.TaskSelected]
    for one in chance.sample(selected, 40):
        choice, doing = reasons(session, one.keys["task"], one.cycle)
        assert one.keys["task"] in choice.candidates
        for _, left in choice.rules:
            assert one.keys["task"] in left
        if choice.rules:
            assert choice.rules[-1][1] == (one.keys["task"],)
        else:
            assert choice.candidates == (one.keys["task"],)
        if one.cycle in methods:
            keys = methods[one.cycle]
            assert (doing.outcome, doing.said) == ("method", keys["method"])
            [method] = [m for m in doing.methods if m.name == keys["method"]]
            assert method.holds
            for fact in doing.rests_on:
                assert fact.time is not None


def test_method_is_shown_with_its_facts_and_their_sources() -> None:
    session = truck()
    session.goto(60)
    _, found = reasons(session, 41)
    assert (found.outcome, found.said) == ("method", "outside")
    [origin] = found.rests_on
    assert origin.fact == ("location", "item-1", "quarry-1")
    assert (origin.time, origin.cycle) == (141.44, 58)
    assert origin.by == "(eye-scan external) [40]"


def test_unselected_task_is_reported() -> None:
    session = truck()
    session.step(5)
    with pytest.raises(ArgumentError, match="was not selected in cycle 2"):
        why(session, "1 in 2")
    with pytest.raises(ArgumentError, match="was never selected"):
        why(session, "4")
    with pytest.raises(ArgumentError, match="unknown task"):
        why(session, "40")


def test_why_not_says_how_far_each_conjunct_held() -> None:
    session = _small("(greet ann)")
    session.act(AssertFact(("at", "ann", "hall")))
    session.act(AssertFact(("at", "ann", "cellar")))
    answer = task_asked(session, 1)
    shout, whisper = answer.methods
    assert shout.context is not None
    assert [found for _, found in shout.context.parts] == [2, 0]
    assert shout.context.count == 3
    assert shout.context.missing == (("warm", "hall"), ("warm", "cellar"))
    assert not whisper.holds
    session.act(AssertFact(("warm", "hall")))
    session.act(AssertFact(("holds", "ann", "bell")))
    asked = task_asked(session, 1).methods[0].context
    assert asked is not None
    assert asked.unwanted == (KnownFact("(holds ann bell)", 0),)


def test_failing_conjunct_of_a_monitor_has_a_line() -> None:
    session = scripted(
        """
(declare-primitive refuel () (okay))
(declare-memory-proposition fuel (?level))
(define-rap (mend-low-fuel)
  (monitor-state (and (fuel ?level)
                      (< ?level 0)))
  (method (primitive (refuel))))
(define-rap (drive) (method (primitive (refuel))))
""",
        "(mend-low-fuel)",
        "(drive)",
        rows=(row("(refuel)", takes=5),),
    )
    session.act(AssertFact(("fuel", 2)))
    session.step(2)
    lines = why_not(session, "mend-low-fuel").lines
    clause = "monitor-state of `mend-low-fuel`"
    failing = "(< ?level 0) fails, conjunct 2 of 2, with ?level 2"
    assert f"  {clause} at small.rap:6: {failing}" in lines
    (waits,) = monitors(session).rows
    assert (waits["waits for"], waits["where"]) == (
        "(and (fuel ?level) (< ?level 0))",
        "small.rap:5",
    )


def test_why_not_of_an_ended_task_uses_its_last_cycle() -> None:
    session = truck()
    session.go()
    answer = task_asked(session, 9)
    assert " after cycle " in answer.stands[0]
    assert answer.clauses[0].clause == "succeed of `travel-road`"
    assert answer.clauses[0].holds
    assert session.over


def _answers(session: History) -> list[tuple[int, ClauseAsked]]:
    """Return clauses and contexts that fail now, with their tasks."""
    found = []
    for task in session.run.state.live_tasks():
        answer = task_asked(session, task.number)
        asked = [*answer.clauses, *(m.context for m in answer.methods if m.context)]
        found += [(task.number, one) for one in asked if one.missing]
    return found


@pytest.mark.parametrize("answers", first(1, [20, 200]))
def test_named_fact_makes_the_conjunct_true(answers: int) -> None:
    session = truck("(rock-order red 1)", "(rock-order blue 1) :priority 1")
    session.go()
    chance, tried = random.Random(5), 0
    last = session.cycle
    while tried < answers:
        session.goto(chance.randrange(1, last))
        for number, asked in _answers(session):
            fact = chance.choice(asked.missing)
            with session.at():
                try:
                    session.run.assert_fact(*fact)
                except FactError:  # a place of an item, which handlers alone set
                    continue
                again = _same(task_asked(session, number), asked)
            at = len(asked.parts) - 1
            assert again.parts[at][1] > 0, (fact, asked)
            tried += 1


def _same(answer: object, asked: ClauseAsked) -> ClauseAsked:
    """Return what became of a clause when it was asked again."""
    clauses = answer.clauses  # type: ignore[attr-defined]
    methods = answer.methods  # type: ignore[attr-defined]
    found: list[ClauseAsked] = [*clauses, *(m.context for m in methods if m.context)]
    return next(one for one in found if one.clause == asked.clause)


QUERIES = """
(declare-memory-proposition p (?x))
(declare-memory-proposition q (?x ?y))
(define-query (ready ?who)
  (or (p ?who)
      (and (q ?who ?state)
           (not (p ?state)))))
"""


def test_why_not_opens_named_queries_and_branches() -> None:
    session = scripted(QUERIES)
    for fact in (("q", "ann", "idle"), ("p", "idle")):
        session.act(AssertFact(fact))
    [query] = why_not_query(session, "(ready ann)").opened
    assert (query.clause, query.place) == ("query `ready`", "small.rap:5")
    one, both = query.opened
    assert (one.place, one.parts) == ("small.rap:5", (("(p ?who)", 0),))
    assert both.place == "small.rap:7"
    assert [found for _, found in both.parts] == [1, 0]
    assert both.unwanted == (KnownFact("(p idle)", 0),)


def test_why_not_lists_the_facts_of_a_query_that_holds() -> None:
    session = scripted(QUERIES)
    session.act(AssertFact(("p", "ann")))
    asked = why_not_query(session, "(ready ?who)")
    assert asked.holds
    assert [*map(str, asked.rests_on)] == [
        "because of (p ann), asserted at 0 in cycle 0 by user"
    ]
    assert [one.clause for one in asked.opened] == ["query `ready`"]


def test_facts_behind_a_query_have_the_lines_of_their_rules() -> None:
    session = scripted(
        """
(declare-primitive look () (okay))
(declare-memory-proposition seen (?what))
(define-rap (look-around) (method (primitive (look))))
(define-memory-rule (look-around) :finish
  (match-result
    (succeed (rule (true (mem-add (seen door)))))))
""",
        "(look-around)",
        rows=(row("(look)"),),
    )
    session.go()
    because = (
        "because of (seen door), asserted at 1 in cycle 2 by rule of [1] for succeed"
    )
    [line] = map(str, why_not_query(session, "(seen ?what)").rests_on)
    assert line == f"{because} at small.rap:7"


def test_a_query_is_asked_conjunct_by_conjunct() -> None:
    session = truck()
    asked = why_not_query(session, "(and (place ?p quarry) (produces ?p green))")
    assert [found for _, found in asked.parts] == [3, 0]
    assert asked.missing[0] == ("produces", "quarry-1", "green")
    assert asked.near[0].fact.startswith("(produces quarry-1 ")
    assert why_not_query(session, "(place ?p quarry)").holds
    assert why_not_query(session, "(and)").holds


def test_why_failed_names_the_clause_down_to_the_first_cause() -> None:
    session = _small("(greet ann)")
    with pytest.raises(ArgumentError, match="no failed task"):
        why(session, "failed")
    session.act(AssertFact(("at", "ann", "hall")))
    session.act(AssertFact(("warm", "hall")))
    session.go()
    first, *_, last = why(session, "failed").lines
    assert first.startswith("[1] (greet ann) failed in cycle ")
    assert first.endswith(": hoarse")
    assert last.endswith("the world answered `hoarse`")
    with pytest.raises(ArgumentError, match="unknown task"):
        why(session, "failed 7")


def test_stale_commitments_are_reported() -> None:
    session = truck()
    session.goto(60)
    found = {one.task: one for one in stale(session)}
    assert found[7].gone == (("truck-location", "depot"),)
    assert found[7].chosen.keys["bindings"]["?here"] == "depot"
    assert dict(found[7].would)["#1"] == {"?here": "quarry-1"}
    assert commitment(session, 3).now is not None
    with pytest.raises(ArgumentError, match="has no method under way"):
        commitment(session, 4)


def test_what_if_leaves_the_run_unchanged() -> None:
    session = _small("(greet ann)")
    session.act(AssertFact(("at", "ann", "hall")))
    here = session.run.save()
    assert ahead(session, [], 1)[-1].kind is events.TaskFailed
    told = ahead(session, [AssertFact(("warm", "hall"))], 1)
    assert [o.keys["method"] for o in told if "method" in o.keys] == ["shout"]
    found = what_if(session, "(assert (warm hall))").lines
    assert found[0] == "actual:"
    assert "with the change:" in found
    assert session.run.save() == here
    same = what_if(session, "(assert (at bob hall))").lines
    assert same[0] == "no difference:"
