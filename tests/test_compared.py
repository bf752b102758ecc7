"""The changes of `bench.compared` apply, and the comparison tells faults apart."""

from __future__ import annotations

from pathlib import Path

import pytest

import rapc
from bench.compared import Change, changed_library, outcomes, read_changes
from rapc.library.library import digest

CHANGES = read_changes()
EVERY = (*CHANGES.harmless, *CHANGES.fault)


def test_twenty_harmless_changes_and_twenty_faults_have_names() -> None:
    assert (len(CHANGES.harmless), len(CHANGES.fault)) == (20, 20)
    assert len({one.name for one in EVERY}) == 40
    assert all(one.families for one in CHANGES.fault)
    assert not any(one.families for one in CHANGES.harmless)


@pytest.mark.parametrize("change", EVERY, ids=lambda one: one.name)
def test_change_leaves_a_library_without_errors(change: Change, tmp_path: Path) -> None:
    library = CHANGES.setting[change.setting].library
    before = rapc.load(library)
    after = rapc.load(changed_library(change, library, tmp_path))
    assert digest(before.program.library) != digest(after.program.library)


@pytest.mark.long
@pytest.mark.slow
def test_comparison_of_courier_libraries_names_faults_alone() -> None:
    listed = [one for one in EVERY if one.setting == "courier"]
    found = outcomes(listed, CHANGES.setting["courier"], 30)
    for one in found:
        if one.change.families:
            assert not one.counts or (one.names_family and one.names_file)
        else:
            assert one.verdict.lines == ("no difference in time and successes",)
    assert sum(one.counts for one in found) >= 5
