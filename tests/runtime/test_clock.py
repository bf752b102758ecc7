"""The clock of a run, and worlds whose clock does not do what a clock does."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest

from rapc.errors import PortError
from rapc.events import Event, RunEnded
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import read_task_request
from rapc.world import NOT_KNOWN, Message, Reply, Signal, Time
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld
from tests.runtime.helpers import ANY, compiled

WAIT = """
(define-rap (wait) (succeed (go)) (monitor-state (go)) (method (primitive (look a))))
"""
LOOK = "(define-rap (once) (method (primitive (look a))))"


class _Clock(ScriptedWorld):
    """A world whose clock and next time are what a test says."""

    def __init__(self, library: object) -> None:
        super().__init__(ANY, (), declared=library)  # type: ignore[arg-type]
        self.coming: Time | None = None
        self.takes: list[Time] = []
        self.shown: Time | None = None

    def next_time(self) -> Time | None:
        return self.coming

    def now(self) -> Time:
        return super().now() if self.shown is None else self.shown

    def perform(self, ticket: int, request: tuple[object, ...]) -> Reply:
        if self.takes:
            self.shown = self.takes.pop(0)
        return Reply("okay")


class _Stuck(_Clock):
    """A world whose clock stands still, however it is moved on."""

    def advance(self, to: Time) -> None:
        return None


class _Driver(_Clock):
    """A world whose clock goes by itself: one unit each time that it is polled."""

    def messages(self) -> Sequence[Message]:
        self.shown = self.now() + 1
        return ()


def _run(
    kind: type[_Clock],
    text: str,
    *tasks: str,
    patience: Time = 3600,
    idle_waits: int = 100,
    **told: object,
) -> tuple[Interpreter, _Clock, list[Event]]:
    library = compiled(text)
    world = kind(library.library)
    for name, value in told.items():
        setattr(world, name, value)
    settings = Settings(idle_cycles=50, idle_waits=idle_waits, patience=patience)
    run = Interpreter(library, world, settings=settings)
    events: list[Event] = []
    run.listen(events.append)
    for task in tasks:
        run.submit(read_task_request(task))
    return run, world, events


@pytest.mark.parametrize("coming", [math.nan, -math.inf])
def test_invalid_next_time_is_a_fault_of_the_world(coming: float) -> None:
    run, _, _ = _run(_Clock, WAIT, "(wait)", coming=coming)
    with pytest.raises(PortError, match=f"the next time of the world .* is `{coming}`"):
        run.run()


ENDLESS = """
(define-rap (endless) (resources (counter ?c)) (succeed nil)
  (method (task-net (t1 (rest) (counter-add ?c 1)))))
(define-rap (rest) (method (task-net)))
"""


def test_self_moving_clock_is_not_a_runaway() -> None:
    run, _, _ = _run(_Driver, ENDLESS, "(endless)")
    assert run.run(until=200) == "until"


class _Continuous(_Clock):
    """A world that cannot say when it will send `sends`, nor that it never will."""

    def __init__(self, library: object) -> None:
        super().__init__(library)
        #: What it sends, with its times; the clock stops at each.
        self.sends: list[tuple[Time, Signal]] = []
        #: How far the clock goes at a time, at most.
        self.stride: Time = math.inf
        self.ready: list[Signal] = []

    def next_time(self) -> Time | None:
        return super().now() if self.ready else NOT_KNOWN

    def advance(self, to: Time) -> None:
        to = min(to, super().now() + self.stride)
        if self.sends and self.sends[0][0] <= to:
            at, signal = self.sends.pop(0)
            self.ready.append(signal)
            to = at
        super().advance(to)

    def messages(self) -> Sequence[Message]:
        ready, self.ready = self.ready, []
        return ready


HEAR = """
(declare-event :done ())
(declare-event :hum ())
(define-rap (say) (method (primitive (look a))))
(define-rap (hear)
  (method (task-net (t1 (say) (wait-for (:done) :proceed)))))
