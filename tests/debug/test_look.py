"""What the debugger lists of a run as it stands."""

from __future__ import annotations

import rapc
from rapc.debug.history import History
from rapc.debug.questions.state import requests
from rapc.debug.questions.tasks import agenda
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld
from tests.debug.sessions import scripted


def test_cancelled_request_is_not_under_way() -> None:
    library = rapc.loads(
        """
        (declare-primitive doze () (okay) :atomic false)
        (define-rap (rest) (method (primitive (doze))))
        """
    )
    world = ScriptedWorld([Row(("doze",), after=9)], declared=library.program.library)
    run = library.start(world, tasks="(rest)")
    run.step()
    [asked] = requests(History(run)).rows
    assert (asked["task"], asked["request"]) == (1, "(doze)")
    run.cancel(("rest",))
    assert requests(History(run)).rows == []


def test_agenda_lists_the_monitor_of_a_task_that_was_never_tested() -> None:
    text = """
    (declare-memory-proposition ready (?who))
    (define-rap (top) (method (task-net (t1 (rest) (for t2)) (t2 (hear me)))))
    (define-rap (rest) (succeed true))
    (define-rap (hear ?who) (monitor-state (ready ?who)) (succeed (ready ?who)))
    """
    session = scripted(text, "(top)")
    session.step(2)
    entries = {one["goal"]: one for one in agenda(session).rows}
    assert entries["(hear me)"]["state"] == "waiting"
    assert entries["(hear me)"]["waits for"] == "(ready me)"
