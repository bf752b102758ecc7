"""Runs: submissions, how a run ends, and its trace [L 4] (docs/reference/tests.md)."""

from __future__ import annotations

import io
import json
from typing import Any

import pytest

from rapc import events
from rapc.errors import RefusedError
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import read_task_request
from rapc.worlds.scripted import ScriptedWorld

from .helpers import Play, at, fact, play, row

USE = "(define-rap (use ?x) (method (primitive (act ?x))))"
GUARD = """
(define-rap (guard) (monitor-state (p ?x)) (succeed nil)
  (method (context (p ?x)) (primitive (act ?x))))
"""


# --- submissions -------------------------------------------------------------------


def test_a_task_may_be_given_for_later() -> None:
    ran = play(USE, "(use a) :at 7", "(use b) :at 3.5")
    assert ran.told("created", "asked", times=True) == [
        "3.5 created (use b)",
        "3.5 asked (act b)",
        "7 created (use a)",
        "7 asked (act a)",
    ]


def test_a_task_may_be_given_while_the_run_goes_on() -> None:
    ran = Play(USE, "(use a)")
    ran.interpreter.step()
    ran.interpreter.submit(read_task_request("(use b) :priority 3"))
    ran.run()
    assert ran.told("asked") == ["asked (act a)", "asked (act b)"]
    assert [r.outcome for r in ran.interpreter.results()] == ["succeeded"] * 2


def test_a_task_given_in_the_past_is_given_now() -> None:
    ran = Play(USE, "(use a)", rows=[row("(act a)", takes=9)])
    ran.interpreter.step()
    ran.interpreter.submit(read_task_request("(use b) :at 4"))
    ran.run()
    assert ran.told("created", times=True)[-1] == "9 created (use b)"


@pytest.mark.parametrize(
    ("task", "words"),
    [("(fly)", "unknown RAP"), ("(use)", "1 input"), ("(use a b)", "not 2")],
)
def test_task_without_rap_is_refused(task: str, words: str) -> None:
    with pytest.raises(RefusedError, match=words):
        Play(USE, task)


def test_a_background_task_does_not_keep_the_run_going() -> None:
    ran = play(USE + GUARD, "(guard) :background true", "(use a)")
    assert ran.told("removed", "over") == ["removed guard run-over", "over done"]
    ran = play(USE + GUARD, "(guard) :background true :at 50", "(use a)")
    assert ran.told("created", "over", times=True) == [
        "0 created (use a)",
        "0 over done",
    ]


# --- the end of a run --------------------------------------------------------------


def test_done_when_no_task_is_left() -> None:
    ran = play(USE, "(use a)")
    (end,) = ran.of(events.RunEnded)
    assert end == ran.events[-1]
    assert (end.reason, [r.outcome for r in end.results]) == ("done", ["succeeded"])


def test_stuck_when_nothing_can_become_eligible() -> None:
    ran = play(GUARD, "(guard)", times=[at(3, "(q a b)")])
    assert ran.told("removed", "over", times=True) == [
        "3 removed guard run-over",
        "3 over stuck",
    ]
    (end,) = ran.of(events.RunEnded)
    assert end.results[0].outcome == "unfinished"
    assert "guard" in end.waiting[0]


def test_messages_due_at_the_end_are_processed() -> None:
    text = USE + "(define-rap (top) (method (task-net (t1 (use b) (window now 5 9)))))"
    ran = Play(text, "(top)", "(use c) :at 6").run(until=5)
    assert ran.told("asked", times=True) == ["5 asked (act b)"]
    assert ran.told("over", times=True) == ["5 over until"]
    assert [r.outcome for r in ran.interpreter.results()] == ["succeeded"]


def test_an_unfinished_task_stays_so_in_the_results_after_the_end() -> None:
    """Even if a method of it has ended well, or badly."""
    ran = play(
        """
        (define-rap (top ?x) (monitor-state (not (stop))) (succeed nil)
          (method (primitive (act ?x))))
        """,
        "(top a)",
        "(top b)",
        rows=[row("(act a)", asserts=["(stop)"]), row("(act b)", "jammed")],
    )
    assert ran.interpreter.reason == "stuck"
    results = ran.interpreter.results()
    assert [(r.outcome, r.result) for r in results] == [("unfinished", None)] * 2
    assert ran.of(events.RunEnded)[0].results == results


@pytest.mark.parametrize(
    ("cycles", "reason"), [(1, "cycles"), (2, "done"), (9, "done")]
)
def test_a_run_of_so_many_cycles(cycles: int, reason: str) -> None:
    ran = Play(USE, "(use a)").run(cycles=cycles)
    assert ran.interpreter.reason == reason
    assert len(ran.told("selected")) == min(cycles, 2)


