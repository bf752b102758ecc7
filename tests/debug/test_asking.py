"""Whoever asks the debugger changes nothing, between two cycles or within one."""

from __future__ import annotations

import pytest

from tests.debug import asking, moments
from tests.effort import first


@pytest.mark.parametrize(
    "asked",
    first(1, [("courier", 90, 12), *((name, 300, 25) for name in moments.RUNS)]),
    ids=str,
)
def test_questions_at_random_moments_leave_no_trace(
    asked: tuple[str, int, int],
) -> None:
    name, cycles, points = asked
    found = asking.check(moments.RUNS[name], cycles, points)
    assert found.changed == []
    assert found.same
    assert len(found.answered) > len(asking.QUESTIONS) // 2
