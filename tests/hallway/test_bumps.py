"""Somebody pushes the robot against walls: it backs away, and goes on where it was."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from rapc import events
from rapc.base.values import Atom, Text
from tests.claims import Claims, claimants_of, users_of
from tests.hallway.sent import begin, library

QUIET: dict[str, Atom | bool] = {
    "doors": 0,
    "people": 0,
    "lift": 0,
    "start": Text("workbench"),
}

LEG = range(19, 79, 6)
"""When somebody pushes, ten times on one leg of the journey."""

TICK = 0.1


def _pushed(times: Iterable[int]) -> tuple[list[events.Event], str]:
    """Push the robot to the west at some times of a journey through the east hall.

    Returns all events, and what became of the journey.
    """
    heard: list[events.Event] = []
    task = "(go-to mail-slots) :at 1"
    run, world = begin(4, task, options=QUIET, listeners=[heard.append])
    for time in times:
        run.call_at(time, lambda: world.simulation.push(-0.6, 0, 3))
    run.run(until=2000)
    assert world.figures().fastest <= 0.1
    (sent,) = [task for task in run.results() if not task.background]
    return heard, sent.outcome


def _kinds(heard: list[events.Event], name: str) -> list[events.SignalReceived]:
    return [
        e for e in heard if isinstance(e, events.SignalReceived) and e.what[0] == name
    ]


def test_a_bump_is_acted_on_within_one_tick_with_the_skills_before_off_first() -> None:
    """S 4.3: a bump means the same at any time; a higher task takes the wheels."""
    heard, outcome = _pushed([24])
    assert outcome == "succeeded"
    (bump,) = _kinds(heard, ":bump")
    after = heard[heard.index(bump) :]
    enabled = [e for e in after if isinstance(e, events.SkillEnabled)]
    on = next(e for e in enabled if e.what[0] == ":back-off")
    assert on.time - bump.time <= TICK
    between = after[: after.index(on)]
    off = [str(e.what[0]) for e in between if isinstance(e, events.SkillDisabled)]
    assert off
    taken = next(e for e in between if isinstance(e, events.MethodSuspended))
    assert taken.for_ == "wheels"
    again = after[after.index(on) + 1 :]
    gone = next(e for e in again if isinstance(e, events.SkillDisabled))
    back = next(e for e in again if isinstance(e, events.SkillEnabled))
    assert gone.what[0] == ":back-off"
    assert again.index(gone) < again.index(back)
    assert str(back.what[0]) in off


@pytest.mark.slow
def test_ten_bumps_on_one_journey_are_ten_times_backing_away() -> None:
    heard, outcome = _pushed(LEG)
    assert outcome == "succeeded"
    bumps = _kinds(heard, ":bump")
    done = [
        e
        for e in heard
        if isinstance(e, events.TaskSucceeded) and e.goal.name == "back-away"
    ]
    assert len(bumps) == len(done) == 10
    reasons = {e.reason for e in heard if isinstance(e, events.TaskFailed)}
    assert "futile-loop" not in reasons


@pytest.mark.slow
def test_whoever_backs_away_never_drives_beside_the_journey() -> None:
    heard, _ = _pushed(LEG)
    declared = library().program.library
    claims = Claims(claimants_of(declared, "wheels"), users_of(declared, "wheels"))
    for event in heard:
        claims(event)
    assert (claims.moved, claims.crossed, claims.suspended) == (0, 0, set())
    assert claims.times_suspended >= 8
