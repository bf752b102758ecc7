"""Sessions for tests: a small library in a scripted world, and the truck."""

from __future__ import annotations

import rapc
from rapc.debug.history import History
from rapc.runtime.task_request import TaskRequest
from rapc.world import Time
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

TRUCK = "examples/rock-order.rap"


def truck(*tasks: str, seed: int = 7, **more: object) -> History:
    """Return a session with the truck, which is given some tasks."""
    library = rapc.load(TRUCK)
    return History.open(
        library, "truck", tasks=tasks or ["(rock-order red 1)"], seed=seed, **more
    )


def scripted(
    text: str, *tasks: str | TaskRequest, rows: tuple[Row, ...] = (), seed: int = 0
) -> History:
    """Return a session with a library given as text, in a scripted world."""
    library = rapc.loads(text, "small.rap")
    world = ScriptedWorld(list(rows), declared=library.program.library)
    return History.open(library, world, tasks=tasks, seed=seed)


def row(request: str, result: str = "okay", takes: Time = 1, **more: object) -> Row:
    """Return a row of a script."""
    pattern = tuple(request.strip("()").split())
    return Row(pattern=pattern, result=result, takes=takes, **more)  # type: ignore[arg-type]
