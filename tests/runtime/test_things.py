"""Things that tasks hold and wait for, where a library's own test cannot look."""

from __future__ import annotations

import pytest

from rapc.events import (
    Deadlock,
    RunEnded,
    TaskBlocked,
    TaskWoken,
)
from rapc.runtime.tasks.rename_items import rename
from tests.effort import first
from tests.runtime.helpers import Play, at, row
from tests.runtime.porter import Shift, without_claims

BODY = """
(declare-primitive go (?where) (okay) :atomic false :uses (wheels))
(declare-primitive grip (?arm) (okay) :atomic false :uses ((arm ?arm)))
(define-rap (drive ?where) (method (primitive (go ?where))))
(define-rap (hold ?arm) (method (primitive (grip ?arm))))
(define-rap (pause) (method (primitive (slow it))))
(define-rap (one)
  (method (claims wheels) (task-net (t1 (pause) (for t2)) (t2 (hold left)))))
(define-rap (two)
  (method (claims (arm left)) (task-net (t1 (pause) (for t2)) (t2 (drive lab)))))
(define-rap (p-never) (monitor-state (p never)) (method (primitive (act a))))
(define-rap (grip-when ?arm) (monitor-state (p free))
  (method (primitive (grip ?arm))))
"""

ROWS = [row("(go ?)", after=5), row("(grip ?)", after=3)]


def _waiting(ran: Play) -> tuple[str, ...]:
    """What a run said of those who were left over."""
    over = ran.events[-1]
    assert isinstance(over, RunEnded)
    return over.waiting


def test_waits_between_tasks_are_reported() -> None:
    ran = Play(BODY, "(drive lab) :priority 1", "(drive hall)", rows=ROWS)
    ran.run(until=2)
    assert _waiting(ran) == (
        "(drive lab) [1] waits for (go lab)",
        "(drive hall) [2] waits for wheels, held by (drive lab) [1]",
    )


def test_the_agenda_says_it_too() -> None:
    ran = Play(BODY, "(drive lab) :priority 1", "(drive hall)", rows=ROWS)
    ran.interpreter.run_ready()
    waits = [(one.state, one.waits_for) for one in ran.interpreter.agenda()]
    assert waits == [
        ("running", "(go lab)"),
        ("blocked", "wheels, held by (drive lab) [1]"),
    ]


def test_deadlock_is_named_at_any_end_of_the_run() -> None:
    for last, reason in ("(hold right)", "done"), ("(p-never)", "stuck"):
        ran = Play(
            BODY,
            "(one) :background true",
            "(two) :background true",
            last,
            rows=ROWS,
        ).run()
        assert ran.interpreter.reason == reason
        line, *others = _waiting(ran)
        assert line == (
            "deadlock: (hold left) [5] waits for (arm left), held by (two) [2]; "
            "(drive lab) [7] waits for wheels, held by (one) [1]"
        )
        assert not [one for one in others if "deadlock" in one]


def test_deadlock_is_reported_when_it_closes() -> None:
    ran = Play(BODY, "(one)", "(two)", "(drive hall) :at 3", rows=ROWS).run()
    [told] = ran.of(Deadlock)
    assert (told.time, told.tasks) == (1, (4, 6))
    assert told.waiting == (
        "(hold left) [4] waits for (arm left), held by (two) [2]",
        "(drive lab) [6] waits for wheels, held by (one) [1]",
    )
    before = ran.events[ran.events.index(told) - 1]
    assert isinstance(before, TaskBlocked)
    assert before.task == 4


def test_deadlock_closed_by_a_merge_is_reported() -> None:
    """What one task holds and what another waits for turn out to be one arm."""
    text = (
        BODY
        + """
    (define-rap (left) (method (claims (arm item-1))
      (task-net (t1 (pause) (for t2)) (t2 (hold item-3)))))
    (define-rap (right) (method (claims (arm item-2))
      (task-net (t1 (pause) (for t2)) (t2 (hold item-1)))))
    (define-rap (other) (method (claims (arm item-3))
      (task-net (t1 (p-never)))))
    """
    )
    ran = Play(text, "(left)", "(right)", "(other)", rows=ROWS)
    run = ran.interpreter
    ran.interpreter.call_at(3, lambda: rename(run, "item-3", "item-2"))
    ran.run()
    [told] = ran.of(Deadlock)
    assert (told.time, told.tasks) == (3, (5, 7))


