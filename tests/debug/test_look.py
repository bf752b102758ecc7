"""What the debugger lists of a run as it stands."""

from __future__ import annotations

import rapc
from rapc.debug.history import History
from rapc.debug.questions.state import requests
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
    [asked] = requests(History(run)).rows
    assert (asked["task"], asked["request"]) == (1, "(doze)")
    run.cancel(("rest",))
    assert requests(History(run)).rows == []