def test_a_runaway_is_called_off_and_named() -> None:
    ran = play(
        """
        (define-rap (top) (resources (counter ?c)) (succeed nil)
          (method (task-net (t1 (rest) (counter-add ?c 1)))))
        (define-rap (rest) (method (task-net)))
        """,
        "(top)",
        settings=Settings(idle_cycles=50),
    )
    (end,) = ran.of(events.RunEnded)
    assert (end.reason, end.cycle) == ("runaway", 51)
    assert any("(top)" in line or "(rest)" in line for line in end.waiting)


def test_moving_clock_is_not_a_runaway() -> None:
    ran = Play(
        "(define-rap (tick) (monitor-time now 1 2) (succeed nil) (method (task-net)))",
        "(tick)",
        settings=Settings(idle_cycles=5),
    ).run(until=100)
    assert ran.interpreter.reason == "until"


def test_a_cancelled_run() -> None:
    ran = Play(USE, "(use a)")
    ran.interpreter.step()
    ran.interpreter.end("cancelled")
    assert ran.told("removed", "over") == ["removed use run-over", "over cancelled"]
    assert ran.interpreter.step() is False


def test_a_cancelled_task_leaves_with_all_it_spawned() -> None:
    text = USE + "(define-rap (top ?x) (method (task-net (t1 (idle)) (t2 (idle)))))"
    text += "(define-rap (idle) (monitor-state (go)) (method (task-net)))"
    ran = Play(text, "(top a)", "(top b)", "(use c) :at 5")
    for _ in range(2):
        ran.interpreter.step()
    assert ran.interpreter.cancel(fact("(top a)")) == 1
    assert ran.interpreter.cancel(fact("(top ?)")) == 1
    assert ran.interpreter.cancel(fact("(top ?)")) == 0
    ran.run()
    assert ran.told("removed", "over") == [
        *["removed idle parent-removed"] * 2,
        "removed top cancelled",
        *["removed idle parent-removed"] * 2,
        "removed top cancelled",
        "over done",
    ]
    outcomes = [r.outcome for r in ran.interpreter.results()]
    assert outcomes == ["cancelled", "cancelled", "succeeded"]


def test_the_world_may_end_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    why: list[str] = []
    monkeypatch.setattr(
        ScriptedWorld, "ended", lambda _: why[0] if why else None, raising=False
    )
    ran = Play(USE, "(use a)", "(use b)")
    ran.interpreter.step()
    why.append("out of fuel")
    ran.run()
    assert ran.told("over") == ["over world"]
    assert len(ran.told("asked")) == 1


def test_cost_of_a_cycle_moves_the_clock() -> None:
    ran = play(USE, "(use a)", settings=Settings(cycle_cost=0.5))
    assert ran.told("selected", "over", times=True) == [
        "0 selected use",
        "0.5 selected use",
        "1 over done",
    ]


# --- the trace ---------------------------------------------------------------------

TWO = """
(define-rap (top ?x)
  (method one (task-net (t1 (use ?x)) (t2 (use y))))
  (method two (task-net (t1 (use y)) (t2 (use ?x)))))
"""


def trace(seed: int) -> str:
    """The JSON Lines of a run in which chance decides."""
    stream = io.StringIO()
    ran = Play(USE + TWO, "(top a)", "(top b)", seed=seed)
    ran.interpreter.listen(JsonTrace(stream))
    ran.run()
    return stream.getvalue()


def test_one_seed_one_trace_and_other_seeds_others() -> None:
    traces = {seed: trace(seed) for seed in range(12)}
    assert all(trace(seed) == text for seed, text in traces.items())
    assert len(set(traces.values())) > 6


def test_every_event_has_its_serial_and_times_never_go_back() -> None:
    ran = play(USE + TWO, "(top a)", "(top b) :at 5", rows=[row("(act ?)", takes=2)])
    assert [event.n for event in ran.events] == list(range(len(ran.events)))
    for key in ("time", "cycle"):
        stamps = [getattr(event, key) for event in ran.events]
        assert stamps == sorted(stamps)


def test_bindings_stand_in_the_json_in_their_order() -> None:
    stream = io.StringIO()
    ran = Play(
        "(define-rap (top ?z ?a) (method (context (q ?y ?b)) (task-net)))",
        "(top 1 2)",
        facts=["(q 3 4)"],
    )
    ran.interpreter.listen(JsonTrace(stream))
    ran.run()
    lines: list[dict[str, Any]] = list(map(json.loads, stream.getvalue().splitlines()))
    (chosen,) = (line for line in lines if line["event"] == "method-chosen")
    assert list(chosen["bindings"]) == ["?z", "?a", "?y", "?b"]