(define-rap (late) (method (task-net (t1 (say) (window absolute 20 50)))))
"""
DONE, HUM = Signal((":done",)), Signal((":hum",))


def test_run_waits_for_a_world_without_next_time() -> None:
    run, world, _ = _run(_Continuous, HEAR, "(hear)", sends=[(7, HUM), (3000, DONE)])
    assert (run.run(), world.now()) == ("done", 3000)


def test_patience_begins_anew_with_each_message() -> None:
    sends = [(3000, HUM), (6000, HUM), (9000, DONE)]
    run, world, _ = _run(_Continuous, HEAR, "(hear)", sends=sends)
    assert (run.run(), world.now()) == ("done", 9000)


def test_after_patience_has_ended_nothing_is_coming() -> None:
    run, world, _ = _run(_Continuous, HEAR, "(hear)", sends=[(3601, DONE)])
    assert (run.run(), world.now()) == ("stuck", 3600)
    again, world, _ = _run(_Continuous, HEAR, "(hear)", patience=40)
    assert (again.run(), world.now()) == ("stuck", 40)
    assert _run(_Continuous, HEAR, "(hear)", patience=0)[0].run() == "stuck"


def test_known_time_comes_before_the_end_of_patience() -> None:
    run, world, _ = _run(_Continuous, HEAR, "(late)", patience=5, sends=[(9, HUM)])
    assert (run.run(), world.now()) == ("done", 20)
    run, world, _ = _run(_Continuous, HEAR, "(hear)")
    assert (run.run(until=60), world.now()) == ("until", 60)


class _Humming(_Clock):
    """A world that sends something at each unit of time."""

    def next_time(self) -> Time | None:
        return super().now() + 1

    def messages(self) -> Sequence[Message]:
        return [HUM]


TOO_LONG = "no cycle in 9 waits (`rapc.idle-waits`)"


def test_waits_in_a_row_are_bounded() -> None:
    """Each `step` gives control back, though the world never falls silent."""
    run, _, events = _run(_Humming, HEAR, "(hear)", idle_waits=9)
    assert run.step()
    assert not run.step()
    assert (run.reason, run.now) == ("stuck", 9)
    assert isinstance(events[-1], RunEnded)
    assert events[-1].because == TOO_LONG


def test_a_cycle_starts_the_count_of_waits_anew() -> None:
    tasks = "(hear)", "(say) :at 7", "(say) :at 15", "(say) :at 25"
    run, _, _ = _run(_Humming, HEAR, *tasks, idle_waits=9)
    assert (run.run(), run.now) == ("stuck", 24)


def test_waits_of_a_monitor_for_its_own_times_are_bounded() -> None:
    """One belief stays younger than the other, so the monitor is tested in vain."""
    text = """
    (define-rap (older)
      (monitor-state (and (believe (p a) ?n) (not (believe (q a b) ?n))))
      (method (primitive (look a))))
    """
    run, world, events = _run(_Clock, text, "(older)", idle_waits=9)
    run.assert_fact("p", "a")
    world.advance(5)
    run.sync_clock()
    run.assert_fact("q", "a", "b")
    assert (run.run(), run.now) == ("stuck", 50)
    assert isinstance(events[-1], RunEnded)
    assert events[-1].because == TOO_LONG


def test_world_stopping_without_message_is_reported() -> None:
    run, _, _ = _run(_Continuous, HEAR, "(hear)", stride=8)
    said = "stopped its clock at 8 on the way to 3600, and sent nothing; see `advance`"
    with pytest.raises(PortError, match=said):
        run.run()


@pytest.mark.parametrize(
    ("coming", "said"), [(0, "sent none"), (7, "did not move its clock to 7")]
)
def test_stopped_clock_is_a_fault_of_the_world(coming: Time, said: str) -> None:
    run, _, _ = _run(_Stuck, WAIT, "(wait)", coming=coming)
    with pytest.raises(PortError, match=said):
        run.run()


def test_clock_going_back_is_a_fault_of_the_world() -> None:
    run, _, _ = _run(_Clock, LOOK, "(once)", takes=[-1])
    with pytest.raises(PortError, match="clock back, from 0 to -1"):
        run.run()


def test_invalid_clock_time_is_a_fault_of_the_world() -> None:
    run, _, _ = _run(_Clock, LOOK, "(once)", takes=[math.nan])
    with pytest.raises(PortError, match="is `nan`"):
        run.run()


def test_whole_time_of_the_world_becomes_an_integer() -> None:
    run, _, events = _run(_Clock, LOOK, "(once)", takes=[136.0])
    assert run.run() == "done"
    assert repr(run.now) == "136"
    assert isinstance(events[-1], RunEnded)
    assert repr(events[-1].time) == "136"


def test_rows_with_a_whole_float_result_in_an_integer() -> None:
    library = compiled(LOOK)
    world = ScriptedWorld([Row(("look", "a"), takes=2.0)], (), declared=library.library)
    run = Interpreter(library, world)
    run.submit(read_task_request("(once)"))
    run.run()
    assert repr(run.now) == "2"
