"""What has been is told as the events have it."""

from __future__ import annotations

import pytest

from rapc.debug import facts
from rapc.debug.who import who
from rapc.errors import ArgumentError
from tests.debug.sessions import row, scripted, truck


def test_the_history_of_an_item_names_who_did_it() -> None:
    session = truck()
    session.goto(142)
    found = facts.of_item(session, "item-1")
    said = [(one.what, one.said, one.by) for one in found]
    assert ("introduced", "item-1 at quarry-1", "(eye-scan external) [40]") in said
    assert ("moved", "item-1 at arm1", "(arm-grasp arm1 item-1) [56]") in said
    colors = facts.of_item(session, "item-1", "color")
    assert {one.said for one in colors} == {"(color item-1 red)"}
    assert [one.time for one in colors] == [141.94, 142.44]


def test_the_history_of_a_fact_has_each_value() -> None:
    session = truck()
    session.goto(142)
    found = facts.of_facts(session, ("truck-location", "?"))
    values = [one.said for one in found if one.what == "+"]
    assert values[:3] == [
        "(truck-location depot)",
        "(truck-location zone-6)",
        "(truck-location zone-4)",
    ]
    assert found[0].by == "datum (new-location depot)"
    assert found[1].by == "(truck-move) [18]"


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
    [lift] = facts.retries(session)
    assert lift.goal == "(lift box)"
    assert lift.failed >= 2
    assert lift.results == {"slipped": lift.failed}
    assert next(iter(lift.causes)).startswith("primitive of `lift`")


def test_deadlines_are_told_with_how_late() -> None:
    session = truck("(rock-order red 1) :deadline 100")
    session.go()
    missed = [one for one in facts.deadlines(session) if one.missed]
    top = next(one for one in missed if one.task == 1)
    assert top.deadline == 100
    assert top.ended == session.now
    assert top.by == pytest.approx(session.now - 100)
    session.goto(30)
    ahead = facts.deadlines(session)
    assert [(one.task, one.missed) for one in ahead] == [(1, False)]
    assert ahead[0].by == pytest.approx(100 - session.now)


def test_who_has_to_do_with_a_fact() -> None:
    session = truck()
    session.goto(50)
    found = who(session, ("truck-location", "?where"))
    assert found.believed[0].fact == ("truck-location", "zone-2")
    assert found.believed[0].by.startswith("(truck-move)")
    assert [one.task for one in found.listeners] == [6]
    assert {one.use for one in found.places} >= {"test", "asserted"}
    assert any(one.form == "define-rap travel-road" for one in found.places)
    with pytest.raises(ArgumentError, match="`frob` is not declared"):
        who(session, ("frob",))


def test_who_has_noted_a_fact() -> None:
    session = truck()
    session.goto(70)
    assert who(session, ("claimed", "item-1")).noted_by
