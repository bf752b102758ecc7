"""A run that is saved and taken up again goes on as if nothing had happened."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from functools import partial

import msgspec
import pytest

from rapc.base.source import SourceFile
from rapc.base.values import Fact
from rapc.compiler.program import Program
from rapc.errors import StateError
from rapc.events import Event, SignalReceived
from rapc.library.library import link
from rapc.parser.parse import parse
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving import format
from rapc.runtime.settings import Settings
from rapc.world import Kit, Message, Offer, Time, World
from rapc.worlds.registry import build_world
from rapc.worlds.script import Row
from rapc.worlds.truck import TruckWorld
from tests.effort import first
from tests.reference.case import Case, begin, interpreter_of, stepwise
from tests.reference.generate import generate
from tests.reference.vocabulary import UNBROKEN
from tests.runtime import saving
from tests.runtime.helpers import Play, at, compiled, row

ORDER = """
(define-rap (sort ?what)
  (resources (set ?seen) (counter ?tries 1))
  (method (context (not (method-tried other))) (notations (q busy ?what))
    (task-net (t1 (slow-one ?what) (set-add ?seen ?what) (for t2))
              (t2 (wait ?what ?seen))))
  (method other (context (p never)) (primitive (look ?what))))
(define-rap (slow-one ?x) (method (primitive (slow ?x))))
(define-rap (wait ?x ?seen) (succeed (and (p ?x) (member ?seen ?x)))
  (monitor-state (and (p ?x) (member ?seen ?x)))
  (method (primitive (look ?x))))
