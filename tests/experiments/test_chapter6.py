"""The experiments of T chapter 6 as they come with rapc."""

from __future__ import annotations

import re
from pathlib import Path

from rapc.experiments import definition
from rapc.experiments.session import Batch
from tests.cli.command import rapc

from .small_experiment import checked


def chapter6() -> Batch:
    file = definition.experiment_file("chapter6")
    made = definition.read_experiment(file)
    return Batch(made, file.parent, checked)


def test_points_are_those_of_the_thesis_and_shared_where_they_are_alike() -> None:
    session = chapter6()
    at = {(point.part, point.value): point.digest for point in session.points}
    parts = ["still", "one", "two", "three", "limit", "hands", "hands-two"]
    assert [part.name for part in session.made.part] == parts
    assert len(at) == 1 + 5 + 11 + 11 + 3 + 6 + 3
    assert (session.seeds.start, len(session.seeds)) == (6000, 30)
    assert at["still", None] == at["two", 0]
    assert at["one", 15] == at["two", 40]
    assert at["limit", 2] == at["two", 60]
    assert len(set(at.values())) == len(at) - 3
    stops = {p.texts.get("truck.shuffle-until") for p in session.points}
    assert stops == {None, "3960"}


def test_orders_come_as_in_the_thesis() -> None:
    tasks = chapter6().points[0].config.spec.tasks
    orders = [task for task in tasks if task.startswith("(fill-order")]
    assert [int(text.partition(":at ")[2]) for text in orders] == [*range(120, 601, 60)]
    assert all(":priority 2" in text for text in orders)
    for color, factory in (("red", 1), ("blue", 2), ("yellow", 3)):
        goal = f"(fill-order {color} 4 factory-{factory})"
        assert sum(text.startswith(goal) for text in orders) == 3


def test_figures_agree_with_one_another() -> None:
    """What T's tables say twice: shares of primitives, from their numbers."""
    references = [p.reference for p in chapter6().made.part if p.reference is not None]
    titles = [reference.title for reference in references]
    assert titles == ["T 6.2", "T 6.1", "T 6.2", "T", "T"]
    for reference in references[:3]:
        told = reference.figures
        for place, sensor in enumerate(told["sensor"]):
            total = sensor + told["effector"][place]
            share = 100 * sensor / total
            failed = 100 * told["failed"][place] / total
            assert abs(share - told["percent-sensor"][place]) <= 1.5
            assert abs(failed - told["percent-failed"][place]) <= 1.0


def test_a_still_run_from_anywhere(tmp_path: Path) -> None:
    args = ("experiment", "chapter6", "--part", "still", "--seeds", "1")
    done = rapc(*args, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"^all +1 +0 +\d+ / 441 +9\.0 / 9 +\d+ / 659 ", done.stdout, re.M)
    tables = (tmp_path / "chapter6-results" / "tables.md").read_text()
    assert re.search(r"\| \d+ / 3966 \|", tables)
