"""A reported run is repeated from its file alone, and a damaged file is refused."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import msgspec
import pytest

import rapc
from rapc.base.values import Fact, Text
from rapc.debug import act_lines, acts, bug
from rapc.debug.acts import Act
from rapc.debug.bug import read_bug, write_bug
from rapc.debug.history import History
from rapc.debug.log import EventLog
from rapc.debug.reload import TakeUp, typed_in
from rapc.errors import Error, LoadError, StateError
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest
from rapc.world import World
from rapc.worlds.registry import world_of
from tests.debug import moments
from tests.debug.sessions import scripted
from tests.debug.test_answers import machine
from tests.effort import first

SMALL = "(declare-memory-proposition p (?x)) (define-rap (top) (succeed (p a)))"

_FACTS: list[Fact] = [
    ("p", "a"),
    ("p", Text('say "x" \\ (now)')),
    ("p", -3),
    ("p", 0.1),
    ("p", 2**70),
    ("q",),
]

ACTS: list[Act] = [
    *map(acts.AssertFact, _FACTS),
    *map(acts.EraseFacts, _FACTS),
    *[
        acts.SubmitTask(TaskRequest(fact, 3, 40.5, 2, background=True))
        for fact in _FACTS
    ],
    acts.SubmitTask(TaskRequest(("top",))),
    acts.CancelTasks(("top", "?", "?x")),
    acts.SendSignal((":door-open", "hall", 3)),
    acts.FailTask(12),
    acts.RetryTask(3),
    *[acts.ChangeOption("w", "size", one) for one in (True, 3, 0.5, "red", "a b")],
    acts.ForceResult(("arm-grasp", "?", "b"), "arm-dropped", 3),
]


def _again(act: Act) -> Act:
    data = msgspec.json.encode(act_lines.written(act))
    return act_lines.read(msgspec.json.decode(data, type=act_lines.line_types()))


@pytest.mark.parametrize("act", ACTS, ids=str)
def test_an_act_is_the_same_after_a_file(act: Act) -> None:
    assert _again(act) == act


def test_all_kinds_of_acts_can_be_written() -> None:
    kinds = {*acts.Act.__subclasses__()}
    assert kinds == {*act_lines.KINDS}
    assert {type(act) for act in ACTS} == kinds - {TakeUp}


def test_a_reloaded_library_is_the_same_after_a_file() -> None:
    session = scripted(SMALL, "(top)")
    renewed = typed_in(session.library.program.library, "(define-rap (new))", "small")
    act = session.take_up(renewed.library)
    again = _again(act)
    assert isinstance(again, TakeUp)
    assert (str(again), again.program.digest) == (str(act), act.program.digest)


def _repeated(path: Path, world: Callable[[], World] | None = None) -> History:
    """Return the run of a report at the moment of the report."""
    found, log = read_bug(path), EventLog()
    made = world_of(found.spec) if world is None else world()
    run = Interpreter.prepared(found.library, made, found.spec)
    run.listen(log)
    run.start(found.spec.until)
    session = History(run, log, found.acts)
    stop = session.reach(found.written_at.moment)
    if stop.kind == "asked" and found.written_at.reason:
        session.step()
    assert bug.present_moment(session) == found.written_at
    return session


def _acted(session: History, dice: random.Random) -> None:
    """Let a user do something at random moments."""
    session.step(10)
    run = session.run
    facts = [one for one in run.memory if len(one) > 1]
    results = sorted(run.port.kit.offer.primitives) or ["none"]
    for _ in range(6):
        for _ in range(dice.randrange(12)):
            session.wait()
        live = [task.number for task in session.run.tasks()] or [1]
        act = dice.choice(
            [
                acts.AssertFact(dice.choice(facts)),
                acts.EraseFacts(dice.choice(facts)[:2]),
                acts.FailTask(dice.choice(live)),
                acts.RetryTask(dice.choice(live)),
                acts.ChangeOption("rapc", "futile-limit", dice.randrange(1, 5)),
                acts.ForceResult((dice.choice(results),), "okay"),
            ]
        )
        try:
            session.act(act)
        except Error:
            continue


@pytest.mark.parametrize("name", ["courier", "truck", "hallway"])
@pytest.mark.parametrize("seed", first(2, range(20), 8))
def test_a_reported_run_is_repeated(name: str, seed: int, tmp_path: Path) -> None:
    session = moments.RUNS[name](10_000)
    _acted(session, random.Random(seed))
    assert session.branch.acts
    path = tmp_path / "run.bug"
    write_bug(session, path)
    again = _repeated(path)
    told = [one.event() for one in session.scan()]
    assert [one.event() for one in again.scan()] == told
    assert again.over or again.run.save() == session.run.save()
    assert [one.act for one in again.branch.acts] == [
        one.act for one in session.branch.acts
    ]
    write_bug(again, tmp_path / "again.bug")
    assert (tmp_path / "again.bug").read_bytes() == path.read_bytes()


def test_a_report_of_an_ended_run_ends_as_well(tmp_path: Path) -> None:
    session = moments.courier(10_000)
    session.go()
    write_bug(session, tmp_path / "run.bug")
    again = _repeated(tmp_path / "run.bug")
    assert (again.over, again.reason) == (True, "done")
    again.goto(3)
    session.goto(3)
    assert again.run.save() == session.run.save()


def test_only_acts_of_the_present_branch_and_past_are_reported(tmp_path: Path) -> None:
    session = moments.courier(10_000)
    session.step(10)
    session.act(acts.AssertFact(("call", "ward-3")))
    session.step(10)
    session.act(acts.AssertFact(("call", "ward-2")))
    session.goto(15)
    write_bug(session, tmp_path / "run.bug")
    found = read_bug(tmp_path / "run.bug")
    assert [str(one.act) for one in found.acts] == ["asserted (call ward-3)"]
    assert found.written_at.cycle == 15


def test_a_run_of_a_machine_is_not_reported(tmp_path: Path) -> None:
    library = rapc.load("examples/rock-order.rap")
    session = History.open(library, machine(), tasks=["(rock-order red 1)"])
    with pytest.raises(StateError, match="cannot report a run in the world `truck`"):
        write_bug(session, tmp_path / "run.bug")


# --- damaged files ------------------------------------------------------------------


def _report(tmp_path: Path) -> tuple[Path, list[bytes]]:
    """Return a report with acts, and its lines."""
    session = moments.courier(10_000)
    _acted(session, random.Random(5))
    path = tmp_path / "run.bug"
    write_bug(session, path)
    return path, path.read_bytes().splitlines(keepends=True)


def test_a_damaged_report_is_refused_in_one_line(tmp_path: Path) -> None:
    path, lines = _report(tmp_path)
    files = next(at for at, one in enumerate(lines) if b'"line":"act"' in one)
    head, file, act, end = lines[0], lines[1], lines[files], lines[-1]
    texts = {
        "is not a bug report of rapc": [b"", b"{}\n", b"\x00\xff", b"[]\n", file],
        "written by another version of rapc: format 99": [
            head.replace(b'"format":1', b'"format":99')
        ],
        "is cut off": [b"".join(lines[:-1]), head],
        "line 2: ": [head + b"[" * 5000 + b"\n" + end, head + b"{}\n" + end],
        "out of order": [
            b"".join([head, act, file, end]),
            b"".join([*lines[:files], *reversed(lines[files:-1]), end]),
            b"".join([head, head, end]),
        ],
        "the digest of `": [b"".join(lines).replace(b"robot", b"droid")],
        "the digest of its library is different": [
            b"".join([head, *lines[2:files], lines[1], *lines[files:]]),
        ],
        "has errors: unknown predicate": [b"".join([head, *lines[2:]])],
        "two of its files have one name": [b"".join([head, file, *lines[1:]])],
        "acts, not": [b"".join([*lines[:files], *lines[files + 1 :]])],
    }
    for said, broken in texts.items():
        for text in broken:
            path.write_bytes(text)
            with pytest.raises(LoadError) as error:
                read_bug(path)
            assert said in error.value.message, (said, error.value.message)
            assert "\n" not in error.value.message


@pytest.mark.parametrize("part", range(4))
def test_no_damage_ends_in_a_message_of_python(part: int, tmp_path: Path) -> None:
    path, lines = _report(tmp_path)
    data, dice = b"".join(lines), random.Random(part)
    acts_at = data.index(b'{"line":"act"')
    refused = 0
    for _ in range(60):
        at = dice.randrange(0 if dice.random() < 0.3 else acts_at, len(data))
        kind = dice.randrange(3)
        byte = bytes([dice.randrange(32, 127)])
        changed = data[:at] + (b"" if kind == 0 else byte) + data[at + (kind < 2) :]
        path.write_bytes(changed)
        try:
            _repeated(path)
        except (Error, AssertionError):
            refused += 1
    assert refused > 30
