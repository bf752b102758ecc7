"""Whatever asks a run is among the questions that are asked at random moments.

What a run, a session and the memory offer is asked for by `tests.debug.asking`, acts or
is said below to need no asking. A new way to ask belongs there: nobody else would see
that it leaves a mark.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from pathlib import Path

import pytest

from rapc.debug.history import History
from rapc.runtime.host_query import HostQuery
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.memory.access import MemoryView
from tests.debug import asking

ACTS: Mapping[str, str] = {
    "Interpreter.achieve": "gives a task",
    "Interpreter.assert_fact": "changes memory",
    "Interpreter.call_at": "has the host called",
    "Interpreter.call_at_end": "has the host called",
    "Interpreter.call_when_waiting": "has the host called",
    "Interpreter.cancel": "ends tasks",
    "Interpreter.come_to_arrival": "runs on",
    "Interpreter.come_to_choice": "runs on",
    "Interpreter.computed": "computes a cost for `:plan`",
    "Interpreter.end": "ends the run",
    "Interpreter.erase": "changes memory",
    "Interpreter.extend": "changes the library",
    "Interpreter.fail_task": "ends a task",
    "Interpreter.interrupt": "ends `run` and `step`",
    "Interpreter.keep_answers": "keeps answers from then on",
    "Interpreter.move": "changes memory",
    "Interpreter.new_context": "makes a part of a run",
    "Interpreter.prepared": "makes a run",
    "Interpreter.read_inputs": "reads inputs before the first cycle: `why` is asked",
    "Interpreter.receive": "takes messages of the world",
    "Interpreter.record": "listens from then on",
    "Interpreter.remade": "makes another run, and only one of the two may go on",
    "Interpreter.recount_running_goals": "counts tasks, after names have changed",
    "Interpreter.restore": "takes up another state",
    "Interpreter.retry_task": "ends a method",
    "Interpreter.tell_tasks": "emits events",
    "Interpreter.run": "runs on",
    "Interpreter.run_host_timers": "calls the host",
    "Interpreter.run_ready": "runs on",
    "Interpreter.send": "sends a request to the world",
    "Interpreter.set_clock": "moves the clock",
    "Interpreter.signal": "tells tasks something",
    "Interpreter.start": "begins the run",
    "Interpreter.submit": "gives a task",
    "Interpreter.sync_clock": "moves the clock",
    "Interpreter.task": "looks up a task",
    "Interpreter.waited_in_vain": "looks at a count",
    "Interpreter.watch_contexts": "listens from then on",
    "Interpreter.world": "names the world that was handed in",
    "History.act": "does something to the run",
    "History.ahead": "runs on and is undone: `what_if` is asked",
    "History.at": "stands in the past for a while: `why` is asked",
    "History.at_choice": "stands in the past for a while: `why` is asked",
    "History.between": "says where it stands",
    "History.branch_off": "begins a branch",
    "History.check_is_run": "says what it is",
    "History.check_knows_truth": "says what it is",
    "History.knows_truth": "says what it is",
    "History.follow": "listens from then on",
    "History.is_run": "says what it is",
    "History.goto_time": "goes to a cycle, as `goto` does",
    "History.last": "reads `scan`, which is asked",
    "History.open": "begins a run",
    "History.pause": "stops the run",
    "History.paused": "says what it is",
    "History.reach": "runs on",
    "History.seek": "goes to a cycle, as `goto` does",
    "History.step": "runs on",
    "History.switch": "goes on in another branch",
    "History.take_up": "changes the library",
    "History.wait": "runs on",
}
"""What a host or user does to a run and its session, and what it comes to."""

DOORS = (Interpreter, History, MemoryView, HostQuery)


def _named() -> set[str]:
    """Return the attributes that the questions name."""
    text = Path(asking.__file__).read_text(encoding="utf-8")
    return {n.attr for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Attribute)}


def _offered(door: type) -> set[str]:
    return {name for name in dir(door) if not name.startswith("_")}


@pytest.mark.parametrize("door", DOORS, ids=lambda door: str(door.__name__))
def test_all_questions_are_asked_at_random_moments(door: type) -> None:
    acts = {one.partition(".")[2] for one in ACTS if one.startswith(door.__name__)}
    assert acts <= _offered(door)
    assert _offered(door) - acts - _named() == set()
