"""The time of a run is accounted for: requests, skills with what was heard, waiting."""

from __future__ import annotations

from itertools import pairwise

import pytest

import rapc
from rapc.debug.account import times
from rapc.debug.history import History
from rapc.debug.questions.times import account, spells, timeline
from tests.debug.sessions import row, scripted, truck


def test_the_timeline_accounts_for_all_time() -> None:
    session = truck("(rock-order red 1)", "(rock-order blue 1)")
    session.go()
    whole = account(session)
    found = spells(whole)
    assert found[0].start == 0
    assert found[-1].stop == session.now
    assert all(one.stop == two.start for one, two in pairwise(found))
    used = times(whole.of_run, lambda one: one.family)
    assert sum(used.values()) == pytest.approx(session.now)
    assert set(used) >= {1, 2}
    part = spells(whole, 50, 100)
    assert part[0].start <= 50 < part[0].stop
    assert part[-1].start < 100


@pytest.fixture(scope="module")
def hallway() -> History:
    """Return a session with the robot of the hallway, 40 units on its errand."""
    library = rapc.load("stdlib/hallway")
    session = History.open(library, "hallway", agenda="errand")
    session.goto_time(40)
    return session


def test_skills_are_told_from_when_they_came_on_until_they_went_off(
    hallway: History,
) -> None:
    background, _, turn, move = spells(account(hallway))[:4]
    assert (background.start, background.stop) == (0, hallway.now)
    assert background.parts == [
        (":report-position",),
        (":detect-doorway",),
        (":watch-battery", 40),
    ]
    assert (turn.start, turn.stop) == (1, 1.2)
    assert turn.heard == [(":landmark-visible", "lab-door", 3.67, -0.93)]
    assert move.parts[0][:2] == (":move-to-landmark", "lab-door")
    assert [one[0] for one in move.heard][-2:] == [":at-landmark", ":movement-complete"]


def test_moment_counts_for_the_latest_start(hallway: History) -> None:
    pieces = account(hallway).of_run
    assert pieces[0].what == "arrival of go-to"
    assert pieces[0].stop == 1
    used = times(pieces, lambda one: one.kind)
    assert sum(used.values()) == pytest.approx(hallway.now)
    assert used == {"acting": pytest.approx(hallway.now - 1), "waiting": 1}
    part = times(pieces, lambda one: one.kind, 0.5, 2)
    assert part == {"acting": pytest.approx(1), "waiting": pytest.approx(0.5)}


def test_timeline_lists_the_result_of_each_request() -> None:
    text = """
    (declare-primitive walk (?place) (okay blocked) :atomic false)
    (define-rap (go ?place) (method (primitive (walk ?place))))
    """
    rows_ = (row("(walk hall)", "blocked", 2), row("(walk ?place)", takes=1))
    session = scripted(text, "(go hall)", "(go yard)", rows=rows_)
    session.go()
    found = {one["what"]: one["result or events"] for one in timeline(session).rows}
    assert found == {"(walk hall)": "blocked", "(walk yard)": "okay"}
