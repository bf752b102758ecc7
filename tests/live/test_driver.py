"""Drivers in simulated time: actions, cancels, timeouts, failures, jobs."""

from __future__ import annotations

import threading
from io import StringIO
from types import MappingProxyType
from typing import Any

import pytest

import rapc
from rapc.live import Action, AsyncAction, Driver, SimulatedClock
from rapc.world import Atom, Fact, Kit, Offer
from tests.live.rover import LIBRARY, Polled, Rover, SimulatedRover


def _run(world: Rover, *tasks: str, **more: Any) -> tuple[rapc.RunResult, str]:
    text = StringIO()
    library = rapc.loads(LIBRARY)
    listeners = [rapc.TextTrace(text)]
    try:
        result = rapc.run(library, world, tasks, listeners=listeners, **more)
    finally:
        world.close()
    return result, text.getvalue()


def test_actions_in_threads_take_their_time() -> None:
    rover = SimulatedRover()
    result, _ = _run(rover, "(visit hall kitchen)")
    assert result.succeeded
    assert result.time == 3
    assert rover.log == [
        (0, "drive", "hall"),
        (1.5, "stop", "hall"),
        (1.5, "drive", "kitchen"),
        (3, "stop", "kitchen"),
    ]


def test_threads_and_coroutines_run_at_the_same_time() -> None:
    rover = SimulatedRover()
    result, _ = _run(rover, "(visit hall kitchen)", "(see hall)", "(see attic)")
    assert result.succeeded
    assert result.time == 3
    ends = [one for one in rover.log if one[1] == "looked"]
    assert ends == [(2, "looked", "hall"), (2, "looked", "attic")]


def test_runs_in_simulated_time_have_the_same_trace() -> None:
    tasks = "(visit hall kitchen)", "(see hall)", "(go-to attic)", "(glance yard)"
    texts = {_run(Polled(), *tasks, until=9)[1] for _ in range(20)}
    assert len(texts) == 1


@pytest.mark.parametrize("goal", ["(go-to hall)", "(see hall)"])
def test_cancelled_action_cleans_up_before_the_cancel_returns(goal: str) -> None:
    rover = SimulatedRover()
    run = rapc.loads(LIBRARY).start(rover, tasks=[goal])
    run.call_at(1, lambda: run.end("cancelled"))
    while run.step():
        pass
    assert [one[0] for one in rover.log] == [0, 1]
    assert rover.log[1][1] in ("stop", "looked")
    rover.close()


