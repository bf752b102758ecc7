"""What a firing and a task take, counted: the alarm for what makes all runs slower."""

from __future__ import annotations

import sys

import pytest

from bench import bytecodes

pytestmark = pytest.mark.skipif(
    sys.version_info[:2] != (3, 11), reason="other versions have other bytecodes"
)


def test_firing_takes_no_more_bytecodes_than_its_bar() -> None:
    assert bytecodes.firing(monitors=100, times=20) <= 2_171


def test_task_takes_no_more_bytecodes_than_its_bar() -> None:
    assert bytecodes.task(depth=5) <= 1_048


@pytest.mark.slow
def test_cycle_of_the_truck_takes_no_more_bytecodes_than_its_bar() -> None:
    assert bytecodes.cycle() <= 2_800
