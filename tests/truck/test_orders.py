"""The main job: an order of four rocks is filled whatever the seed.

Two times 384 runs take some half a minute of processor time: all but the first are
slow, and half of them nightly.
"""

from __future__ import annotations

import pytest

from tests.effort import first

from .runs import FACTORIES, Run, order

LONGEST = 3000
CHUNKS = (range(3), *(range(at, at + 25) for at in range(3, 128, 25)))


@pytest.mark.parametrize("seeds", first(1, CHUNKS, 3), ids=str)
@pytest.mark.parametrize("color", FACTORIES)
def test_an_order_of_four_rocks_is_filled(color: str, seeds: range) -> None:
    for seed in seeds:
        run = Run(order(color), seed=seed)
        assert (run.reason, run.outcomes) == ("done", ["succeeded"]), f"seed {seed}"
        assert run.delivered == {(color, FACTORIES[color]): 4}, f"seed {seed}"
        assert run.interpreter.now <= LONGEST, f"seed {seed}"
        run.assert_honest()


@pytest.mark.parametrize("seeds", first(1, CHUNKS, 3), ids=str)
@pytest.mark.parametrize("color", FACTORIES)
def test_memory_has_each_rock_where_the_world_received_it(
    color: str, seeds: range
) -> None:
    """With names that last, rock by rock: what is believed and the world's own log."""
    for seed in seeds:
        run = Run(order(color), seed=seed, options={"lasting-names": True})
        assert run.delivered == {(color, FACTORIES[color]): 4}, f"seed {seed}"
        run.assert_honest()
        for delivery in run.world.deliveries:
            believed = run.put_down[delivery.item]
            place = run.interpreter.memory.value("location", believed)
            assert place == delivery.factory, f"seed {seed}"
