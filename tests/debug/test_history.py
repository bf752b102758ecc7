"""What has been is told as the events have it."""

from __future__ import annotations

import pytest

from rapc.debug.acts import AssertFact, SendSignal
from rapc.debug.history import History
from rapc.debug.questions.facts import history_, who
from rapc.debug.questions.state import beliefs
from rapc.debug.questions.times import deadlines, retries
from rapc.errors import ArgumentError
from tests.debug.sessions import row, scripted, truck


def test_item_history_names_the_source_of_each_change() -> None:
    session = truck()
    session.goto(142)
    found = history_(session, "item-1").rows
    said = [(one[""], one["what"], one["by"]) for one in found]
    assert ("introduced", "item-1 at quarry-1", "(eye-scan external) [40]") in said
    assert ("moved", "item-1 at arm1", "(arm-grasp arm1 item-1) [56]") in said
    colors = history_(session, "item-1 color").rows
    assert {one["what"] for one in colors} == {"(color item-1 red)"}
    assert [one["time"] for one in colors] == [141.94, 142.44]


def test_the_history_of_a_fact_has_each_value() -> None:
    session = truck()
    session.goto(142)
    found = history_(session, "(truck-location ?)").rows
    values = [one["what"] for one in found if one[""] == "+"]
    assert values[:3] == [
        "(truck-location depot)",
        "(truck-location zone-6)",
        "(truck-location zone-4)",
    ]
    assert found[0]["by"] == "datum (new-location depot)"
    assert found[1]["by"] == "(truck-move) [18]"


AGAIN = """
(declare-primitive grip (?thing) (okay slipped))
(define-rap (lift ?thing) (method (primitive (grip ?thing))))
(define-rap (load ?thing)
  (method first (task-net (t1 (lift ?thing))))
  (method second (task-net (t1 (lift ?thing)))))
"""


def test_retries_are_counted_by_goal() -> None:
    session = scripted(AGAIN, "(load box)", rows=(row("(grip ?x)", "slipped"),))
    session.go()
    [lift] = retries(session).rows
    assert lift["goal"] == "(lift box)"
    failed = lift["failed"]
    assert isinstance(failed, int)
    assert failed >= 2
    assert lift["results"] == f"{failed} slipped"
    assert str(lift["most frequent reason"]).startswith("primitive of `lift`")


def test_deadlines_are_told_with_how_late() -> None:
    session = truck("(rock-order red 1) :deadline 100")
    session.go()
    missed = [one for one in deadlines(session).rows if one[""] == "missed"]
    top = next(one for one in missed if one["task"] == 1)
    assert top["deadline"] == 100
    assert top["ended"] == session.now
    assert top["late or left"] == pytest.approx(session.now - 100)
    session.goto(30)
    ahead = deadlines(session).rows
    assert [(one["task"], one[""]) for one in ahead] == [(1, "ahead")]
    assert ahead[0]["late or left"] == pytest.approx(100 - session.now)


def test_uses_of_a_fact_are_listed() -> None:
    session = truck()
    session.goto(50)
    found = who(session, "(truck-location ?where)").rows
    assert found[0]["what"] == "(truck-location zone-2)"
    assert str(found[0]["by"]).startswith("(truck-move)")
    listeners = [one["what"] for one in found if one["use"] == "monitored by"]
    assert [str(one).split()[0] for one in listeners] == ["[6]"]
    assert {one["use"] for one in found} >= {"test", "asserted"}
    assert any(one["what"] == "RAP `travel-road`" for one in found)
    with pytest.raises(ArgumentError, match="unknown predicate `frob`"):
        who(session, "(frob)")


def test_history_names_the_notation_of_a_fact() -> None:
    session = truck()
    session.goto(70)
    found = who(session, "(claimed item-1)").rows
    assert "noted by" in [one["use"] for one in found]


RULES = """
(declare-event :bell (?room))
(declare-memory-property at ((?who symbol) (?where symbol)) nowhere)
(declare-memory-proposition known ((?room symbol)))
(define-query (lost (?room symbol))
  (and (known ?room)
       (at robot nowhere)))
(define-event-rule (:bell ?room)
  (rule
    ((lost ?room)
     (mem-add (at robot ?room)))))
(define-rap (wait-here)
  (monitor-state (lost cellar))
  (method (task-net (t1 (pause)))))
(define-rap (pause) (succeed true))
(define-agenda all (task (wait-here)))
"""


def _rung() -> History:
    session = scripted(RULES, "(wait-here)")
    session.act(AssertFact(("known", "hall")))
    session.act(SendSignal((":bell", "hall")))
    return session


def test_change_by_a_rule_has_its_line_and_the_facts_behind() -> None:
    session = _rung()
    [change] = history_(session, "(at robot ?)").rows
    assert change["by"] == "rule for (:bell hall)"
    assert change["where"] == "small.rap:11"
    [made, behind] = who(session, "(at robot ?) in 0").rows
    assert (made["what"], made["where"]) == ("(at robot hall)", "small.rap:11")
    assert str(behind["what"]).strip() == "(known hall)"
    later = who(session, "(at robot ?) in 4")
    assert later.lines == ("no change in cycle 4; the last change was in cycle 0:",)
    assert later.rows == [made, behind]


@pytest.mark.parametrize(
    ("named", "uses"),
    [
        ("(lost ?)", ["defined", "monitored by", "test", "test"]),
        ("lost", ["defined", "monitored by", "test", "test"]),
        ("all", ["defined", "task", "submits"]),
        (":bell", ["defined", "event", "defined", "ran 1 time"]),
        ("small.rap:10", ["defined", "ran 1 time"]),
        ("pause", ["defined", "goal"]),
    ],
)
def test_uses_of_a_definition_are_listed(named: str, uses: list[str]) -> None:
    assert [one["use"] for one in who(_rung(), named).rows] == uses


def test_history_of_a_definition_lists_its_facts_runs_or_tasks() -> None:
    session = _rung()
    facts = [one["what"] for one in history_(session, "lost").rows]
    assert facts == ["(known hall)", "(at robot hall)"]
    [ran] = history_(session, ":bell").rows
    assert (ran["what"], ran["where"]) == ("?room hall", "small.rap:10")
    for named in ("all", "wait-here"):
        [made] = history_(session, named).rows
        assert (made[""], made["what"]) == ("created", "[1] (wait-here)")


def test_memory_of_a_query_lists_the_facts_it_reads() -> None:
    found = beliefs(_rung(), "lost").rows
    assert [one["fact"] for one in found] == ["(known hall)", "(at robot hall)"]
