"""`rapc run --agenda` and `agenda=`: tasks that stand in the library."""

from __future__ import annotations

from pathlib import Path

import pytest

import rapc as door
from rapc.errors import RefusedError
from tests.cli.command import rapc

LIBRARY = """\
(require "truck")
(define-agenda morning
  (task (truck-set-heading north) :priority 3)
  (task (eye-scan-all) :at 4 :background true))
(define-rap (eye-scan-all) (succeed nil) (method (task-net)))
(define-rap (truck-set-heading ?heading) (method (task-net)))
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return a library with an agenda."""
    file = tmp_path / "day.rap"
    file.write_text(LIBRARY)
    return file


def test_an_agenda_comes_before_the_tasks_given_besides(path: Path) -> None:
    lib = door.load(path)
    result = door.run(lib, "truck", "(truck-set-heading west)", agenda="morning")
    goals = [str(task.goal) for task in result.tasks]
    assert goals[:2] == ["(truck-set-heading north)", "(truck-set-heading west)"]
    assert result.succeeded


def test_the_command_runs_it_and_the_trace_tells_of_its_tasks(
    path: Path, tmp_path: Path
) -> None:
    trace = tmp_path / "t.jsonl"
    done = rapc(
        *("run", str(path), "--world", "truck", "--agenda", "morning", "-q"),
        *("--trace", str(trace)),
    )
    assert done.returncode == 0, done.stderr
    first = trace.read_text().splitlines()[0]
    assert "(truck-set-heading north) :priority 3" in first
    assert "(eye-scan-all) :at 4 :background true" in first


def test_an_unknown_agenda_is_refused_with_the_nearest_name(path: Path) -> None:
    done = rapc("run", str(path), "--world", "truck", "--agenda", "mornin")
    assert done.returncode == 2
    assert "unknown agenda `mornin`; did you mean `morning`?" in done.stderr
    with pytest.raises(RefusedError, match="did you mean `morning`"):
        door.load(path).start("truck", agenda="mornin")


def test_without_agenda_and_task_there_is_nothing_to_do(path: Path) -> None:
    done = rapc("run", str(path), "--world", "truck")
    assert done.returncode == 2
    assert "missing --task or --agenda" in done.stderr
