"""A session stands where it was, wherever it goes back to, and goes on as it did."""

from __future__ import annotations

import random
from collections import deque

import pytest

import rapc
from rapc.base.values import Fact
from rapc.debug.acts import AssertFact, FailTask, SubmitTask
from rapc.debug.history import Branch, History, Moment
from rapc.debug.log import EventLog, ToldEvent
from rapc.errors import ArgumentError, StateError
from rapc.runtime.task_request import read_task_request
from rapc.world import Refused, Reply
from rapc.worlds.scripted import ScriptedWorld
from tests.debug import long, moments
from tests.debug.sessions import row, truck
from tests.effort import first


def _states(session: History) -> list[bytes]:
    """Run to the end and return the state after each cycle, the first one too."""
    found = [session.run.save()]
    while session.step().kind == "asked":
        found.append(session.run.save())
    return found


def _told(session: History) -> list[ToldEvent]:
    return [*session.scan()]


@pytest.mark.parametrize("often", first(1, [15, 60]))
def test_every_moment_is_reached_again_as_it_was(often: int) -> None:
    session = truck("(rock-order red 1)", "(rock-order blue 1) :at 30 :priority 1")
    states = _states(session)
    events = _told(session)
    chance = random.Random(4)
    for _ in range(often):
        cycle = chance.randrange(len(states))
        session.goto(cycle)
        assert session.cycle == cycle
        assert session.run.save() == states[cycle]
    session.go()
    assert _told(session) == events
    assert len(states) > 300


@pytest.mark.parametrize(
    ("library", "world", "given"),
    [
        ("examples/courier", "courier", {"agenda": "shift"}),
        ("stdlib/truck", "truck", {"tasks": ["(ready-weapon)"]}),
        (
            "stdlib/hallway",
            "rapc.worlds.hallway:HallwayWorld",
            {"tasks": ["(get-bearings)"]},
        ),
    ],
)
def test_other_worlds_are_taken_back_as_well(
    library: str, world: str, given: dict[str, object]
) -> None:
    session = History.open(rapc.load(library), world, seed=3, **given)
    states = _states(session)
    events = _told(session)
    chance = random.Random(6)
    for _ in range(20):
        cycle = chance.randrange(len(states))
        session.goto(cycle)
        assert session.run.save() == states[cycle]
    session.go()
    assert _told(session) == events
    assert len(states) > 20


@pytest.mark.slow
@pytest.mark.parametrize("name", moments.RUNS)
def test_random_moments_are_reached_again_and_gone_on_from(name: str) -> None:
    found = moments.check(moments.RUNS[name](600), points=30)
    assert (found.points, found.differ) == (30, [])
    assert found.cycles == (600 if name != "courier" else 225)  # the shift is over


def test_waits_for_a_thing_are_saved_in_any_order() -> None:
    found = moments.check(moments.courier(100), points=25)
    assert (found.cycles, found.differ) == (100, [])


def test_a_long_session_stays_small() -> None:
    found = long.measured(long.patrol(), 12_000)
    assert found.states < 60
    assert found.bytes_kept < 2_000_000


def test_going_on_from_the_past_gives_the_same_events() -> None:
    session = truck()
    session.go()
    events = _told(session)
    session.goto(40)
    assert _told(session) == [one for one in events if one.serial < session.serial]
    assert session.go().kind == "over"
    assert _told(session) == events


def test_a_time_is_reached_from_both_sides() -> None:
    session = truck()
    session.goto_time(50)
    there = session.moment, session.now
    assert session.now <= 50
    session.go()
    session.goto_time(50)
    assert (session.moment, session.now) == there
    session.step()
    assert session.now > 50


