"""Programs that the grammar makes, whole and damaged, break nothing."""

from __future__ import annotations

import pytest

from tests.analysis.fuzz import run


@pytest.mark.parametrize(
    "count",
    [
        10,
        pytest.param(200, marks=pytest.mark.slow),
        pytest.param(800, marks=pytest.mark.nightly),
    ],
)
def test_no_program_breaks_a_promise(count: int) -> None:
    assert list(run(count)) == []
