"""Idle times of a thing, and the tasks that could have used it."""

from __future__ import annotations

import pytest

import rapc
from rapc.debug.history import History
from rapc.debug.questions.idle import idle
from rapc.errors import ArgumentError
from rapc.worlds.script import At, Row
from rapc.worlds.scripted import ScriptedWorld

TEXT = """
(declare-primitive lift (?arm ?x) (okay) :atomic false :uses ((arm ?arm)))
(declare-primitive drive () (okay) :atomic false :uses (wheels))
(declare-memory-proposition wanted (?x))
(define-rap (take ?arm ?x) (method (primitive (lift ?arm ?x))))
(define-rap (fetch ?x)
  (method (claims wheels) (task-net (t1 (take left ?x) (for t2)) (t2 (go)))))
(define-rap (go) (method (primitive (drive))))
(define-rap (take-wanted ?x)
  (monitor-state (wanted ?x))
  (method (primitive (lift left ?x))))
"""


def _history(*tasks: str) -> History:
    rows = [Row(("lift", "?", "?"), after=3), Row(("drive",), after=5)]
    library = rapc.loads(TEXT, "arms.rap")
    ats = [At(15, asserts=(("wanted", "c"),))]
    world = ScriptedWorld(rows, ats, declared=library.program.library)
    history = History.open(library, world, tasks=tasks)
    history.go()
    return history


def test_idle_times_lie_between_uses_and_claims() -> None:
    history = _history("(fetch a)", "(fetch b)", "(take-wanted c)")
    assert history.now == 18
    serial, state = history.serial, history.run.save()
    found = idle(history, "(arm left)")
    spans = [(row["from"], row["to"]) for row in found.rows]
    assert list(dict.fromkeys(spans)) == [(3, 8), (11, 15)]
    assert found.notes == ("(arm left) idle: 9 of 18, 50 %",)
    [waiting] = [row for row in found.rows if row["from"] == 3]
    assert waiting["task"] == "[2]"
    assert waiting["waits for"] == "wheels, held by (fetch a) [1]"
    [nobody] = [row for row in found.rows if row["from"] == 11]
    assert (nobody["task"], nobody["goal"]) == (None, "no task could use it")
    assert (history.serial, history.run.save()) == (serial, state)


def test_claimed_thing_is_not_idle() -> None:
    found = idle(_history("(fetch a)", "(take right b) :at 10"), "wheels")
    [row] = found.rows
    assert (row["from"], row["to"]) == (8, 13)
    assert idle(_history("(fetch a)"), "wheels").lines == ("never idle",)


@pytest.mark.parametrize(
    ("thing", "why"),
    [
        ("wheel", r"unknown thing `wheel`"),
        ("arm", "unknown thing `arm`"),
        ("(arm ?x)", "must not contain variables"),
    ],
)
def test_unknown_thing_is_refused(thing: str, why: str) -> None:
    with pytest.raises(ArgumentError, match=why):
        idle(_history("(fetch a)"), thing)
