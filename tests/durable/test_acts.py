"""Acts of a host on a run with a journal."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import rapc
from rapc.debug.acts import ForceResult
from rapc.durable import journal
from rapc.durable.folder import numbers, read
from rapc.durable.records import Acted
from rapc.durable.runs import DurableRun
from rapc.errors import ArgumentError, Error, RefusedError, StateError
from rapc.events import TaskSelected
from rapc.spec import RunSpec
from rapc.world import Fact, Finished, Kit, Offer, Reply, SimpleWorld
from tests.durable.helpers import Killed, Run, kill_after

pytestmark = pytest.mark.usefixtures("killable")

LIBRARY = """
(declare-memory-proposition wanted (?n))
(declare-memory-proposition made (?n))
(declare-event :bell (?n))
(declare-primitive make (?n) (okay) :atomic false :on (okay (made ?n)))
(define-rap (keep-up)
  (succeed nil)
  (monitor-state (and (wanted ?n) (not (made ?n))))
  (method
    (context (and (wanted ?n) (not (made ?n))))
    (primitive (make ?n))))
(define-rap (answer ?n)
  (method
    (task-net
      (t1 (produce ?n) (wait-for (:bell ?n))))))
(define-rap (produce ?n)
  (succeed (made ?n))
  (method (primitive (make ?n))))
"""


class Workshop(SimpleWorld):
    """A world that makes things, with a bell."""

    name = "workshop"
    kit = Kit(
        Offer({"make": (1, ("okay",))}, events={":bell": 1}, not_atomic=("make",))
    )

    def perform(self, ticket: int, request: Fact) -> None:
        """Make a thing in 2 time units."""
        self.send(Finished(ticket, Reply("okay")), after=2)


ACTS: tuple[tuple[int, Callable[[DurableRun], None]], ...] = (
    (0, lambda run: run.assert_fact("wanted", 1)),
    (2, lambda run: run.submit("(answer 7) :priority 2")),
    (2, lambda run: run.assert_fact("wanted", 2)),
    (5, lambda run: run.signal(":bell", 7)),
    (6, lambda run: run.erase("made", 1)),
    (10, lambda run: run.cancel(("keep-up",))),
)
"""Acts, each after a cycle."""


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Return a run of one task, with a snapshot every 4 cycles."""
    monkeypatch.setattr(journal, "CYCLES", 4)
    monkeypatch.setattr(journal, "PAUSE", 0)
    return _run(tmp_path)


def _run(folder: Path) -> Run:
    library = rapc.loads(LIBRARY).program
    spec = RunSpec(tasks=("(keep-up)",))
    return Run(folder, library, spec, Workshop)


def _go(durable: DurableRun, done: int) -> None:
    """Perform the acts after the first `done` ones, and run to the end."""
    for cycle, act in ACTS[done:]:
        durable.reach(cycle)
        act(durable)
    assert durable.go() == "done"
    durable.close()


def test_acts_are_repeated_whatever_the_last_record(run: Run) -> None:
    _go(run.begin(), 0)
    whole = run.trace.read_text()
    assert "(made 7)" in whole
    killed = 0
    for writes in range(3, 30):
        folder = run.journal.parent / str(writes)
        folder.mkdir()
        again = _run(folder)
        with pytest.MonkeyPatch.context() as patch:
            kill_after(writes, patch)
            try:
                _go(again.begin(), 0)
            except Killed:
                killed += 1
        records = read(again.journal, whole=True).records
        _go(again.resume(), sum(isinstance(one, Acted) for one in records))
        assert again.trace.read_text() == whole, writes
    assert killed >= len(ACTS)


@pytest.mark.parametrize(
    ("act", "error"),
    [
        (lambda run: run.submit("(nothing)"), RefusedError),
        (lambda run: run.cancel(("nothing",)), ArgumentError),
        (lambda run: run.assert_fact("nothing", 1), Error),
    ],
)
def test_failed_act_is_not_repeated(
    run: Run, act: Callable[[DurableRun], None], error: type[Exception]
) -> None:
    durable = run.begin()
    with pytest.raises(error):
        act(durable)
    durable.close()
    _go(run.resume(), 0)


def test_forced_result_is_refused_before_it_is_written(run: Run) -> None:
    durable = run.begin()
    with pytest.raises(ArgumentError, match="in a run with a journal"):
        durable.act(ForceResult(("make", "?"), "okay"))
    durable.close()
    assert not any(isinstance(one, Acted) for one in read(run.journal).records)


@pytest.mark.parametrize(
    "change",
    [
        lambda run: run.submit("(answer 7)"),
        lambda run: run.cancel(("keep-up",)),
        lambda run: run.assert_fact("wanted", 1),
        lambda run: run.erase("wanted"),
        lambda run: run.signal(":bell", 7),
        lambda run: run.call_at(3, print),
    ],
)
def test_change_outside_the_journal_is_refused(
    run: Run, change: Callable[[rapc.Interpreter], None]
) -> None:
    durable = run.begin()
    for _ in range(2):
        with pytest.raises(StateError, match="its journal would not have the change"):
            change(durable.run)
        durable.submit("(answer 7)")
    durable.close()
    durable = run.resume()
    with pytest.raises(StateError, match="its journal would not have the change"):
        change(durable.run)
    durable.close()


def test_run_with_many_acts_has_snapshots(run: Run) -> None:
    durable = run.begin()
    for n in range(10):
        durable.assert_fact("wanted", n)
        durable.reach(durable.run.cycle + 2)
    durable.close()
    assert len(numbers(run.journal)[1]) >= 3


def test_act_in_the_middle_of_a_cycle_is_refused(run: Run) -> None:
    durable = run.begin()
    durable.assert_fact("wanted", 1)
    said: list[str] = []

    def submit(event: object) -> None:
        with pytest.raises(StateError) as error:
            durable.submit("(answer 7)")
        said.append(error.value.message)

    durable.run.listen(submit, TaskSelected)
    durable.step()
    assert said[0] == "cannot change the run in the middle of a cycle"
    durable.close()
    run.resume().close()
