"""Declared effects come true in simulators: `rapc test --effects`."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.cli.command import rapc


@pytest.mark.parametrize(
    ("tests", "count", "seeds"),
    [
        ("examples/courier/simulation.test.rap", 5, "4"),
        ("examples/laboratory/simulation.test.rap", 4, "1"),
        ("stdlib/hallway/errands.test.rap", 2, "1"),
        ("stdlib/truck-beyond/errands.test.rap", 4, "2"),
    ],
)
def test_effects_of_shipped_libraries_come_true(
    tests: str, count: int, seeds: str
) -> None:
    done = rapc("-q", "test", "--effects", tests, "--seeds", seeds)
    assert done.returncode == 0, done.stdout
    assert done.stdout.startswith(f"effects: {count} of {count} RAPs checked\n")


@pytest.mark.parametrize(
    ("false", "text"),
    [
        ("(effects (docked) (call ward-1))", "(call ward-1) does not hold"),
        ("(effects (docked) (not (robot-at ?)))", "(robot-at ?) still holds"),
    ],
)
def test_false_effect_fails_with_its_place(
    tmp_path: Path, false: str, text: str
) -> None:
    folder = tmp_path / "courier"
    shutil.copytree("examples/courier", folder)
    file = folder / "charging.rap"
    file.write_text(file.read_text().replace("(effects (docked))", false))
    options = ("--effects", folder / "simulation.test.rap", "--jobs", "2")
    done = rapc("test", *map(str, options))
    assert done.returncode == 1
    assert f"{file}:45:" in done.stdout
    assert "(go-into-dock) [" in done.stdout
    assert f"but {text}\n" in done.stdout
    assert rapc("test", str(folder)).returncode == 0


def test_unchecked_raps_are_named() -> None:
    done = rapc("-q", "test", "--effects", "examples/courier/courier.test.rap")
    names = "`travel-to`, `go-into-dock`, `be-of-help`, `fetch`, `bring`"
    assert done.stdout.startswith(f"effects: 0 of 5 RAPs checked; not: {names}\n")
