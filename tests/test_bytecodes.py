"""What a firing and a task take, counted: the alarm for what makes all runs slower."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable

import pytest

from bench import bytecodes
from tests.work import lines

pytestmark = pytest.mark.skipif(
    sys.version_info[:2] != (3, 11), reason="other versions have other bytecodes"
)


@pytest.mark.parametrize("count", [bytecodes.count, lines])
def test_collections_of_garbage_are_not_counted(
    count: Callable[[Callable[[], object]], int],
) -> None:
    """Hypothesis, for one, has Python code run before and after each collection."""

    def work() -> object:
        return [[number] for number in range(5000)]

    def collected(phase: str, info: object) -> None:
        """Carry out a few bytecodes."""

    alone = count(work)
    gc.callbacks.append(collected)
    try:
        assert count(work) == alone
    finally:
        gc.callbacks.remove(collected)


def test_firing_takes_no_more_bytecodes_than_its_bar() -> None:
    assert bytecodes.firing(monitors=100, times=20) <= 2_171


def test_task_takes_no_more_bytecodes_than_its_bar() -> None:
    assert bytecodes.task(depth=5) <= 1_048


@pytest.mark.slow
def test_cycle_of_the_truck_takes_no_more_bytecodes_than_its_bar() -> None:
    assert bytecodes.cycle() <= 2_800