"""


# --- the same from there on ---------------------------------------------------------


def test_a_run_of_the_truck_goes_on_as_if_nothing_had_happened() -> None:
    assert saving.compare(seed=5, points=1, far=1) == 0


@pytest.mark.slow
def test_truck_runs_continue_from_any_point() -> None:
    assert [saving.compare(seed, points=10, far=2) for seed in range(2)] == [0] * 2


def _events(run: Interpreter) -> list[Event]:
    found: list[Event] = []
    run.listen(found.append)
    return found


def _both(case: Case, cycles: int) -> tuple[list[Event], list[Event]]:
    """What comes after some cycles of a case: as it is, and taken up from a save."""
    run = interpreter_of(case)
    events = _events(run)
    begin(case, run)
    for _ in range(cycles):
        run.step()
    line, saved = len(events), run.save()
    assert run.save() == saved
    other = interpreter_of(case)
    taken_up = _events(other)
    other.restore(saved)
    assert other.save() == saved
    left = None if case.cycles is None else max(case.cycles - cycles, 0)
    run.run(case.until, left)
    other.run(case.until, left)
    return events[line:], taken_up


@pytest.mark.parametrize("chunk", first(1, range(100), 25))
def test_generated_programs_go_on_as_if_nothing_had_happened(chunk: int) -> None:
    for seed in range(chunk * 20, (chunk + 1) * 20):
        case = stepwise(generate(seed, UNBROKEN))
        cycles = random.Random(f"cycles:{seed}").randrange(1, 30)
        as_it_is, taken_up = _both(case, cycles)
        assert taken_up == as_it_is, f"seed {seed}, after {cycles} cycles"


def test_signal_of_ended_owner_is_the_same_after_restore() -> None:
    """The host cancels the owner after the world has sent the signal."""
    text = """
    (declare-event :seen (?x))
    (declare-skill :look-out () :events (:seen))
    (define-rap (watch)
      (method (primitive (enable (:look-out)) (wait-for (:seen stop) :succeed))))
    (define-rap (work)
      (method (task-net (t1 (act-now) (for t2)) (t2 (act-now)))))
    (define-rap (act-now) (method (primitive (act a))))
    """
    seen = Row((":look-out",), after=5, signals=((":seen", "x"),), kind="enable")
    play = Play(text, "(watch)", "(work)", rows=(seen, row("(act a)", takes=5)))
    run = play.interpreter
    while run.now < 5:
        run.step()
    assert run.cancel(("watch",)) == 1
    other = run.fork()
    assert other.save() == run.save()
    line = len(play.events)
    assert _rest(other) == play.run().events[line:]
    owners = [e.task for e in play.events if isinstance(e, SignalReceived)]
    assert owners == [1]


# --- in place, and beside ----------------------------------------------------------


def _sorting() -> Play:
    times = [at(5, "(p a)"), at(9, "(p b)")]
    return Play(ORDER, "(sort a)", "(sort b) :at 4 :deadline 6", times=times)


def _rest(run: Interpreter) -> list[Event]:
    found = _events(run)
    run.run()
    return found


def test_a_run_goes_back_in_place_as_often_as_wanted() -> None:
    play = _sorting()
    run = play.interpreter
    for _ in range(6):
        run.step()
    line, saved = len(play.events), run.save()
    first_time = [*play.run().events[line:]]
    assert run.reason == "done"
    for _ in range(2):
        run.restore(saved)
        assert run.reason is None
        line = len(play.events)
        play.run()
        assert play.events[line:] == first_time


def test_host_references_point_to_the_restored_run() -> None:
    play = _sorting()
    run = play.interpreter
    run.step()
    saved, memory, ask = run.save(), run.memory, run.question("(p ?x)")
    early = memory.query("q", None, None), ask.all(), run.now, run.goals()
    play.run()
    assert ask.all() == [{"?x": "a"}, {"?x": "b"}]
    run.restore(saved)
    assert (memory.query("q", None, None), ask.all(), run.now, run.goals()) == early


def test_recording_numbers_events_like_the_restored_run() -> None:
    play = _sorting()
    recording = play.interpreter.record()
    play.interpreter.step()
    saved = play.interpreter.save()
    play.interpreter.step()
    play.interpreter.restore(saved)
    play.run()
    assert list(recording) == play.events[-len(recording) :]


def test_a_fork_goes_on_by_itself() -> None:
    play = _sorting()
    run = play.interpreter
    for _ in range(5):
        run.step()
    other, third = run.fork(), run.fork()
    line = len(play.events)
    play.run()
    assert _rest(other) == play.events[line:]
    third.assert_fact("p", "b")
    assert third.question("(p b)").holds()
    assert _rest(third) != play.events[line:]


def test_a_fork_may_be_given_its_world() -> None:
    play, world = _sorting(), _sorting().world
    play.interpreter.step()
    other = play.interpreter.fork(world)
    line = len(play.events)
    assert _rest(other) == play.run().events[line:]


def test_unstarted_and_ended_runs_can_be_saved() -> None:
    new = compiled(ORDER)
    play = _sorting()
    run = Interpreter(new, _sorting().world)
    run.restore(run.save())
    assert run.run() == "done"
    over = play.run().interpreter
    other = over.fork()
    assert (other.reason, other.results()) == (over.reason, over.results())


def test_large_numbers_and_strings_survive() -> None:
    text = """
    (define-rap (keep ?n ?s) (succeed (p done)) (resources (counter ?big ?n))
      (method (notations (q ?s (* ?n ?n))) (primitive (slow a))))
    """
    play = Play(text, f'(keep {2**90} "a \\"b\\"")', rows=[row("(slow a)", after=3)])
    play.interpreter.step()
    found = play.interpreter.fork().memory.query("q", None, None)
    assert found == play.interpreter.memory.query("q", None, None)
    assert found[0][2] == 2**180


def test_notation_of_two_methods_is_held_by_both_after_restore() -> None:
    text = """
    (define-rap (go ?time) (method (notations (q busy all))
      (task-net (t1 (slow-one ?time)))))
    (define-rap (slow-one ?time) (method (primitive (slow ?time))))
    """
    rows = [row("(slow early)", after=3), row("(slow late)", after=9)]
    play = Play(text, "(go early)", "(go late)", rows=rows)
    while len(play.interpreter.goals()) < 4 and play.interpreter.step():
        pass
    other = play.interpreter.fork()
    held: list[tuple[Time, int]] = []
    while other.step():
        held.append((other.now, len(other.memory.query("q", "busy", "all"))))
    assert held[0][1] == 1
    assert (3, 1) in held
    assert other.memory.query("q", "busy", "all") == []


# --- refused ------------------------------------------------------------------------


def _refused(play: Play, saved: bytes, match: str) -> None:
    """Taking up `saved` is refused, and changes nothing."""
    before = play.interpreter.save()
    with pytest.raises(StateError, match=match):
        play.interpreter.restore(saved)
    assert play.interpreter.save() == before


def _forged(saved: bytes, change: Callable[[str], str]) -> bytes:
    """A saved run with other records, under a checksum that fits."""
    text = saved.split(b"\n", 1)[1].decode()
    changed = change(text)
    assert changed != text
    record = msgspec.json.decode(changed)
    body = msgspec.json.encode(record)
    return format.sealed(body)


def test_invalid_saved_run_is_refused() -> None:
    play = _sorting()
    for _ in range(6):
        play.interpreter.step()
    saved = play.interpreter.save()
    _refused(play, b"", "this is not a saved run")
    _refused(play, b"rapc-library 1 x", "this is not a saved run")
    _refused(play, saved[:-1], "is damaged")
    _refused(play, saved.replace(b"slow", b"fast"), "is damaged")
    head = f"rapc-run {format.FORMAT}".encode()
    _refused(play, saved.replace(head, b"rapc-run 0", 1), "format 0")


def test_a_saved_run_of_something_else_is_refused() -> None:
    play = _sorting()
    play.interpreter.step()
    saved = play.interpreter.save()
    _refused(Play(ORDER + "; another", "(sort a)"), saved, "another library")
    other = Play(ORDER, settings=Settings(futile_limit=5))
    _refused(other, saved, "different settings")
    named = _forged(saved, lambda t: t.replace('"scripted"', '"truck"'))
    _refused(play, named, "to the world `truck`, not `scripted`")


def test_a_saved_run_of_another_option_of_the_world_is_refused() -> None:
    def run(**options: int) -> Interpreter:
        world = build_world(TruckWorld, 1, options)
        return Interpreter(saving.library(), world, 1)

    saved = run(**{"arm1-drops": 0}).save()
    other = run(**{"arm1-drops": 20})
    before = other.save()
    named = r"option `truck\.arm1-drops`: `0`, not `20`$"
    with pytest.raises(StateError, match=named):
        other.restore(saved)
    assert other.save() == before
    run(**{"arm1-drops": 0}).restore(saved)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"plan":"sort"', '"plan":"sorted"'),
        ('"state":"running"', '"state":"ruining"'),
        ('"method":0', '"method":9'),
        ('["slow-one",2],', ""),
        ('["slow-one",2]', '["slow-one",2],["slow-one",2]'),
        ('"to_test":[],"missed"', '"to_test":[77],"missed"'),
        ('"random":[3', '"random":[4'),
        ('{"type":"resource","at":0}', '{"type":"resource","at":40}'),
        ('"place":null', '"place":{"type":"else"}'),
        ('"unsettled":[]', '"unsettled":[3]'),
        ('"world":"', '"world":"AAAA'),
        ('"keys":false', '"keys":true'),
        ('[["q","busy","a"],0]', '[["q","busy"],0]'),
        ('[["q","busy","a"],0]', '[["gone","busy","a"],0]'),
        ('"notations":[["q","busy","a"]]', '"notations":[["q","busy","c"]]'),
        ('"aliases":[]', '"aliases":[["a","b"],["b","a"]]'),
        ('"moved_at":3', '"moved_at":1000000000'),
        ('"numbers":6', '"numbers":5'),
        ('"number":6', '"number":5'),
        ('"only":5', '"only":6'),
        ('"method":0,"history"', '"method":-2,"history"'),
        ('{"?x":"b"}', '{"?x":"a"}'),
        ('{"?x":"b"}', "{}"),
        ('"missed":[]', '"missed":[[5,[4]]]'),
        ('"to_test":[],"conflicts"', '"to_test":[6],"conflicts"'),
        ('"time":4,"cycle"', '"time":5,"cycle"'),
        ('"timer":null', '"timer":7'),
    ],
)
def test_impossible_records_are_refused(old: str, new: str) -> None:
    play = _sorting()
    for _ in range(4):
        play.interpreter.step()
    saved = _forged(play.interpreter.save(), lambda t: t.replace(old, new))
    _refused(play, saved, "the saved run is invalid")


def _look_at_clock() -> None:
    """Do nothing."""


def test_run_with_host_timers_cannot_be_saved() -> None:
    """What is to be called is named, with file and line."""
    row = _look_at_clock.__code__.co_firstlineno
    named = rf"`_look_at_clock` \(test_saving\.py:{row}\)"
    play = _sorting()
    play.interpreter.call_at(12, _look_at_clock)
    play.interpreter.call_at(9, partial(print, "nine"))
    said = rf"the host has set `call_at`: `partial` at 9, {named} at 12$"
    with pytest.raises(StateError, match=said):
        play.interpreter.save()
    for ask in ("call_at_end", "call_when_waiting"):
        play = _sorting()
        saved = play.interpreter.save()
        getattr(play.interpreter, ask)(_look_at_clock)
        with pytest.raises(
            StateError, match=rf"replaced: the host has set `{ask}`: {named}$"
        ):
            play.interpreter.restore(saved)


def test_a_run_is_not_saved_in_the_middle_of_a_cycle() -> None:
    play = _sorting()
    met: list[str] = []

    def save(event: Event) -> None:
        with pytest.raises(StateError) as caught:
            play.interpreter.save()
        met.append(caught.value.message)

    play.interpreter.listen(save)
    play.interpreter.step()
    assert set(met) == {"a run cannot be saved in the middle of a cycle"}


def test_broken_run_cannot_be_saved_but_can_go_back() -> None:
    play = _sorting()
    play.interpreter.step()
    saved = play.interpreter.save()
    trip = iter([True])

    def stop(event: Event) -> None:
        if next(trip, False):
            raise KeyboardInterrupt

    play.interpreter.listen(stop)
    with pytest.raises(KeyboardInterrupt):
        play.run()
    with pytest.raises(StateError, match="ended in the middle of a cycle"):
        play.interpreter.save()
    play.interpreter.restore(saved)
    assert play.interpreter.save() == saved
    assert play.run().interpreter.reason == "done"


class _Steel(World):
    """A world that cannot be saved."""

    name = "steel"
    kit = Kit(offer=Offer(primitives={"slow": (1, ("okay", "dropped"))}))

    def now(self) -> Time:
        return 0

    def perform(self, ticket: int, request: Fact) -> None:
        return None

    def next_time(self) -> Time | None:
        return None

    def advance(self, to: Time) -> None:
        return None

    def messages(self) -> Sequence[Message]:
        return ()


def test_unsavable_world_is_named() -> None:
    text = """
    (declare-primitive slow (?x) (okay dropped) :atomic false)
    (define-rap (go) (method (primitive (slow a))))
    """
    parsed = parse(SourceFile("t.rap", text))
    run = Interpreter(Program(link([parsed])[0]), _Steel())
    with pytest.raises(StateError, match="the world `steel` cannot be saved"):
        run.save()