@pytest.mark.parametrize("world", ["courier", "truck"])
def test_a_time_is_the_same_moment_from_everywhere(world: str) -> None:
    session = moments.courier(0) if world == "courier" else truck()
    session.go(heed=False)
    assert session.over
    end, between = session.now, 0
    for time in (0, 3, 14.2, end / 7, end / 2, end - 0.5, end, end + 1):
        stood = set()
        for start in (0, 10**6, 5, session.cycle // 2, session.cycle + 1):
            session.goto(start)
            session.goto_time(time)
            assert session.now <= time
            state = b"" if session.over else session.run.save()
            stood.add((session.moment, session.over, state))
        assert len(stood) == 1, (time, stood)
        between += session.between
        if not session.over:
            session.wait()
            assert session.now > time
    assert between or world == "truck"


def test_a_session_stands_at_each_arrival() -> None:
    session = moments.courier(1000)
    session.step(30)
    events = _told(session)
    session.goto(0)
    stood = []
    while session.cycle < 30:
        assert session.wait().kind == "asked"
        stood.append((session.moment, session.now, session.run.save()))
    assert _told(session) == events
    between = [one for one in stood if one[0].arrivals]
    assert len(between) > 10
    for moment, now, state in random.Random(1).sample(stood, 20):
        session.goto_time(now)
        assert session.moment >= moment
        session.goto(moment.cycle)
        for _ in range(moment.arrivals):
            session.wait()
        assert (session.moment, session.now, session.run.save()) == (moment, now, state)


def test_a_past_choice_is_seen_after_the_acts_before_it() -> None:
    session = moments.courier(1000)
    session.step(20)
    while not session.between:
        session.wait()
    cycle = session.cycle
    session.act(AssertFact(("call", "ward-3")))
    session.step(5)
    here = session.moment, session.run.save()
    with session.at(cycle) as run:
        assert ("call", "ward-3") not in run.memory
    with session.at_choice(cycle + 1) as run:
        assert ("call", "ward-3") in run.memory
        assert run.cycle == cycle
    assert (session.moment, session.run.save()) == here


def test_acts_between_cycles_are_done_again_there() -> None:
    session = moments.courier(1000)
    session.step(20)
    while not session.between:
        session.wait()
    before = session.cycle
    session.act(AssertFact(("call", "ward-3")))
    session.act(SubmitTask(read_task_request("(answer-calls)")))
    here, state = session.moment, session.run.save()
    session.step(40)
    later, events = session.run.save(), _told(session)
    session.goto(3)
    session.goto(session.seen)
    assert (session.run.save(), _told(session)) == (later, events)
    session.goto(before)
    assert session.moment.acts == 0
    session.wait()
    assert (session.moment, session.run.save()) == (here, state)
    assert len(session.branches) == 1


def test_lost_events_are_replayed() -> None:
    session = truck()
    session.go()
    events = _told(session)
    here = session.moment, session.run.save()
    assert isinstance(session.log, EventLog)
    kept = session.log.events
    kept.latest = deque(kept.latest, maxlen=50)
    assert not session.log.has(0)
    assert _told(session) == events
    late = [one for one in events if one.cycle >= 90]
    assert [*session.scan(first=90)] == late
    assert (session.moment, session.run.save()) == here


def test_looking_elsewhere_changes_nothing() -> None:
    session = truck()
    session.step(60)
    here, events = session.run.save(), _told(session)
    with session.at(10) as run:
        assert session.cycle == 10
        run.step()
        run.assert_fact("truck-fuel", 3)
    assert session.run.save() == here
    assert _told(session) == events
    assert session.moment == (60, 0, 0)


def test_acts_are_done_again_where_they_were_done() -> None:
    session = truck()
    session.step(20)
    session.act(SubmitTask(read_task_request("(rock-order blue 1) :priority 3")))
    session.step(30)
    session.act(AssertFact(("truck-fuel", 3)))
    states = {session.cycle: session.run.save()}
    session.step(20)
    states[session.cycle] = session.run.save()
    for cycle in (70, 50):
        session.goto(3)
        session.goto(cycle)
        assert session.run.save() == states[cycle]
    assert [branch.name for branch in session.branches] == ["main"]


def test_an_act_in_the_past_begins_a_branch() -> None:
    session = truck()
    session.go()
    end = session.run.results()
    session.goto(30)
    session.act(SubmitTask(read_task_request("(rock-order blue 1)")))
    assert [branch.name for branch in session.branches] == ["main", "branch-1"]
    session.go()
    assert len(session.run.results()) == 2
    session.switch("main")
    assert session.cycle == 30
    session.go()
    assert session.run.results() == end
    session.switch("branch-1")
    assert len(session.run.results()) == 2
    with pytest.raises(ArgumentError, match="unknown branch `x`"):
        session.switch("x")


def test_a_known_moment_ahead_is_reached_from_a_saved_state() -> None:
    session = truck(*(f"(rock-order {one} 1)" for one in ("red", "blue", "black")))
    asked: list[str] = []
    session.run.watch_contexts(lambda *told: asked.append(told[1]))
    session.step(300)
    assert len(asked) > 100
    session.goto(5)
    asked.clear()
    session.goto(300)
    assert session.cycle == 300
    assert asked == []


def test_a_branch_has_its_own_events() -> None:
    session = truck()
    session.go()
    main = _told(session)
    session.goto(60)
    session.act(SubmitTask(read_task_request("(rock-order blue 1) :priority 3")))
    session.step(100)
    branch = _told(session)
    session.goto(70)
    session.switch("main")
    session.goto(150)
    assert _told(session) == main[: session.serial]
    session.switch("branch-1")
    assert session.cycle == 70
    session.goto(160)
    assert _told(session) == branch


def test_finished_run_continues_with_new_input() -> None:
    session = truck()
    assert session.go().said == "done"
    last, told = session.cycle, _told(session)
    with pytest.raises(ArgumentError, match="unknown task"):
        session.act(FailTask(999))
    assert session.over
    assert _told(session) == told
    session.act(SubmitTask(read_task_request("(rock-order blue 1)")))
    assert not session.over
    assert session.go().said == "done"
    assert session.cycle > last
    assert [one.outcome for one in session.run.results()] == ["succeeded"] * 2
    assert [branch.name for branch in session.branches] == ["main"]
    told = _told(session)
    assert [one.serial for one in told] == list(range(len(told)))


def test_impossible_act_changes_nothing() -> None:
    session = truck()
    session.step(5)
    here = session.run.save()
    with pytest.raises(ArgumentError, match="unknown task"):
        session.act(FailTask(99))
    assert session.run.save() == here
    assert session.moment == (5, 0, 0)


def test_saves_grow_few_with_age() -> None:
    session = truck("(rock-order red 4)", "(rock-order blue 4)")
    session.go()
    assert session.cycle > 700
    saves = session.branch.saves
    few, save = Branch("few"), next(iter(saves.values()))
    for cycle in range(0, 100_000, 64):
        few.keep(Moment(cycle), save)
    assert 1 < len(saves) < 6
    assert 60 < len(few.saves) < 120
    gaps = [
        (100_000 - cycle) / (cycle - found)
        for cycle in range(0, 99_000, 500)
        for found in [max(at.cycle for at in few.saves if at.cycle <= cycle)]
        if cycle - found > 128
    ]
    assert min(gaps) > 6


def test_unsavable_run_only_goes_forward() -> None:
    session = truck()
    session.run.call_at(500, lambda: None)
    session.no_way_back = ""
    session._save()
    session.step(10)
    with pytest.raises(StateError, match="cannot go back"):
        session.goto(2)
    assert session.cycle == 10


def test_pause_before_the_continuation_counts() -> None:
    session = truck()
    session.pause()
    assert (session.go().kind, session.cycle) == ("pause", 1)
    session.pause()
    session.pause(False)
    assert session.go().kind == "over"


class Breaking(ScriptedWorld):
    """A world that breaks at the time 2."""

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        if self.now() >= 2:
            raise RuntimeError("the arm is off")
        return super().perform(ticket, request)


def test_times_before_the_break_of_a_world_are_reached() -> None:
    text = """
    (declare-primitive act (?x) (okay))
    (define-rap (top) (method (task-net
      (t1 (use a) (for t2)) (t2 (use b) (for t3)) (t3 (use c)))))
    (define-rap (use ?x) (method (primitive (act ?x))))
    """
    library = rapc.loads(text, "small.rap")
    world = Breaking([row("(act ?)")], declared=library.program.library)
    session = History.open(library, world, tasks=["(top)"])
    assert session.go().kind == "broken"
    stood = set()
    for start in (10**6, 0, 2):
        session.goto(start)
        session.goto_time(1.5)
        assert session.now <= 1.5
        assert not session.over
        stood.add((session.moment, session.run.save()))
    assert len(stood) == 1
    session.goto_time(2)
    assert session.now == 2
