"""Drivers of machines that go on when the process of the driver dies."""

from __future__ import annotations

import importlib
import random
import sys
from collections.abc import Callable, Iterator
from itertools import count
from pathlib import Path
from typing import Any

import pytest

import rapc
from bench.kills import SCANS, conveyor, data_in, killed_live
from rapc.durable.folder import Options
from rapc.live import SimulatedClock
from rapc.spec import RunSpec
from rapc.world import Datum, Finished, Lost, Reply
from tests.durable.helpers import Killed, Run, kill_after

EXAMPLE = Path(__file__).parents[2] / "examples" / "conveyor"
PARCELS = ("p1", "p2", "p3", "p4")
TASKS = (
    *(f"(dispatch {one})" for one in PARCELS[:3]),
    *(f"(dispatch {one}) :at 0.3" for one in PARCELS[3:]),
    *(f"(see {one})" for one in PARCELS),
)
SCANNED = [f"(scanned {one})" for one in PARCELS]
pytestmark = pytest.mark.usefixtures("killable")


class Example:
    """The controller of the conveyor, and its drivers in simulated time."""

    def __init__(self, controller: Any, driver: Any) -> None:
        steps = count()
        self.controller = controller(lambda: next(steps) * 0.01)
        self.drivers: list[Any] = []
        controller_calls = self._call

        class Local(driver):  # type: ignore[misc]
            """A driver whose controller is in this process."""

            def open(self) -> None:
                """Open no connection."""

            def call(self, name: str, *arguments: Any) -> Any:
                """Call a method of the controller."""
                return controller_calls(name, *arguments)

        self._class = Local

    def _call(self, name: str, *arguments: Any) -> Any:
        return getattr(self.controller, name)(*arguments)

    def driver(self) -> Any:
        """Return a new driver."""
        self.drivers.append(self._class(clock=SimulatedClock()))
        return self.drivers[-1]

    def once(self) -> bool:
        """Return whether each request was done once."""
        wanted = dict.fromkeys(PARCELS, 1)
        return all(one == wanted for one in self.controller.counts())


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], Example]]:
    """Return a function that makes a controller, which has no driver."""
    monkeypatch.syspath_prepend(EXAMPLE)
    controller = importlib.import_module("controller").Controller
    driver = importlib.import_module("conveyor").Conveyor
    made: list[Example] = []

    def make() -> Example:
        made.append(Example(controller, driver))
        return made[-1]

    yield make
    for one in made:
        for each in one.drivers:
            each.close()
    del sys.modules["controller"], sys.modules["conveyor"]


def _run(folder: Path, example: Example) -> Run:
    library = rapc.load(EXAMPLE / "conveyor.rap").extend(SCANS).program
    folder.mkdir(exist_ok=True)
    return Run(folder, library, RunSpec(tasks=TASKS), example.driver)


def _kill(run: Run, writes: int) -> None:
    """Begin or resume a run, and kill it after some records."""
    with pytest.MonkeyPatch.context() as patch:
        kill_after(writes, patch)
        with pytest.raises(Killed):
            (run.resume() if (run.journal / "meta").exists() else run.begin()).go()


def _go(run: Run) -> None:
    durable = run.resume()
    assert durable.go() == "done"
    durable.close()


@pytest.mark.parametrize("sync", ["requests", "always"])
def test_requests_and_data_are_exact_whatever_the_last_record(
    tmp_path: Path, example: Callable[[], Example], sync: str
) -> None:
    for writes in range(3, 45):
        one = example()
        run = _run(tmp_path / str(writes), one)
        run.options = Options(sync=sync)
        _kill(run, writes)
        _go(run)
        assert one.once(), writes
        assert sorted(data_in(run.trace)) == SCANNED, writes


@pytest.mark.parametrize("sync", ["requests", "always"])
@pytest.mark.parametrize("seed", range(10))
def test_requests_and_data_are_exact_in_a_run_killed_often(
    tmp_path: Path, example: Callable[[], Example], sync: str, seed: int
) -> None:
    one, chance = example(), random.Random(seed)
    run = _run(tmp_path, one)
    run.options = Options(sync=sync)
    for writes in (15, *(chance.randint(3, 8) for _ in range(5))):
        _kill(run, writes)
    _go(run)
    assert one.once()
    assert sorted(data_in(run.trace)) == SCANNED
    assert len(one.drivers) == 7
    _go(run)  # a run that has ended: the driver does not connect
    assert one.once()


def test_cancelled_job_is_forgotten(example: Callable[[], Example]) -> None:
    one = example()
    driver = one.driver()
    assert driver.perform(1, ("carry", "p1")) is None
    driver.cancel(1)
    driver.perform(1, ("carry", "p1"))
    assert one.controller.begun == {"p1": 2}


def test_driver_that_lives_sends_messages_again(example: Callable[[], Example]) -> None:
    one = example()
    driver = one.driver()
    assert driver.perform(1, ("label", "p1")) == Reply("okay")
    driver.perform(2, ("carry", "p1"))
    told = []
    for time in (9, 10):
        driver.advance(time)  # up to the first message
        told += driver.messages()
    assert told == [Finished(2, Reply("okay")), Datum(("scanned", "p1"), number=1)]
    driver.perform(3, ("carry", "p2"))
    driver.perform(4, ("label", "p3"))
    driver.perform(5, ("carry", "p4"))
    # the interpreter has died, and knows the first message
    assert driver.resume([3, 4, 6], 1) == {3: None}
    assert driver.messages() == told[1:]
    driver.advance(20)
    assert driver.messages() == [Finished(3, Reply("okay"))]
    assert one.controller.arrived == {"p1": 1, "p2": 1}


def test_driver_that_lives_knows_its_last_answer(
    example: Callable[[], Example],
) -> None:
    driver = example().driver()
    driver.perform(1, ("label", "p1"))
    assert driver.resume([1], 0) == {1: Reply("okay")}


def test_halted_request_is_lost_after_resume(example: Callable[[], Example]) -> None:
    driver = example().driver()
    driver.perform(1, ("carry", "p1"))
    driver.halt()
    assert driver.resume([1], 0) == {1: None}
    assert [type(one) for one in driver.messages()] == [Lost]


def test_machine_is_told_of_messages_in_the_journal(
    example: Callable[[], Example],
) -> None:
    one = example()
    driver = one.driver()
    driver.perform(1, ("carry", "p1"))
    driver.advance(9)
    driver.messages()
    assert one.controller.arrives(1)
    driver.acknowledge(1)
    with pytest.raises(KeyError):
        one.controller.arrives(1)
    with pytest.raises(ValueError, match="the first 1 messages are forgotten"):
        driver.resume([], 0)


def test_messages_without_a_journal_are_forgotten(
    example: Callable[[], Example], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rapc.live.resumable._MOST_KEPT", 3)
    driver = example().driver()
    driver.perform(1, ("label", "p1"))
    for n in range(5):
        driver.send(Datum(("seen", n)))
    driver.messages()
    with pytest.raises(ValueError, match="the first 2 messages are forgotten"):
        driver.resume([], 1)


@pytest.mark.slow
def test_requests_and_data_are_exact_in_killed_processes(tmp_path: Path) -> None:
    assert killed_live(conveyor(), 10, random.Random(1), tmp_path) == 10
