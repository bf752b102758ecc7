"""Journals of runs in worlds that cannot be saved: each request is done once."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from random import Random
from typing import Any

import pytest
from msgspec.structs import replace

import rapc
from bench.kills import data_in
from rapc.base.values import Fact
from rapc.durable import journal
from rapc.durable.folder import Options, Writer
from rapc.durable.resuming import LOST, ResumedWorld
from rapc.durable.runs import DurableRun
from rapc.errors import PortError, StateError
from rapc.spec import RunSpec
from tests.durable.helpers import Killed, Run, kill_after
from tests.durable.peer import Peer, PeerWorld, ResumablePeer, library, of

JOBS = 4
pytestmark = pytest.mark.usefixtures("killable")


BRIEFLY = """
(define-rap (briefly ?n)
  (method (task-net (t1 (work-p ?n) (until-end t2)) (t2 (await 2)))))
(define-rap (await ?n)
  (succeed (beaten ?n))
  (monitor-state (beaten ?n))
  (method (task-net)))
"""


def _run(folder: Path, peer: Peer, kind: type[PeerWorld], *tasks: str) -> Run:
    program = rapc.loads(library(JOBS) + BRIEFLY).program
    spec = RunSpec(tasks=tasks or ("(all)",))
    return Run(folder, program, spec, lambda: kind(of(peer)))


def _kill(run: Run, writes: int) -> None:
    """Begin or resume a run, and kill it after some records."""
    with pytest.MonkeyPatch.context() as patch:
        kill_after(writes, patch)
        with pytest.raises(Killed):
            _start(run).go()


def _start(run: Run) -> DurableRun:
    return run.resume() if (run.journal / "meta").exists() else run.begin()


def _go(run: Run) -> str:
    """Resume a run and bring it to its end; return the reason."""
    durable = run.resume()
    reason = durable.go()
    durable.close()
    return reason


ONCE = Counter((name, n) for name in ("look", "work") for n in range(1, JOBS + 1))
"""Each request of all jobs once."""


@pytest.mark.parametrize("sync", ["off", "requests", "always"])
def test_requests_and_data_are_exact_whatever_the_last_record(
    tmp_path: Path, sync: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal, "CYCLES", 3)
    monkeypatch.setattr(journal, "PAUSE", 0)
    for writes in range(3, 60, 1 if sync == "off" else 7):
        folder = tmp_path / str(writes)
        folder.mkdir()
        peer = Peer()
        run = _run(folder, peer, ResumablePeer)
        run.options = Options(sync=sync)
        _kill(run, writes)
        assert _go(run) == "done"
        assert peer.started == peer.done == ONCE, writes
        data = data_in(run.trace)
        assert data == [f"(beat {n + 1})" for n in range(len(data))], writes


def test_requests_and_data_are_exact_in_a_run_killed_often(tmp_path: Path) -> None:
    peer = Peer()
    run = _run(tmp_path, peer, ResumablePeer)
    for writes in (12, 9, 7, 9, 8, 9):
        _kill(run, writes)
    assert _go(run) == "done"
    assert peer.started == peer.done == ONCE
    assert peer.resumed == 6
    events = [json.loads(line) for line in run.trace.read_text().splitlines()]
    assert [one["n"] for one in events] == [*range(len(events))]
    signals = [one for one in events if one["event"] == "signal"]
    assert [one["what"].split()[0] for one in signals] == ["(:resumed"] * 6
    data = data_in(run.trace)
    assert data == [f"(beat {n + 1})" for n in range(len(data))]
    # a run that has ended is repeated from its journal alone
    before = run.trace.read_text()
    assert _go(run) == "done"
    assert run.trace.read_text() == before
    assert peer.resumed == 6


class Anew(PeerWorld):
    """The world of a peer whose clock begins again, and that knows no tickets."""

    def __init__(self, call: Any) -> None:
        super().__init__(call)
        self._begun = call("now")

    def now(self) -> Any:
        return super().now() - self._begun

    def next_time(self) -> Any:
        due = super().next_time()
        return None if due is None else due - self._begun

    def advance(self, to: Any) -> None:
        super().advance(to + self._begun)


def _killed_in(
    folder: Path,
    request: str,
    *tasks: str,
    answered: bool = True,
    kind: type[PeerWorld] = Anew,
) -> tuple[Run, Peer]:
    """Return a run that was killed before or after the answer to a request."""
    peer = Peer()
    run = _run(folder, peer, kind, *tasks)
    write = Writer.write
    wanted = b'"told"' if answered else b'"ask"'

    def kill(self: Writer, data: bytes) -> None:
        write(self, data)
        if wanted in data and request.encode() in data:
            raise Killed

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Writer, "write", kill)
        with pytest.raises(Killed):
            run.begin().go()
    if kind is Anew:  # the robot begins anew, too
        peer.jobs.clear()
        peer.messages()
    return run, peer


def _refused(run: Run) -> list[tuple[str, str]]:
    """Return the refused requests of a run, each with its reason."""
    events = [json.loads(line) for line in run.trace.read_text().splitlines()]
    return [
        (one["request"], one["because"])
        for one in events
        if one["event"] == "request-refused"
    ]


@pytest.mark.parametrize("answered", [False, True])
@pytest.mark.parametrize(
    ("request_", "treatment", "times"),
    [
        (["look", 2], {}, 2),  # a sensor
        (["work", 2], {"work": "repeat"}, 2),
        (["work", 2], {"*": "repeat"}, 2),
        (["work", 2], {"work": "ask"}, 2),
    ],
)
def test_request_with_unknown_outcome_is_sent_again(
    tmp_path: Path,
    request_: list[Any],
    treatment: dict[str, str],
    times: int,
    answered: bool,
) -> None:
    text = json.dumps(request_, separators=(",", ":"))
    run, peer = _killed_in(tmp_path, text, answered=answered)
    run.options = replace(run.options, after_crash=treatment)
    run.decide = lambda request: "repeat"
    assert _go(run) == "done"
    begun = peer.started[tuple(request_)]
    # the process ended before the request was sent, or after
    at_once = request_[0] == "look"
    assert begun == (1 if at_once or not answered else times)
    assert peer.started.total() == 2 * JOBS + begun - 1


@pytest.mark.parametrize("answered", [False, True])
@pytest.mark.parametrize("treatment", [{}, {"work": "ask"}])
def test_request_with_unknown_outcome_fails(
    tmp_path: Path, treatment: dict[str, str], answered: bool
) -> None:
    run, peer = _killed_in(tmp_path, '["work",2]', answered=answered)
    run.options = replace(run.options, after_crash=treatment)
    assert _go(run) == "done"
    assert _refused(run) == [("(work 2)", LOST)]
    # the method fails, and the task chooses again
    assert peer.started["work", 2] == 1 + answered


ALL_AT_ONCE = tuple(f"(work-p {n}) :priority {9 - n}" for n in range(1, JOBS + 1))


def test_requests_under_way_at_once_are_decided_one_by_one(tmp_path: Path) -> None:
    run, peer = _killed_in(tmp_path, '["work",4]', *ALL_AT_ONCE)
    run.options = replace(run.options, after_crash={"work": "ask"})
    asked: list[Fact] = []

    def decide(request: Fact) -> str:
        asked.append(request)
        return "fail" if request[1] in (2, 4) else "repeat"

    run.decide = decide
    assert _go(run) == "done"
    assert asked == [("work", n) for n in range(1, JOBS + 1)]
    assert _refused(run) == [("(work 2)", LOST), ("(work 4)", LOST)]
    assert peer.done == Counter(asked)
    assert peer.started == Counter(asked * 2)


def test_requests_under_way_at_once_are_done_once(tmp_path: Path) -> None:
    for writes in range(3, 24):
        folder = tmp_path / str(writes)
        folder.mkdir()
        peer = Peer()
        run = _run(folder, peer, ResumablePeer, *ALL_AT_ONCE)
        _kill(run, writes)
        peer.advance(peer.now() + 2 * (writes % 3))  # the robot goes on alone
        assert _go(run) == "done"
        wanted = Counter(("work", n) for n in range(1, JOBS + 1))
        assert peer.started == peer.done == wanted, writes


@pytest.mark.parametrize("kind", [Anew, ResumablePeer])
@pytest.mark.parametrize("last", ['["work",3]', '["look",2]', '"cancel"'])
def test_cancelled_request_is_not_sent_again(
    tmp_path: Path, last: str, kind: type[PeerWorld]
) -> None:
    tasks = "(briefly 9) :priority 2", "(all)"
    run, peer = _killed_in(tmp_path, last, *tasks, kind=kind)
    run.options = replace(run.options, after_crash={"*": "repeat"})
    _go(run)
    assert peer.started["work", 9] == 1
    assert peer.done["work", 9] == 0


def test_request_is_not_sent_again_to_be_cancelled(tmp_path: Path) -> None:
    peer = Peer()
    run = _run(tmp_path, peer, Anew, "(briefly 9)")
    with pytest.MonkeyPatch.context() as patch:
        patch.delattr(Peer, "cancel")
        with pytest.raises(PortError):
            run.begin().go()
    peer.jobs.clear()
    run.options = replace(run.options, after_crash={"*": "repeat"})
    assert _go(run) == "done"
    assert peer.started == {("work", 9): 1}


def test_clock_that_begins_again_goes_on(tmp_path: Path) -> None:
    run, _ = _killed_in(tmp_path, '["work",3]')
    _go(run)
    events = [json.loads(line) for line in run.trace.read_text().splitlines()]
    times = [one["time"] for one in events]
    assert times == sorted(times)


class Clock(PeerWorld):
    """A world with messages at times that are given."""

    def __init__(self, dues: list[float]) -> None:
        self.time, self.dues = 0.0, dues

    def now(self) -> float:
        return self.time

    def next_time(self) -> float | None:
        return min((due for due in self.dues if due > self.time), default=None)

    def advance(self, to: float) -> None:
        self.time = to


def test_clock_that_begins_again_comes_to_each_time_exactly() -> None:
    chance = Random(1)
    for _ in range(200):
        behind = Clock(sorted(chance.random() * 100 for _ in range(10)))
        world = ResumedWorld(behind, 0)
        before = chance.random() * 1000
        world.ask_from(before)
        assert world.now() == before
        for due in behind.dues:
            found = world.next_time()
            assert found is not None
            for to in (before + (found - before) / 3, found):
                world.advance(to)
                assert to <= world.now() <= to + 1e-9
                before = world.now()
            assert behind.time == due
            assert world.now() >= before


def test_world_that_has_forgotten_messages_is_refused(tmp_path: Path) -> None:
    run, peer = _killed_in(tmp_path, '["work",3]', kind=ResumablePeer)
    peer.forgotten = 100
    with pytest.raises(StateError, match="cannot resume: the world `peer` refuses"):
        run.resume().go()


def test_kit_is_told_of_a_resumed_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, _ = _killed_in(tmp_path, '["work",3]')
    told: list[float] = []

    def resumed(memory: Any, seconds: float) -> None:
        told.append(seconds)
        memory.assert_fact("done", 100)

    monkeypatch.setattr(Anew, "kit", replace(PeerWorld.kit, resumed=resumed))
    durable = run.resume()
    durable.go()
    assert told[0] >= 0
    assert ("done", 100) in set(durable.run.memory)
