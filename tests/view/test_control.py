"""The control of a run by the readers of its page, without a browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import StringIO
from threading import Thread
from typing import Any

import pytest

import rapc
from rapc.debug.acts import AssertFact, ForceResult, SubmitTask
from rapc.debug.history import History
from rapc.durable.runs import DurableRun
from rapc.errors import PortError
from rapc.events import FactAsserted, TaskCreated
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest
from rapc.view.control import Control
from tests.debug.sessions import TRUCK, row
from tests.debug.test_answers import machine
from tests.debug.test_session import Breaking

TASKS = ("(rock-order red 1)",)


def truck(world: Any = "truck") -> tuple[Interpreter, StringIO]:
    """Return a run with its trace."""
    text = StringIO()
    more: dict[str, Any] = {"seed": 7, "listeners": [JsonTrace(text)]}
    return rapc.load(TRUCK).start(world, tasks=TASKS, **more), text


@contextmanager
def controlled(
    control: Control, run: Interpreter, durable: DurableRun | None = None
) -> Iterator[Callable[..., str]]:
    """Run in a thread; give a function that asks, and let the run go on at last."""
    broken: list[PortError] = []

    def go() -> None:
        try:
            control.go(run, durable)
        except PortError as error:
            broken.append(error)

    def ask(name: str, text: str = "") -> str:
        answer = control.ask(name, text)
        return f"{'refused: ' if answer.failed else ''}{'; '.join(answer.lines)}"

    thread = Thread(target=go, daemon=True)
    thread.start()
    yield ask
    control.ask("continue")
    thread.join(60)
    assert not thread.is_alive()
    if broken:
        raise broken[0]


def wait_for_pause(control: Control) -> None:
    """Wait until the run is paused or over; the run goes on between requests."""
    while control.status.state == "running":
        control.ask("assert", "invalid")


def untouched() -> str:
    run, text = truck()
    run.run()
    return text.getvalue()


@pytest.mark.parametrize("world", ["truck", machine])
def test_pauses_and_steps_leave_the_trace_unchanged(world: Any) -> None:
    run, text = truck(world() if callable(world) else world)
    control = Control(paused=True)
    with controlled(control, run) as ask:
        assert ask("pause") == "cycle 0, time 0"
        assert control.status.state == "paused"
        assert ask("step") == "cycle 1, time 0"
        assert ask("step") == control.status.moment == "cycle 2, time 0"
        assert ask("continue", "20") == "cycle 2, time 0"
        wait_for_pause(control)
        assert run.now >= 20
        assert ask("continue").startswith("cycle ")
    assert control.status.state == "ended"
    assert text.getvalue() == untouched()


@pytest.mark.parametrize("world", ["truck", machine])
def test_run_is_paused_in_its_middle(world: Any) -> None:
    run, text = truck(world() if callable(world) else world)
    for _ in range(30):
        run.step()
    with controlled(Control(paused=True), run) as ask:
        assert ask("step").startswith("cycle 31, ")
        assert ask("assert", "(x)") == "refused: unknown predicate `x`"
    assert text.getvalue() == untouched()


def test_acts_are_those_of_the_debugger() -> None:
    run, text = truck()
    control = Control(paused=True)
    with controlled(control, run) as ask:
        ask("continue", "20")
        wait_for_pause(control)
        said = ask("submit", "(rock-order red 1) :priority 2")
        assert said.endswith("(rock-order red 1) :priority 2")
        assert ask("assert", "(truck-status ready)") == "asserted (truck-status ready)"
        said = ask("force", "(arm-grasp ? ?) arm-dropped 2")
        assert said == "forced (arm-grasp ? ?) arm-dropped 2 times"
    other = StringIO()
    expected = History.open(
        rapc.load(TRUCK), "truck", tasks=TASKS, seed=7, listeners=[JsonTrace(other)]
    )
    expected.go(lambda: "" if expected.now >= 20 else None)
    expected.act(SubmitTask(TaskRequest(("rock-order", "red", 1), 2)))
    expected.act(AssertFact(("truck-status", "ready")))
    expected.act(ForceResult(("arm-grasp", "?", "?"), "arm-dropped", 2))
    expected.go()
    assert text.getvalue() == other.getvalue() != untouched()
    assert text.getvalue().count("arm-dropped") >= 2


def test_acts_are_events_of_the_user() -> None:
    run, _ = truck()
    heard: list[Any] = []
    run.listen(heard.append, FactAsserted, TaskCreated)
    with controlled(Control(paused=True), run) as ask:
        ask("assert", "(truck-status ready)")
        assert (heard[-1].fact, heard[-1].by) == (("truck-status", "ready"), "user")
        ask("submit", "(rock-order red 1)")
        assert heard[-1].parent is None


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("submit", "(nothing 3", "the list of `nothing` is not closed: (nothing 3"),
        ("submit", "(nothing 3)", "unknown RAP `nothing`; did you mean `do-nothing`?"),
        ("submit", "", "missing goal"),
        ("assert", "(x)", "unknown predicate `x`"),
        ("assert", "(truck-status ready) 3", "unexpected argument `3`"),
        ("force", "(arm-grasp ? ?) no", "`no` is not a result of `arm-grasp`"),
        ("step", "4", "unexpected argument `4`"),
        ("continue", "-4", "time -4 is in the past"),
        ("continue", "nan", "time must be a number, not `nan`"),
        ("continue", "soon", "time must be a number, not `soon`"),
        ("reload", "", "unknown request `reload`"),
        ("export", "run.jsonl", "unknown request `export`"),
    ],
)
def test_invalid_requests_change_nothing(name: str, text: str, said: str) -> None:
    run, trace = truck()
    control = Control(paused=True)
    with controlled(control, run) as ask:
        ask("continue", "20")
        wait_for_pause(control)
        assert ask(name, text) == f"refused: {said}"
        assert control.status.state == "paused"
    assert trace.getvalue() == untouched()


def test_requests_after_the_end_are_refused() -> None:
    run, _ = truck()
    control = Control()
    control.go(run)
    for name in ("pause", "step", "submit"):
        assert control.ask(name, "(rock-order red 1)").lines == ("the run has ended",)


def test_error_of_the_world_ends_the_run_with_the_error() -> None:
    text = """
    (declare-primitive act (?x) (okay))
    (define-rap (top) (method (task-net
      (t1 (use a) (for t2)) (t2 (use b) (for t3)) (t3 (use c)))))
    (define-rap (use ?x) (method (primitive (act ?x))))
    """
    library = rapc.loads(text, "small.rap")

    def drive(control: Control, run: Interpreter, move: str) -> None:
        with controlled(control, run) as ask:
            while not control.ask(move).failed:
                pass
            assert ask(move) == "refused: the run has ended"

    for move in ("continue", "step"):
        world = Breaking([row("(act ?)")], declared=library.program.library)
        control = Control(paused=True)
        with pytest.raises(PortError, match="the arm is off"):
            drive(control, library.start(world, tasks=["(top)"]), move)
        assert control.status.state == "ended"
