"""What has been is told as the events have it."""

from __future__ import annotations

import pytest

from rapc.debug.questions.facts import history_, who
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
    assert found[0]["by"] == "(truck-location zone-2)"
    assert ", by (truck-move)" in str(found[0]["where"])
    listeners = [one["by"] for one in found if one["use"] == "monitored by"]
    assert [str(one).split()[0] for one in listeners] == ["[6]"]
    assert {one["use"] for one in found} >= {"test", "asserted"}
    assert any(one["by"] == "define-rap travel-road" for one in found)
    with pytest.raises(ArgumentError, match="unknown predicate `frob`"):
        who(session, "(frob)")


def test_history_names_the_notation_of_a_fact() -> None:
    session = truck()
    session.goto(70)
    found = who(session, "(claimed item-1)").rows
    assert "noted by" in [one["use"] for one in found]
