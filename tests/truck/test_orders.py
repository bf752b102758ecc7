"""The main job: an order of four rocks is filled whatever the seed.

Each of the two times 600 runs takes some 15 seconds of processor time.
"""

from __future__ import annotations

import pytest

from .runs import FACTORIES, Run, order

LONGEST = 3000
CHUNK = 25


@pytest.mark.parametrize("first", range(0, 200, CHUNK))
@pytest.mark.parametrize("color", FACTORIES)
def test_an_order_of_four_rocks_is_filled(color: str, first: int) -> None:
    for seed in range(first, first + CHUNK):
        run = Run(order(color), seed=seed)
        assert (run.reason, run.outcomes) == ("done", ["succeeded"]), f"seed {seed}"
        assert run.delivered == {(color, FACTORIES[color]): 4}, f"seed {seed}"
        assert run.interpreter.now <= LONGEST, f"seed {seed}"
        run.assert_honest()


@pytest.mark.parametrize("first", range(0, 200, CHUNK))
@pytest.mark.parametrize("color", FACTORIES)
def test_memory_has_each_rock_where_the_world_received_it(
    color: str, first: int
) -> None:
    """With names that last, rock by rock: what is believed and the world's own log."""
    for seed in range(first, first + CHUNK):
        run = Run(order(color), seed=seed, options={"lasting-names": True})
        assert run.delivered == {(color, FACTORIES[color]): 4}, f"seed {seed}"
        run.assert_honest()
        for delivery in run.world.deliveries:
            believed = run.put_down[delivery.item]
            place = run.interpreter.memory.value("location", believed)
            assert place == delivery.factory, f"seed {seed}"
