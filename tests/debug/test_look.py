"""What the debugger lists of a run as it stands."""

from __future__ import annotations

import rapc
from rapc.debug import look
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld


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
    assert [(one.task, one.request) for one in look.requests(run)] == [(1, "(doze)")]
    run.cancel(("rest",))
    assert look.requests(run) == []
