"""The end of a run names the lines behind planted faults, and none without a fault."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from rapc.debug.history import History
from rapc.debug.questions.state import source
from rapc.debug.questions.times import waits
from rapc.debug.questions.why import why
from rapc.debug.questions.why_not import why_not
from rapc.errors import ArgumentError
from tests.cli.command import rapc
from tests.debug.planted import FAULTS, LIBRARIES, WORLDS
from tests.debug.sessions import row, scripted

_FAULTS = {fault.name: fault for fault in FAULTS}


def _answers(name: str, library: Path, *inputs: str, until: float = 5000) -> Any:
    """Return the last answer about a fault with a faulty or sound library."""
    fault = _FAULTS[name]
    world = WORLDS.get(fault.library, fault.library)
    options = [f"--set={fault.library}.{k}={v}" for k, v in fault.options.items()]
    options += [f"--world={world}", f"--agenda={fault.agenda}", f"--seed={fault.seed}"]
    typed = [part for one in inputs for part in ("-c", one)]
    given = (*options, f"--until={until}", "--json", *typed)
    told = rapc("repl", ".", *given, cwd=library)
    return json.loads(told.stdout.splitlines()[-1])


def _symptoms(name: str, library: Path) -> list[str]:
    """Return the symptoms at the end of a run, without the reason of the end."""
    lines = _answers(name, library, ":show none", ":run", ":why end")["lines"]
    return [one for one in lines[1:] if not one.endswith("see `:goals`")]


def _of(session: History) -> list[str]:
    session.go()
    return list(why(session, "end").lines[1:])


@pytest.fixture(autouse=True)
def _path_of_worlds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(LIBRARIES["laboratory"])
    monkeypatch.setenv("PYTHONPATH", os.fspath(LIBRARIES["laboratory"]))


@pytest.mark.parametrize(
    ("name", "place", "said"),
    [
        (
            "late-to-the-charger",
            "battery.rap:19",
            "by rule for (:battery-low 4) of (:watch-battery 4) at ",
        ),
        ("fuel-too-late", "fuel.rap:38", "was never woken, with (< ?level 0)"),
        ("way-home-forgotten", "charging.rap:8", "woken by (low) at 117: (battery 44)"),
        (
            "acknowledged-too-early",
            "alarms.rap:26",
            "woken by (stop pressed) at ",
        ),
        ("rocks-not-counted", "orders.rap:60", "`?wanted` of `fill-order` did not "),
        ("nurse-of-another-ward", "orders.rap:85", "(:nurse ward-4) came meanwhile"),
        ("drives-off-while-loading", "orders.rap:37", "`fetch` does not claim wheels"),
        (
            "closed-door-taken-as-passed",
            "moving.rap:333",
            "3 wrong beliefs by rule ",
        ),
        ("heading-not-turned", "moving.rap:25", "derived from (base lab-door 4.951 "),
        ("too-few-rounds", "samples.rap:23", "rounds: heat okay 3 times, measure "),
        ("strong-arm-too-seldom", "grasping.rap:86", "`strong` of `pickup` was never "),
        ("sold-out-for-ever", "orders.rap:39", "(sold-out kitchen meals), 800 old"),
    ],
)
def test_first_symptom_names_the_planted_line(
    name: str, place: str, said: str, tmp_path: Path
) -> None:
    _FAULTS[name].plant(tmp_path)
    first = _symptoms(name, tmp_path)[0]
    assert first.startswith(f"{place}: ")
    assert said in first


@pytest.mark.parametrize(
    "name", ["nurse-of-another-ward", "closed-door-taken-as-passed", "too-few-rounds"]
)
def test_sound_run_has_no_symptoms(name: str) -> None:
    assert _symptoms(name, LIBRARIES[_FAULTS[name].library]) == []


def test_wrong_belief_lists_the_facts_behind_its_rule(tmp_path: Path) -> None:
    _FAULTS["heading-not-turned"].plant(tmp_path)
    inputs = (":show none", ":run", ":belief")
    found = _answers("heading-not-turned", tmp_path, *inputs, until=40)
    wrong, *behind = found["rows"]
    assert wrong["believed"] == "(current-space robot west-hall)"
    facts = {str(one["believed"]): str(one["by"]) for one in behind}
    [(base, by)] = [(k, v) for k, v in facts.items() if "(base lab-door" in k]
    assert base.startswith("  because of (base lab-door 4.951 14.03")
    assert by.endswith("travel.rap:95")


def test_counter_with_a_step_that_no_round_reached_is_named() -> None:
    text = """
    (declare-primitive rest () (okay))
    (declare-primitive try () (okay no-luck))
    (define-rap (work)
      (resources (counter ?done))
      (succeed (> (value ?done) 0))
      (repeat-while true)
      (method (context (not (last-result no-luck)))
        (task-net (t1 (rest-a-while))))
      (method again (context otherwise)
        (task-net (t1 (rest-a-while)))))
    (define-rap (rest-a-while) (method (primitive (rest))))
    """
    session = scripted(text, "(work)", rows=(row("(rest)"),))
    first = _of(session)[0]
    assert first.startswith("small.rap:5: `?done` of `work` did not change in ")
    assert first.endswith("no step changes it")


def test_fact_that_an_unseen_result_asserts_is_not_named() -> None:
    text = """
    (declare-memory-proposition broken ())
    (declare-primitive press () (okay stuck burnt) :on (burnt (broken)))
    (define-rap (work)
      (repeat-while true)
      (method press (primitive (press)))
      (method mend (context (broken)) (primitive (press))))
    """
    session = scripted(text, "(work)", rows=(row("(press)", "stuck"),))
    assert not [line for line in _of(session) if "never chosen" in line]
    session = scripted(
        text.replace("(burnt (broken))", "(stuck (may (broken)))"),
        "(work)",
        rows=(row("(press)", "stuck"),),
    )
    [line] = [line for line in _of(session) if "never chosen" in line]
    assert line.startswith("small.rap:7: `mend` of `work` was never chosen in ")
    assert "no (broken) was ever asserted, though `press` had stuck" in line


def test_waits_of_an_unknown_task_are_refused() -> None:
    session = scripted("(define-rap (work) (succeed true))", "(work)")
    session.go()
    with pytest.raises(ArgumentError, match=r"unknown task \[999\]"):
        waits(session, "999")


def test_source_of_a_line_between_definitions_is_the_nearest() -> None:
    text = "(define-rap (one) (succeed true))\n\n\n(define-rap (two) (succeed true))"
    session = scripted(text, "(one)")
    assert source(session, "small.rap:2").lines[1].endswith("(succeed true))")
    assert "(one)" in source(session, "small.rap:2").lines[1]
    assert "(two)" in source(session, "small.rap:3").lines[1]


def test_why_failed_of_a_rap_is_its_last_failure() -> None:
    text = """
    (declare-primitive press (?key) (okay stuck))
    (define-rap (hit ?key)
      (method (primitive (press ?key))))
    """
    rows = (row("(press left)", "stuck"), row("(press right)"))
    session = scripted(text, "(hit left)", "(hit right)", rows=rows)
    session.go()
    assert why(session, "failed hit").lines[0].startswith("[1] (hit left) failed ")


def test_why_not_of_a_removed_task_evaluates_its_monitor() -> None:
    text = """
    (declare-memory-proposition level (?n))
    (define-rap (both) (method (task-net (t1 (guard)) (t2 (end) (until-end t1)))))
    (define-rap (guard) (monitor-state (and (level ?n) (< ?n 0))) (succeed nil))
    (define-rap (end) (succeed true))
    (define-rap (work) (method (task-net (t1 (guard) (until-end t2)) (t2 (end)))))
    """
    session = scripted(text, "(work)")
    session.go()
    lines = why_not(session, "2").lines
    assert any("monitor-state of `guard`" in line for line in lines)
