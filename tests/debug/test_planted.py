"""The planted faults show at the end of the run, beside the sound library."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from tests.debug.planted import FAULTS, LIBRARIES, Fault, told


def test_faults_show_in_five_ways_in_four_libraries() -> None:
    assert set(Counter(fault.shows for fault in FAULTS).values()) == {4}
    assert {fault.library for fault in FAULTS} == {*LIBRARIES}


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS, ids=[fault.name for fault in FAULTS])
def test_fault_shows_at_the_end_of_the_run(
    fault: Fault, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(LIBRARIES["laboratory"])
    fault.plant(tmp_path)
    sound = list(told(fault.run(LIBRARIES[fault.library])))
    assert list(told(fault.run(tmp_path))) != sound
