"""`rapc experiment --view`: a page of the results, with pages of runs."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

import pytest

from tests.cli.command import rapc
from tests.view.test_page import data_of

COURIER = Path("examples/courier").absolute()

EXPERIMENT = f"""\
title = "A shift </script><b>"
library = "{COURIER}"
world = "courier"
until = 400
seeds = 3
tasks = ["(deliver meals ward-4)"]

[[part]]
name = "blocked"
vary = "courier.blocked"
values = [0, 100]
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder with the results of an experiment and their page."""
    folder = tmp_path_factory.mktemp("experiment")
    (folder / "shift.toml").write_text(EXPERIMENT)
    given = ("experiment", "shift.toml", "--jobs", "1", "--view", "--pages", "3")
    done = rapc(*given, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert "wrote shift-results/index.html and 3 pages" in done.stdout
    return folder / "shift-results"


@pytest.fixture
def part(results: Path) -> dict[str, Any]:
    """Return the data of the part in the page."""
    found = json.loads(data_of((results / "index.html").read_text())["experiment"])
    assert found["title"] == "A shift </script><b>"
    [part] = found["parts"]
    return dict(part)


def test_page_of_results_has_all_runs_by_point(part: dict[str, Any]) -> None:
    assert [point["label"] for point in part["points"]] == ["0", "100"]
    assert part["measures"]["time"] == "time"
    for point in part["points"]:
        assert [run["seed"] for run in point["runs"]] == [0, 1, 2]
    free, blocked = part["points"]
    times = [run["numbers"]["time"] for run in free["runs"]]
    assert free["spreads"]["time"][0] == pytest.approx(sum(times) / 3)
    assert not any(run["end"] for run in free["runs"])
    assert all(run["end"].startswith("ended by the world") for run in blocked["runs"])


def test_each_point_in_turn_has_a_page_of_a_run(
    part: dict[str, Any], results: Path
) -> None:
    pages = [[r["page"] for r in p["runs"] if r["page"]] for p in part["points"]]
    assert sorted(map(len, pages)) == [1, 2]
    for point in part["points"]:
        for run in point["runs"]:
            if run["page"]:
                data = data_of((results / run["page"]).read_text())
                first, *_, last = map(json.loads, data["trace-0"].splitlines())
                assert first["spec"]["seed"] == run["seed"]
                assert last["event"] == "run-ended"
                assert last["time"] == run["numbers"]["time"]


def test_command_of_a_run_writes_its_page(part: dict[str, Any], results: Path) -> None:
    run = part["points"][0]["runs"][1]
    words = shlex.split(run["command"])
    assert words[:2] == ["rapc", "view"]
    file = results / "run.html"
    done = rapc(*words[1:], "-o", str(file))
    assert done.returncode == 0, done.stderr
    data = data_of(file.read_text())
    last = json.loads(data["trace-0"].splitlines()[-1])
    assert last["time"] == run["numbers"]["time"]


def test_text_of_an_experiment_is_not_in_the_markup(results: Path) -> None:
    assert "A shift" not in (results / "index.html").read_text()


def test_pages_require_view(tmp_path: Path) -> None:
    (tmp_path / "shift.toml").write_text(EXPERIMENT)
    done = rapc("experiment", "shift.toml", "--pages", "2", cwd=tmp_path)
    assert done.returncode == 2
    assert "--pages requires --view" in done.stderr
