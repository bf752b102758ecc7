"""Planted mistakes change what the robot does: a test in the simulator finds each.

Each mistake is one that a user made on purpose in a robot of the same kind, and that
neither the checker nor a test with a script found.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import rapc
from rapc.debug.history import History
from rapc.repl.commands.table import commands
from rapc.repl.shell import Shell
from rapc.testing.discover import find
from rapc.testing.run import Status, run_case

LABORATORY = Path(__file__).parents[2] / "examples" / "laboratory"
WORLD = "laboratory:LaboratoryWorld"
TESTS = "simulation.test.rap"
SEEDS = range(3)

_LEFT = """\
    (claims (arm left))
    (task-net
      (t1 (begin-a-try) (counter-add ?tries 1) (for t2))
      (t2 (carry left"""
_RIGHT = _LEFT.replace("left", "right")
_CLAIM = _LEFT.partition("\n")[0] + "\n"

Edit = tuple[str, str, str]
"""A file, a text in it, and the text in its place."""

MISTAKES: dict[str, list[Edit]] = {
    "sample-never-taken-off-the-heater": [
        (
            "heating.rap",
            " (for t5))\n      (t5 (bring ?sample bench)))))",
            "))))",
        )
    ],
    "claim-of-the-wrong-arm": [("arms.rap", _LEFT, _LEFT.replace("left", "right", 1))],
    "half-copied-method": [("arms.rap", "(carry right ?sample", "(carry left ?sample")],
    "claim-one-level-lower": [
        ("arms.rap", _LEFT, _LEFT.removeprefix(_CLAIM)),
        ("arms.rap", _RIGHT, _RIGHT.partition("\n")[2]),
        (
            "arms.rap",
            "                  (station ?from)))\n",
            "                  (station ?from)))\n    (claims (arm ?arm))\n",
        ),
        (
            "arms.rap",
            "    (context (sample-at ?sample ?arm))\n",
            "    (context (sample-at ?sample ?arm))\n    (claims (arm ?arm))\n",
        ),
    ],
    "until-end-dropped": [("help.rap", "\n              (until-end patience)", "")],
    "repeat-while-dropped": [
        (
            "help.rap",
            "(sample-at ?sample rack))\n  (repeat-while (< (value ?calls) 6))",
            "(sample-at ?sample rack))",
        )
    ],
    "counter-not-counted": [
        (
            "help.rap",
            "(call-and-wait ?sample) (counter-add ?calls 1)",
            "(call-and-wait ?sample)",
        )
    ],
    "result-that-no-step-can-bring": [
        ("arms.rap", "(last-result blocked)", "(last-result jammed)")
    ],
    "precondition-dropped": [
        (
            "arms.rap",
            """\
  (preconditions (and (arm-at ?arm ?place)
                      (sample-at ?sample ?place)
                      (not (sample-at ? ?arm))))
""",
            "",
        )
    ],
    "success-of-a-setter-dropped": [
        (
            "heating.rap",
            "(succeed (and (heater-set ?degrees)\n                (hot ?degrees)))",
            "(succeed (hot ?degrees))",
        )
    ],
    "notation-dropped": [
        ("heating.rap", "    (notations (heater-wanted ?sample))\n", "")
    ],
    "age-of-0.8-for-80": [
        ("measuring.rap", "(standard-value ?value) 80)", "(standard-value ?value) 0.8)")
    ],
    "age-of-the-heat-dropped": [
        ("heating.rap", "(believe (heated ?sample) 110)", "(heated ?sample)")
    ],
    "device-not-asked": [
        ("heating.rap", "  (monitor-state (not (alarm smoke)))\n", "")
    ],
}


def failing(folder: Path) -> str:
    """The first test in the simulator that fails with a library, and its seed."""
    found = find([folder / TESTS])
    assert found.reports == ()
    quick = sorted(found.cases, key=lambda case: case.test.agenda is not None)
    for case in quick:
        for seed in SEEDS:
            outcome = run_case(case, seed, modules=["laboratory"])
            if outcome.status is not Status.PASSED:
                return f"{case.test.name} (seed {seed})"
    return ""


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the library and its tests."""
    monkeypatch.syspath_prepend(LABORATORY)
    for file in LABORATORY.glob("*.rap"):
        (tmp_path / file.name).write_bytes(file.read_bytes())
    return tmp_path


@pytest.mark.slow
def test_sound_library_passes_the_tests_in_the_simulator(library: Path) -> None:
    assert failing(library) == ""


def plant(mistake: str, library: Path) -> None:
    """Make the edits of a mistake."""
    for name, old, new in MISTAKES[mistake]:
        file = library / name
        text = file.read_text(encoding="utf-8")
        assert text.count(old) == 1
        file.write_text(text.replace(old, new), encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES)
def test_planted_mistake_fails_a_test_in_the_simulator(
    mistake: str, library: Path
) -> None:
    plant(mistake, library)
    assert failing(library) != ""


BUSY = {"people": 45, "slips": 30, "drops": 6, "fuse": 20, "smoke": 40}
"""Options of the world with which some mistakes keep a shift from its end."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "mistake",
    [
        "until-end-dropped",
        "precondition-dropped",
        "success-of-a-setter-dropped",
        "age-of-0.8-for-80",
        "age-of-the-heat-dropped",
        "device-not-asked",
    ],
)
def test_exported_test_fails_with_a_mistake_and_passes_with_its_repair(
    mistake: str, library: Path
) -> None:
    plant(mistake, library)
    history = History.open(
        rapc.load(library), WORLD, agenda="shift", options=BUSY, seed=0
    )
    shell, test = Shell(history, commands(), [str(library / "shift.rap")]), "w.test.rap"
    shell.answer(":to at 1500")
    live = [task for task in history.run.tasks() if task.plan.name == "end-the-shift"]
    shell.answer(f":export-test {library / test} {live[0].number} succeeds")
    outcomes = []
    for folder in (library, LABORATORY):
        for file in LABORATORY.glob("*.rap"):
            (library / file.name).write_bytes((folder / file.name).read_bytes())
        case = find([library / test]).cases[0]
        outcomes.append(run_case(case, modules=["laboratory"]).status)
    assert outcomes == [Status.FAILED, Status.PASSED]
