"""`call_when_waiting`: a host that looks on whenever time is about to pass."""

from __future__ import annotations

import pytest

import rapc
from rapc.world import Time
from rapc.worlds.scripted import ScriptedWorld

LIBRARY = """
(declare-memory-proposition seen (?when))
(define-rap (watch)
  (method
    (task-net
      (t1 (look 5) (for t2))
      (t2 (look 3)))))
(define-rap (look ?time)
  (method
    (task-net
      (t1 (nothing) (window now ?time (+ ?time 1))))))
(define-rap (nothing)
  (succeed true))
"""


def test_timer_is_called_after_pending_messages() -> None:
    run = rapc.loads(LIBRARY).start(ScriptedWorld([]), tasks=["(watch)"])
    seen: list[tuple[Time, bool]] = []
    run.call_at(2, lambda: run.assert_fact("seen", "early"))
    run.call_when_waiting(
        lambda: seen.append((run.now, bool(run.memory.query("seen", None))))
    )
    run.run()
    assert seen == [(0, False), (2, True), (5, True)]


def test_temporary_history_cannot_be_saved() -> None:
    run = rapc.loads(LIBRARY).start(ScriptedWorld([]), tasks=["(watch)"])
    run.call_when_waiting(lambda: None)
    with pytest.raises(rapc.StateError, match="`call_when_waiting`"):
        run.save()
