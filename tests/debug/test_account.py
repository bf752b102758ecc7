"""The account of a run: each moment counts once, and each wait has its reason."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest

import rapc
from rapc import events
from rapc.debug.account import Account, Wait
from rapc.debug.history import History
from rapc.debug.questions.times import account, waits
from rapc.events import Goal
from rapc.worlds.script import At, Row
from rapc.worlds.scripted import ScriptedWorld
from tests.debug.sessions import truck


def _account(
    text: str, *tasks: str, rows: tuple[Row, ...] = (), at: tuple[At, ...] = ()
) -> Account:
    """Return the account of a run of a library in a scripted world."""
    library = rapc.loads(text, "small.rap")
    world = ScriptedWorld(list(rows), list(at), declared=library.program.library)
    history = History.open(library, world, tasks=tasks)
    history.go()
    return account(history)


def _told(wait: Wait) -> tuple[object, ...]:
    return wait.kind, wait.on, wait.task, wait.start, wait.stop, wait.by


def _pieces(found: Account) -> list[tuple[object, ...]]:
    return [(one.start, one.stop, one.kind, one.what) for one in found.of_run]


GO = """
(declare-primitive go (?x) (okay) :atomic false)
(declare-memory-proposition there (?x))
(declare-event :call (?x))
"""


def test_wait_for_a_monitor_lasts_until_a_task_is_woken() -> None:
    text = f"""{GO}
    (define-rap (watch ?x) (monitor-state (there ?x)) (method (primitive (go ?x))))
    """
    at = (At(7, asserts=(("there", "a"),)),)
    found = _account(text, "(watch a)", rows=(Row(("go", "?"), after=2),), at=at)
    assert [_told(one) for one in found.waits] == [
        ("monitor", "(there a)", 1, 0, 7, None),
        ("device", "(go a)", 1, 7, 9, None),
    ]
    assert _pieces(found) == [
        (0, 7, "waiting", "monitor of watch"),
        (7, 9, "acting", "go"),
    ]


def test_steps_wait_for_order_then_for_a_window_or_a_signal() -> None:
    text = f"""{GO}
    (define-rap (tour)
      (method (task-net
        (t1 (drive a) (for t2))
        (t2 (drive b) (window t1 5 9))
        (t3 (drive c) (wait-for (:call ?x) :proceed)))))
    (define-rap (drive ?x) (method (primitive (go ?x))))
    """
    at = (At(20, signals=((":call", "d"),)),)
    found = _account(text, "(tour)", rows=(Row(("go", "?"), after=2),), at=at)
    told = [_told(one)[:5] for one in found.waits if one.kind != "device"]
    assert ("order", "preceding steps", 3, 0, 2) in told
    assert ("window", "its start time", 3, 2, 7) in told
    assert ("signal", "(:call ?x)", 4, 0, 20) in told
    assert [one[3] for one in _pieces(found)] == [
        "go",
        "signal :call for drive",
        "go",
        "signal :call for drive",
        "go",
    ]


def test_tasks_wait_for_things_and_after_a_suspension() -> None:
    text = f"""{GO}
    (define-rap (drive ?x) (method (claims wheels) (primitive (go ?x))))
    (declare-primitive push (?x) (okay) :atomic false :uses (wheels))
    (define-rap (shove ?x) (method (primitive (push ?x))))
    """
    rows = (Row(("go", "?"), after=4), Row(("push", "?"), after=4))
    tasks = ("(drive a) :priority 1", "(drive b)", "(shove c) :at 9")
    found = _account(text, *tasks, "(shove d) :at 10 :priority 3", rows=rows)
    told = [_told(one) for one in found.waits if one.kind != "device"]
    assert ("thing", "wheels", 2, 0, 4, 1) in told
    assert ("suspended", "wheels", 3, 10, 14, 4) in told
    [shoved] = [pieces for task, pieces in found.of_family.items() if task == 3]
    assert [(one.kind, one.what) for one in shoved] == [
        ("acting", "push"),
        ("suspended", "by shove for wheels"),
        ("acting", "push"),
    ]


def test_idle_run_waits_for_the_arrival_of_a_task() -> None:
    text = f"{GO}(define-rap (drive ?x) (method (primitive (go ?x))))"
    rows = (Row(("go", "?"), after=1),)
    found = _account(text, "(drive a)", "(drive b) :at 5", rows=rows)
    assert _pieces(found) == [
        (0, 1, "acting", "go"),
        (1, 5, "waiting", "arrival of drive"),
        (5, 6, "acting", "go"),
    ]
    assert [one.outcome for one in found.families.values()] == ["succeeded"] * 2


def test_background_skills_are_no_actions() -> None:
    text = """
    (declare-skill :hum ())
    (declare-skill :look ())
    (declare-event :seen ())
    (define-rap (stand)
      (method (skills (:hum)) (task-net (t1 (look)))))
    (define-rap (look)
      (method (primitive (enable (:look)) (wait-for (:seen) :succeed))))
    """
    found = _account(text, "(stand) :at 2", at=(At(6, signals=((":seen",),)),))
    assert _pieces(found) == [
        (0, 2, "waiting", "arrival of stand"),
        (2, 6, "acting", ":look"),
    ]


def _courier() -> History:
    library = rapc.load("examples/courier")
    return History.open(library, "courier", agenda="shift", seed=1)


def _hallway() -> History:
    return History.open(rapc.load("stdlib/hallway"), "hallway", agenda="errand")


@pytest.mark.parametrize(
    "make", [_courier, _hallway, lambda: truck("(rock-order red 1)")]
)
def test_time_of_run_and_families_has_no_gaps(make: object) -> None:
    assert callable(make)
    history = make()
    history.goto_time(400)
    whole = account(history)
    assert sum(one.stop - one.start for one in whole.of_run) == pytest.approx(
        history.now
    )
    assert all(one.stop == two.start for one, two in pairwise(whole.of_run))
    assert whole.families
    for number, family in whole.families.items():
        pieces = whole.of_family[number]
        assert all(one.stop == two.start for one, two in pairwise(pieces))
        end = history.now if family.ended is None else family.ended
        if pieces:
            assert (pieces[0].start, pieces[-1].stop) == (family.came, end)
    for wait in whole.waits:
        assert wait.stop > wait.start


def test_waits_are_listed_for_a_task_and_its_steps() -> None:
    history = _courier()
    history.goto_time(300)
    found = waits(history, "3").rows
    suspended = [one for one in found if one["for"] == "suspended"]
    assert [(one["from"], one["to"], one["of"]) for one in suspended] == [
        (48, 116, "[2]"),
        (131, 164, "[1]"),
    ]
    [answers] = [one for one in waits(history).rows if one["what"] == "(can-help ?)"]
    assert (answers["for"], answers["by tasks of"]) == ("monitor", "answer-calls")


def test_request_ends_when_its_item_was_merged_into_another() -> None:
    """The end of the request has the older name of the item."""
    found = Account()
    goal = Goal("look", ("rock-2",))
    common: dict[str, Any] = {"cycle": 1, "task": 1}
    asked = ("examine", "rock-2")
    for event in (
        events.TaskCreated(
            n=0,
            time=0,
            goal=goal,
            parent=None,
            family=1,
            priority=0,
            step=None,
            **common,
        ),
        events.PrimitiveRequested(n=1, time=1, request=asked, sent=asked, **common),
        events.PrimitiveEnded(
            n=2, time=3, request=("examine", "rock-1"), result="okay", data=(), **common
        ),
    ):
        found(event)
    found.close(9)
    [spell] = found.spells
    assert (spell.start, spell.stop, spell.result) == (1, 3, "okay")
