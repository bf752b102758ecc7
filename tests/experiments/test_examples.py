"""The experiments among the examples: each is well formed, and its runs begin well.

A run of a few hundred time units for each file, some half a second in all.
"""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from rapc.experiments import definition
from rapc.experiments.run import measure
from rapc.experiments.session import Batch

from .small_experiment import checked

FILES = sorted(
    (Path(__file__).parents[2] / "examples" / "experiments").glob("*.toml"),
)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_an_experiment_among_the_examples_runs(file: Path) -> None:
    made = msgspec.structs.replace(definition.read_experiment(file), until=250)
    points = Batch(made, file.parent, checked).points
    run = measure(points[0].config, 0)
    assert (run.reason, run.disaster) == ("until", None)
    orders = 1 if file.stem == "worn" else 9
    assert run.completed + run.given_up + run.pending == orders
    assert run.effector > 20


def test_there_are_such_experiments() -> None:
    assert FILES
