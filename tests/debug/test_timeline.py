"""The time of a run is accounted for: requests, skills with what was heard, waiting."""

from __future__ import annotations

from itertools import pairwise

import pytest

import rapc
from rapc.debug.history import History
from rapc.debug.questions.times import Spell, spells, time_by_family
from tests.debug.sessions import truck


def test_the_timeline_accounts_for_all_time() -> None:
    session = truck("(rock-order red 1)", "(rock-order blue 1)")
    session.go()
    found = spells(session)
    assert found[0].start == 0
    assert found[-1].stop == session.now
    assert all(one.stop == two.start for one, two in pairwise(found))
    used = time_by_family(found)
    assert sum(used.values()) == pytest.approx(session.now)
    assert set(used) >= {1, 2}
    part = spells(session, 50, 100)
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
    background, turn, move = spells(hallway)[:3]
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
    used = time_by_family(spells(hallway))
    assert sum(used.values()) == pytest.approx(hallway.now)
    assert used[1] == pytest.approx(1)
    part = time_by_family(spells(hallway, 0.5, 2), 0.5, 2)
    assert part == {6: pytest.approx(1), 1: pytest.approx(0.5)}


def test_time_by_family_takes_the_youngest_of_overlapping_spells() -> None:
    found = [
        Spell(0, 10, 1, 1, [(":watch",)]),
        Spell(2, 4, 2, 2, [("go",)]),
        Spell(3, 8, 3, 3, [(":turn",)]),
        Spell(10, 12, None, None, []),
    ]
    assert time_by_family(found) == {3: 5, 1: 4, None: 2, 2: 1}