def test_run_is_equal_with_and_without_listeners() -> None:
    ran = play(USE + TWO, "(top a)", "(top b)", seed=5)
    silent = Play(USE + TWO, "(top a)", "(top b)", seed=5)
    silent.interpreter.recorder.on = False
    silent.run()
    one, other = ran.interpreter.results(), silent.interpreter.results()
    assert [(r.outcome, r.goal) for r in one] == [(r.outcome, r.goal) for r in other]
    assert silent.interpreter.recorder.cycle == ran.events[-1].cycle


def test_recording_has_the_events_of_a_listener() -> None:
    text = "(define-rap (top ?z) (resources (counter ?c)) (method (task-net"
    text += " (a (use ?z) (counter-add ?c 2) (for b)) (b (use (value ?c))))))"
    ran = Play(USE + text, "(top a)")
    ran.interpreter.step()
    recording = ran.interpreter.record()
    heard: list[events.Event] = []
    ran.interpreter.listen(heard.append)
    ran.run()
    assert len(recording) == len(heard) > 10
    assert list(recording) == heard
    assert list(recording) == ran.events[-len(heard) :]


def test_listeners_receive_only_the_event_kinds_they_subscribe_to() -> None:
    early: list[events.Event] = []
    late: list[events.Event] = []
    everything: list[events.Event] = []
    ran = Play(USE + TWO, "(top a)", "(top b)")
    listen = ran.interpreter.listen
    listen(early.append, events.MethodChosen, events.RunEnded)
    listen(everything.append)
    listen(late.append, events.RunEnded)
    ran.run()
    wanted = (events.MethodChosen, events.RunEnded)
    assert everything == ran.events[-len(everything) :]
    assert early == [event for event in everything if isinstance(event, wanted)]
    assert late == everything[-1:]
    assert len(early) > len(late)


def test_numbers_of_tasks_follow_the_order_of_creation() -> None:
    ran = play(USE + TWO, "(top a)", "(top b)")
    assert [e.task for e in ran.of(events.TaskCreated)] == list(range(1, 7))


def _why(text: str, *tasks: str, idle: int = 500) -> str | None:
    ran = play(text, *tasks, settings=Settings(idle_cycles=idle))
    (end,) = ran.of(events.RunEnded)
    assert end.reason == "runaway"
    because: str | None = end.because
    return because


def test_endlessly_choosing_task_is_named() -> None:
    text = """
    (define-rap (top) (resources (counter ?c)) (succeed nil)
      (method (task-net (t1 (rest) (counter-add ?c 1)))))
    (define-rap (rest) (method (task-net)))
    """
    assert _why(text, "(top)") == "(top) [1] has chosen a method 167 times"


def test_a_descent_without_end_is_named() -> None:
    text = "(define-rap (down ?n) (method (task-net (t1 (down (+ ?n 1))))))"
    assert _why(text, "(down 0)") == "501 tasks of `down` are under way at once"


def test_endlessly_failing_family_is_named() -> None:
    raps = [
        f"(define-rap (try-{n}) (method (task-net (t1 (try-{n + 1}))))"
        f" (method (task-net (t1 (try-{n + 1})))))"
        for n in range(12)
    ]
    text = "\n".join(
        [*raps, "(define-rap (try-12) (method (context (p a)) (task-net)))"]
    )
    assert _why(text, "(try-0)", idle=2000) == "all for (try-0) [1]"


def test_constraints_above_are_asked_anew_only_after_a_change() -> None:
    """An endless descent does not look at all that is above at each of its steps."""
    text = """
    (declare-memory-function free (?n) :reads (p))
    (define-rap (down ?n) (constraints (and (not (p a)) (free ?n)))
      (method (context (< ?n 40)) (task-net (t1 (down (+ ?n 1)))))
      (method (context (= ?n 40)) (primitive (act a))))
    """
    asked: list[int] = []

    def free(_: object, n: int) -> bool:
        asked.append(n)
        return True

    changed = [row("(act a)", asserts=["(q a b)"])]
    for until in (None, 100):
        asked.clear()
        ran = Play(text, "(down 0)", rows=changed, functions={"free": free})
        ran.run(until=until)
        assert ran.interpreter.reason == "done"
        # once in the descent; then after the change by the chain that comes up again
        assert asked[:41] == list(range(41))
        assert len(asked) < 41 * 4


def test_history_queries_in_constraints_are_evaluated_each_time() -> None:
    """Nothing in memory has changed when the method has failed; its task fails too."""
    text = """
    (define-rap (top) (constraints (not (last-result dropped)))
      (method (task-net (t1 (one)))))
    (define-rap (one) (method (primitive (act a))))
    """
    ran = play(text, "(top)", rows=[row("(act a)", "dropped")])
    assert ran.told("failed") == [
        "failed (one) futile-loop dropped",
        "failed (top) interference dropped",
    ]
