"""The end of a run and what kept its goals, with planted faults."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import rapc
from rapc.debug.account import Account
from rapc.debug.history import History
from rapc.debug.questions.ends import goals, goals_of
from rapc.debug.questions.why import why
from rapc.runtime.events.report import OF_GOALS
from rapc.runtime.task_request import TaskRequest
from tests.debug.planted import FAULTS
from tests.debug.sessions import row, scripted

_FAULTS = {fault.name: fault for fault in FAULTS}


def _faulty(folder: Path, name: str) -> History:
    """Return a run of a library with a planted fault, to its end or to time 2000."""
    fault = _FAULTS[name]
    fault.plant(folder)
    loaded = rapc.load(folder)
    session = History.open(
        loaded,
        fault.library,
        agenda=fault.agenda,
        seed=fault.seed,
        options=dict(fault.options),
    )
    session.goto_time(2000)
    return session


def _places(rows: Sequence[Mapping[str, object]]) -> list[str]:
    return [str(one["where"]).rpartition("/")[2] for one in rows if one["where"]]


def test_end_by_the_world_names_the_wake_that_came_too_late(tmp_path: Path) -> None:
    session = _faulty(tmp_path, "charges-too-late")
    assert session.stand().endswith(
        "run ended (world: the battery is empty, 8 along the corridor)"
    )
    answer = why(session, "end")
    request, choice, wake = answer.rows
    assert request["what"] == "(drive base): battery-empty"
    assert (choice["task"], choice["time"]) == ("[2] (stay-charged)", 108)
    assert "?level 14" in str(choice["because of"])
    assert wake["what"] == "woken by (low)"
    assert wake["because of"] == "(battery 14) (< ?level 18)"
    assert _places([wake]) == ["charging.rap:8"]
    assert answer.notes == ("2 goals not reached: see `:goals`",)


def test_end_names_the_task_that_held_the_thing(tmp_path: Path) -> None:
    answer = why(_faulty(tmp_path, "way-home-forgotten"), "end")
    waited, wake, choice, constraints = answer.rows[-4:]
    assert (waited["time"], waited["task"]) == (145, "[2] (stay-charged)")
    assert waited["what"] == "waited 28 for wheels of [1] (answer-calls)"
    assert (wake["time"], wake["what"]) == (117, "woken by (low)")
    assert (choice["task"], choice["time"]) == ("[1] (answer-calls)", 97)
    assert choice["what"] == "chose method go"
    assert constraints["what"] == "under constraints (can-reach ?ward 10)"
    assert constraints["because of"] == "(> ?level (+ (way ?here ?room) ?spare))"
    assert _places([choice, constraints]) == ["calls.rap:21", "moving.rap:40"]


def test_goal_lists_failed_requests_with_the_missing_claim(tmp_path: Path) -> None:
    found = goals(_faulty(tmp_path, "drives-off-while-loading")).rows
    failed = [one for one in found if one["kept by"] == "take-on: robot-left"]
    assert [one["times"] for one in failed] == [4, 7, 2]
    assert set(_places(failed)) == {"orders.rap:37"}
    assert all(
        str(one["because of"]).endswith(
            "`from-a-store` of `fetch` does not claim wheels"
        )
        for one in failed
    )
    assert "drive of [2] (stay-charged) 2 times" in str(failed[1]["because of"])


def test_goal_lists_waits_with_the_condition_of_the_holder(tmp_path: Path) -> None:
    found = goals(_faulty(tmp_path, "never-fully-charged")).rows
    waits = [
        one for one in found if one["kept by"] == "waiting for wheels of stay-charged"
    ]
    assert "it waited for (or (charged) " in str(waits[0]["because of"])
    assert _places(waits) == ["charging.rap:13"] * len(waits)


def test_failed_goal_lists_the_excluded_method(tmp_path: Path) -> None:
    found = goals(_faulty(tmp_path, "sold-out-for-ever")).rows
    [failed] = [one for one in found if one["kept by"] == "failed: sold-out"]
    assert str(failed["because of"]).endswith("(sold-out kitchen meals), 800 old")
    assert _places([failed]) == ["orders.rap:39"]


def test_failed_background_task_is_listed_with_its_cause() -> None:
    text = """
    (declare-primitive press () (okay stuck))
    (declare-primitive rest () (okay))
    (define-rap (guard) (method (primitive (press))))
    (define-rap (work) (method (primitive (rest))))
    """
    rows = (row("(press)", "stuck"), row("(rest)", takes=5))
    tasks = (TaskRequest(("guard",), 5, background=True), "(work)")
    session = scripted(text, *tasks, rows=rows)
    session.go()
    guard, work = goals(session).rows
    assert (guard["task"], guard["result"]) == (1, "failed at 2")
    assert guard["kept by"] == "failed: stuck"
    assert guard["where"] == "small.rap:4"
    assert (work["task"], work["result"]) == (2, "succeeded at 7")
    _, line = why(session, "end").lines
    said = "small.rap:4: background task [1] (guard) failed at 2: stuck; because of "
    assert line.startswith(said)
    assert goals_of([*session.scan(*OF_GOALS)], 7, None, all_=False).rows == [guard]


def test_end_of_a_run_that_goes_on_is_not_explained() -> None:
    session = scripted("(define-rap (rest) (succeed true))", "(rest)")
    assert why(session, "end").lines == ("the run has not ended",)
    assert goals(session).rows[0]["result"] == "under way since 0"
    session.go()
    assert why(session, "end").lines == ("run ended (done) at time 0",)
    assert goals(session).rows[0]["result"] == "succeeded at 0"


def test_stuck_run_lists_the_signal_that_a_goal_waits_for() -> None:
    text = """
    (declare-event :bell ())
    (define-rap (listen)
      (method (task-net (t1 (hear) (wait-for (:bell) :proceed)))))
    (define-rap (hear) (succeed true))
    """
    session = scripted(text, "(listen)")
    session.go()
    assert session.stand() == "cycle 1, time 0, run ended (stuck)"
    [only] = goals(session).rows
    assert only["result"] == "under way since 0"


def test_account_needs_only_the_events_of_goals() -> None:
    assert set(Account.kinds) <= set(OF_GOALS)
