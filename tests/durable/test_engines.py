"""Runs with a journal whose plans come from an engine."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest

import rapc
from rapc import events
from rapc.durable.runs import DurableRun, begin, resume
from rapc.errors import StateError
from tests.cli.command import rapc as command

ROOT = Path(__file__).parents[2]
FAKE = ROOT / "tests" / "planning" / "fake_engine.py"
GOAL = "(and (delivered medicine ward-3) (docked))"


@pytest.fixture
def library(tmp_path: Path) -> rapc.CheckedLibrary:
    """Return the courier with a task that is planned."""
    courier = os.path.relpath(ROOT / "examples" / "courier", tmp_path)
    file = tmp_path / "evening.rap"
    file.write_text(
        f'(require "{courier}") (define-rap (evening) (succeed {GOAL}) (plan))'
    )
    return rapc.load(file)


def _engine(deed: str) -> rapc.Engine:
    words = [sys.executable, str(FAKE), deed]
    found = rapc.engine(f"{shlex.join(words)} {{domain}} {{problem}} {{plan}}", 60)
    assert found is not None
    return found


def _begun(folder: Path, library: rapc.CheckedLibrary, engine: Any) -> None:
    """Begin a run that ends before its first plan."""
    run = library.start("courier", tasks=["(evening)"], engine=engine, begin=False)
    begin(folder, run, trace=folder.with_suffix(".jsonl")).close()


def _planner(durable: DurableRun) -> tuple[str, str]:
    """Run to the end; return the engine of the plan, and why one was not used."""
    found: list[events.PlanMade] = []
    durable.run.listen(
        lambda event: (
            found.append(event) if isinstance(event, events.PlanMade) else None
        )
    )
    durable.go()
    durable.close()
    return found[0].engine, found[0].refused


@pytest.mark.parametrize("deed", ["solve", "fail"])
def test_resumed_run_asks_the_same_engine(
    tmp_path: Path, library: rapc.CheckedLibrary, deed: str
) -> None:
    folder, engine = tmp_path / "j", _engine(deed)
    _begun(folder, library, engine)
    durable = resume(folder, library.program, rapc.open_world("courier"))
    asked, refused = _planner(durable)
    failed = deed == "fail"
    assert asked == ("builtin" if failed else engine.name)
    assert refused == ("engine-failed: no plan, status 3" if failed else "")
    assert (
        f"engine    {engine.name}\n" in command("journal", "info", str(folder)).stdout
    )


def test_resume_command_asks_the_same_engine(
    tmp_path: Path, library: rapc.CheckedLibrary
) -> None:
    folder, engine = tmp_path / "j", _engine("solve")
    _begun(folder, library, engine)
    done = command("run", "--resume", str(folder), "-q")
    assert done.returncode == 0, done.stderr
    assert shlex.quote(str(FAKE)) in folder.with_suffix(".jsonl").read_text()


class Idle:
    """An engine that `rapc.engine` does not make."""

    name = "idle"

    def ask(self, problem: object) -> str:
        return "idle: no plan"


def test_engine_of_a_program_is_required_again(
    tmp_path: Path, library: rapc.CheckedLibrary
) -> None:
    folder, world = tmp_path / "j", rapc.open_world("courier")
    _begun(folder, library, Idle())
    said = "cannot resume: the run asks the engine `idle` of a program"
    with pytest.raises(StateError, match=said):
        resume(folder, library.program, world)
    done = command("run", "--resume", str(folder))
    assert done.returncode == 2
    assert done.stderr.startswith(f"error: {said}\n")
    engine: Any = Idle()
    durable = resume(folder, library.program, world, engine=engine)
    assert _planner(durable) == ("builtin", "idle: no plan")


def test_missing_engine_is_reported(
    tmp_path: Path, library: rapc.CheckedLibrary
) -> None:
    program = tmp_path / "planner"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    folder = tmp_path / "j"
    _begun(folder, library, f"{program} {{domain}} {{problem}} {{plan}}")
    program.unlink()
    done = command("run", "--resume", str(folder))
    said = f"error: cannot find the program `{program}` of the engine\n"
    assert (done.returncode, done.stderr) == (2, said)
