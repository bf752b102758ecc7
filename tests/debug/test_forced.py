"""Results are forced as often as was said, and taken back with the run."""

from __future__ import annotations

import pytest

from rapc import events
from rapc.debug.acts import ForcedWorld, ForceResult
from rapc.debug.history import History
from rapc.errors import ArgumentError
from tests.debug.sessions import truck
from tests.repl.shells import said, truck_shell

GRASP = ForceResult(("arm-grasp", "?arm", "?thing"), "arm-dropped", 2)


def _grasps(session: History) -> list[str]:
    told = session.scan(events.PrimitiveEnded)
    return [o.keys["result"] for o in told if o.keys["request"][0] == "arm-grasp"]


def test_the_next_requests_end_as_is_said() -> None:
    session = truck()
    session.go()
    before = _grasps(session)
    session.goto(20)
    session.act(GRASP)
    session.go()
    after = _grasps(session)
    assert after[:2] == ["arm-dropped", "arm-dropped"]
    assert before[0] == "okay"
    assert session.run.results()[0].outcome == "succeeded"


def test_forced_result_is_undone_and_replayed() -> None:
    session = truck()
    session.goto(20)
    session.act(GRASP)
    states = {}
    while session.step().kind == "asked":
        states[session.cycle] = session.run.save()
    results = _grasps(session)
    for cycle in (21, 60, 90, max(states)):
        session.goto(5)
        assert not isinstance(session.run.port.behind, ForcedWorld)
        session.goto(cycle)
        assert session.run.save() == states[cycle]
        session.goto(cycle - 1)
        session.step()
        assert session.run.save() == states[cycle]
    session.go()
    assert _grasps(session) == results


def test_undeclared_result_is_not_forced() -> None:
    session = truck()
    for act, why in (
        (ForceResult(("arm-grsp", "?", "?"), "okay"), "did you mean `arm-grasp`"),
        (ForceResult(("arm-grasp", "?", "?"), "exploded"), "`exploded`"),
        (ForceResult(("arm-grasp", "?"), "okay"), "2"),
    ):
        with pytest.raises(ArgumentError, match=why):
            session.act(act)
    assert session.branch.acts == []


def test_a_result_is_forced_by_a_command() -> None:
    shell = truck_shell()
    assert said(shell, ":force (truck-move) okay 3") == (
        "forced (truck-move) okay 3 times\n"
    )
    assert "missing result" in said(shell, ":force (truck-move)")