def test_task_waiting_for_a_running_task_is_in_no_deadlock() -> None:
    ran = Play(BODY, "(one)", "(drive hall)", rows=ROWS).run(until=2)
    assert not [line for line in _waiting(ran) if "deadlock" in line]
    assert ran.of(Deadlock) == []


def test_run_continues_unchanged_after_a_save_at_any_point() -> None:
    def play() -> Play:
        return Play(
            BODY,
            "(one)",
            "(drive lab) :priority 2 :at 1",
            "(drive hall) :at 1",
            "(grip-when left) :priority -1",
            "(grip-when left) :priority 3 :at 2",
            rows=ROWS,
            times=[at(1, "(p free)")],
        )

    whole = play().run()
    assert whole.told("suspended") != []
    for cycles in range(1, 20):
        begun, other = play(), play()
        for _ in range(cycles):
            begun.interpreter.step()
        known = len(begun.events)
        other.interpreter.restore(begun.interpreter.save())
        other.events.clear()
        other.run()
        assert other.events == whole.events[known:], cycles


RETRY = """
(define-rap (either)
  (method act (primitive (act a)))
  (method grip (context (or (method-tried act) (method-tried grip)))
    (primitive (grip left))))
"""


def test_undone_method_counts_as_not_tried() -> None:
    def play() -> Play:
        rows = [row("(act a)", "dropped"), *ROWS]
        tasks = "(either)", "(grip-when left) :priority 3 :at 1"
        return Play(BODY + RETRY, *tasks, rows=rows, times=[at(1, "(p free)")])

    def tried(ran: Play) -> tuple[object, ...]:
        task = ran.interpreter.state.live_top[1].task
        grip = task.plan.methods[1]
        return task.method, task.has_tried("grip"), task.times_tried(grip), task.choices

    def suspend(ran: Play) -> None:
        while not ran.told("suspended"):
            ran.interpreter.step()

    whole = play()
    act = whole.interpreter.library.known_rap("either").methods[0]
    suspend(whole)
    assert tried(whole) == (act, False, 0, 1)
    begun, other = play(), play()
    begun.interpreter.step()
    begun.interpreter.step()
    assert begun.interpreter.agenda()[0].waits_for == "(grip left)"
    other.interpreter.restore(begun.interpreter.save())
    suspend(other)
    assert tried(other)[1:] == (False, 0, 1)


@pytest.mark.parametrize("part", first(1, range(5)))
def test_two_standing_tasks_and_three_orders_share_one_body(part: int) -> None:
    """Nobody is driven away from a task that claims the wheels, whatever the seed."""
    suspended = 0
    for seed in range(200)[part::5]:
        shift = Shift(seed)
        results = [r.outcome for r in shift.run.results() if not r.background]
        assert (shift.reason, results) == ("done", ["succeeded"] * 3), seed
        assert shift.moved_from_under() == 0, seed
        assert shift.world.failed == 0, seed
        assert shift.never_resumed() == [], seed
        suspended += len(shift.suspended())
    assert suspended > 40


@pytest.mark.parametrize("seeds", first(1, [8, 40]))
def test_without_its_claims_the_same_library_fails(seeds: int) -> None:
    shifts = [Shift(seed, without_claims()) for seed in range(seeds)]
    assert sum(shift.moved_from_under() > 0 for shift in shifts) > 3 * seeds / 4
    assert sum(shift.world.failed for shift in shifts) > 0


def test_things_follow_their_items() -> None:
    """The right arm turns out to be the left one: who waits for it waits for both."""
    rows = [row("(grip left)", after=9), row("(grip right)", after=3)]
    tasks = ("(hold left) :priority 1", "(hold right) :priority 1", "(hold right)")
    ran = Play(BODY, *tasks, rows=rows)
    ran.interpreter.run_ready()
    assert ran.interpreter.agenda()[2].waits_for.startswith("(arm right), held by")
    rename(ran.interpreter, "right", "left")
    waits = ran.interpreter.agenda()[2].waits_for
    assert waits == "(arm left), held by (hold left) [1]"
    ran.run()
    assert [e.time for e in ran.of(TaskWoken)] == [9]
