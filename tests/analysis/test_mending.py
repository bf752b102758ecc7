"""Fixes of damaged texts come to rest, and leave no text worse than before."""

from __future__ import annotations

import pytest

from tests.analysis.mending import run


@pytest.mark.parametrize(
    "count",
    [
        60,
        pytest.param(250, marks=pytest.mark.slow),
        pytest.param(1000, marks=pytest.mark.nightly),
    ],
)
def test_fixes_leave_no_damaged_text_worse(count: int) -> None:
    assert list(run(count)) == []
