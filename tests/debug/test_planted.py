"""An exported test finds each planted fault, and passes with the sound library."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

import pytest

from tests.cli.command import rapc
from tests.debug.planted import FAULTS, LIBRARIES, WORLDS, Fault


def test_faults_show_in_five_ways_in_four_libraries() -> None:
    assert set(Counter(fault.shows for fault in FAULTS).values()) == {4}
    assert {fault.library for fault in FAULTS} == {*LIBRARIES}


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS, ids=[fault.name for fault in FAULTS])
def test_exported_test_fails_with_the_fault_alone(
    fault: Fault, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(LIBRARIES["laboratory"])
    monkeypatch.setenv("PYTHONPATH", os.fspath(LIBRARIES["laboratory"]))
    fault.plant(tmp_path)
    until = fault.by or fault.until
    given = [task for task in fault.run(tmp_path).tasks if not task.background]
    late = [t for t in given if t.ended is None or t.ended > until]
    failed = [task for task in given if task.outcome == "failed"]
    task = (failed or late or given)[-1].task
    world = WORLDS.get(fault.library, fault.library)
    options = [f"--set={fault.library}.{k}={v}" for k, v in fault.options.items()]
    options += [f"--world={world}", f"--agenda={fault.agenda}", f"--seed={fault.seed}"]
    export = f":export-test regression.test.rap {task} succeeds"
    inputs = ("-c", ":show none", "-c", ":run", "-c", export)
    told = rapc("repl", ".", *options, f"--until={until}", *inputs, cwd=tmp_path)
    assert "the test fails now" in told.stdout
    test = ["test", "regression.test.rap", "--world-module=laboratory"]
    assert rapc(*test, cwd=tmp_path).returncode == 1
    file = tmp_path / fault.file
    file.write_bytes((LIBRARIES[fault.library] / fault.file).read_bytes())
    assert rapc(*test, cwd=tmp_path).returncode == 0
