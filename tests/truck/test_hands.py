"""Whatever is snatched away or breaks in: no arm keeps what it holds, or stays outside.

The world is as hard as the experiments make it: everything is moved every eight time
units, and troops come all the time.
"""

from __future__ import annotations

import pytest

from rapc import events
from rapc.worlds.truck.state import ARMS
from tests.effort import first

from .runs import PLENTY, STDLIB, Run, library, order, task

HARD = {
    **PLENTY,
    "shuffle-interval": 8,
    "shuffle-efficiency": 60,
    "enemy-interval": 80,
    "capture-time": 0,
}


class HandsWatched(Run):
    """A run that notes the longest time for which an arm held one thing.

    `refused` counts trips that the world refused.
    """

    longest: float = 0
    refused: int = 0

    def _note(self, event: events.Event) -> None:
        super()._note(event)
        if not isinstance(event, events.PrimitiveEnded):
            return
        since = self.__dict__.setdefault("since", {})
        items = self.world.state.items.values()
        held = {(i.place, i.name) for i in items if i.place in ARMS}
        for gone in since.keys() - held:
            self.longest = max(self.longest, event.time - since.pop(gone))
        for each in held:
            since.setdefault(each, event.time)
        self.refused += event.result == "truck-cant-move"


@pytest.mark.parametrize("seed", first(2, range(10)))
def test_arms_let_go_and_come_in(seed: int) -> None:
    run = HandsWatched(
        task("watch-surroundings", priority=8, background=True),
        task("handle-enemy-troops", priority=6, background=True),
        task("watch-fuel", priority=4, background=True),
        task("ready-weapon", priority=3),
        order("red", 3),
        order("blue", 3),
        seed=seed,
        options=HARD,
        compiled=library(STDLIB / "truck"),
    )
    assert run.reason == "done"
    assert run.answers["arm-move", "arm-cant-find"] > 0, "something was snatched away"
    assert 0 < run.longest < 200
    assert run.refused == 0
    run.assert_honest()