class Called(SimulatedRover):
    """A rover whose machine calls back, from a thread of its own."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.waiting: dict[Atom, Action] = {}

    def connect(self) -> None:
        self.start(self.machine)

    def machine(self, action: Action) -> None:
        """Come to each room after 1 s, and say so twice."""
        while True:
            action.sleep(1)
            for room in list(self.waiting):
                waiting = self.waiting.pop(room)
                waiting.finish("blocked" if room == "cellar" else None)
                waiting.finish("timeout")

    def do_drive(self, action: Action, room: Atom) -> Any:
        self.waiting[room] = action
        try:
            return action.wait()
        finally:
            self.note("end", room)

    async def do_look(self, action: AsyncAction, room: Atom) -> Any:
        self.waiting[room] = action
        try:
            return await action.wait()
        finally:
            self.note("end", room)


def test_callback_ends_an_action() -> None:
    texts = set()
    for _ in range(20):
        rover = Called()
        result, text = _run(rover, "(visit hall kitchen)", "(see attic)", until=9)
        assert result.succeeded
        assert [one[1:] for one in rover.log] == [
            ("end", "hall"),
            ("end", "attic"),
            ("end", "kitchen"),
        ]
        texts.add(text)
    assert len(texts) == 1
    assert "(drive cellar) - blocked" in _run(Called(), "(go-to cellar)", until=4)[1]


@pytest.mark.parametrize("goal", ["(go-to hall)", "(see hall)"])
def test_action_that_waits_can_be_cancelled(goal: str) -> None:
    rover = Called()
    run = rapc.loads(LIBRARY).start(rover, tasks=[goal])
    run.call_at(0.5, lambda: run.end("cancelled"))
    while run.step():
        pass
    assert rover.log == [(0.5, "end", "hall")]
    rover.close()


def test_callback_that_comes_before_the_wait_ends_it() -> None:
    class Fast(SimulatedRover):
        def do_drive(self, action: Action, room: Atom) -> Any:
            action.finish("okay")
            return action.wait()

        async def do_look(self, action: AsyncAction, room: Atom) -> Any:
            action.finish()
            return await action.wait()

    result, _ = _run(Fast(), "(go-to hall)", "(see hall)")
    assert (result.succeeded, result.time) == (True, 0)


def test_callback_in_a_thread_of_the_machine_ends_an_action_in_real_time() -> None:
    class Real(Rover):
        def do_drive(self, action: Action, room: Atom) -> Any:
            threading.Thread(target=action.finish).start()
            return action.wait()

        async def do_look(self, action: AsyncAction, room: Atom) -> Any:
            self.looking = action
            threading.Thread(target=action.finish).start()
            return await action.wait()

    rover = Real()
    assert _run(rover, "(go-to hall)", "(see hall)")[0].succeeded
    rover.looking.finish()  # of an ended action, whose loop is closed


def test_timeout_ends_the_request_and_cancels_the_action() -> None:
    rover = SimulatedRover()
    rover.seconds["hall"] = 60
    _, text = _run(rover, "(go-to hall)", until=11)
    assert "timeout" in text
    assert rover.log[:3] == [
        (0, "drive", "hall"),
        (10, "stop", "hall"),
        (10, "drive", "hall"),
    ]


def test_lost_connection_fails_the_method_and_the_run_goes_on() -> None:
    rover = SimulatedRover()
    rover.errors["hall"] = [ConnectionResetError("no route to the body")]
    result, text = _run(rover, "(go-to hall)")
    assert result.succeeded
    assert "ConnectionResetError: no route to the body" in text


def test_fault_of_an_action_ends_the_run() -> None:
    rover = SimulatedRover()
    rover.errors["hall"] = [KeyError("wheels")]
    with pytest.raises(rapc.PortError, match=r"rover\.py:\d+.*KeyError"):
        _run(rover, "(go-to hall)")


def test_jobs_send_data() -> None:
    rover = Polled()
    result, _ = _run(rover, "(go-to hall)")
    assert result.run.memory.value("battery") == 98


def test_atomic_primitive_is_done_at_once() -> None:
    rover = SimulatedRover()
    assert rover.perform(1, ("beep", 3)) == rapc.world.Reply("okay")
    assert rover.log == [(0, "beep", 3)]


def test_action_that_never_sleeps_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rapc.live.clocks._LONGEST", 0.0)
    clock = SimulatedClock()
    clock.begun()
    with pytest.raises(RuntimeError, match=r"without `action\.sleep`"):
        clock.settle()


class Incomplete(Driver):
    """A driver without its methods."""

    name = "incomplete"
    kit = Kit(Offer({"turn-left": (0, ("okay",))}))


class Slow(Incomplete):
    """A driver whose atomic primitive is a coroutine."""

    async def do_turn_left(self) -> None:
        """Turn."""


class Late(Incomplete):
    """A driver with a timeout that the offer does not list."""

    timeouts = MappingProxyType({"turn-left": 3})

    def do_turn_left(self) -> None:
        """Turn."""


@pytest.mark.parametrize(
    ("world", "said"),
    [
        (Incomplete, "requires `do_turn_left`"),
        (Slow, "is a coroutine, but `turn-left` is atomic"),
        (Late, "has a timeout, but no result `timeout`"),
    ],
)
def test_incomplete_driver_is_refused(world: type[Driver], said: str) -> None:
    with pytest.raises(TypeError, match=said):
        world()


def test_halt_stops_the_body_and_reports_lost_requests() -> None:
    rover = SimulatedRover()
    request: Fact = ("drive", "hall")
    assert rover.perform(7, request) is None
    rover.halt()
    assert [type(one).__name__ for one in rover.messages()] == ["Lost"]
    rover.close()
    assert rover.log[0] == (0, "drive", "hall")
    assert sorted(rover.log[1:]) == [(0, "halt"), (0, "stop", "hall")]


class Unplugged(SimulatedRover):
    """A rover whose job loses the connection."""

    def connect(self) -> None:
        self.start(self.read)

    def read(self, action: Action) -> None:
        action.sleep(1)
        raise ConnectionResetError("the cable is out")


def test_fault_of_a_job_ends_the_run() -> None:
    with pytest.raises(rapc.PortError, match="the cable is out"):
        _run(Unplugged(), "(go-to hall)")
