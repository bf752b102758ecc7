"""Slips in real libraries are found; docs/developers/slips.md counts them by kind."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from bench.mutation import (
    KINDS,
    LIBRARIES,
    NOT_SURE,
    STORED,
    Bench,
    Outcome,
    outcomes,
)
from bench.mutation_runs import Runs
from rapc.base.source import SourceFile


@pytest.fixture(scope="module")
def benches() -> Sequence[Bench]:
    """The libraries, in which nothing is found as they are."""
    return [Bench(paths) for paths in LIBRARIES]


def test_there_are_many_kinds_of_slips_and_the_stored_counts_have_them_all() -> None:
    assert len(KINDS) - len(NOT_SURE) >= 40
    assert set(NOT_SURE) < set(KINDS)
    counts = json.loads(STORED.read_bytes())
    assert [row["slip"] for row in counts["kinds"]] == [*KINDS]
    remarks = {row["slip"]: row["remark"] for row in counts["kinds"] if row["remark"]}
    assert remarks == NOT_SURE


_LAMP = """\
(declare-memory-proposition lit (?lamp))
(declare-primitive press (?lamp) (okay) :on (okay (lit ?lamp)))
(define-rap (light ?lamp)
  (succeed (lit ?lamp))
  (method (primitive (press ?lamp))))
(define-test it-lights
  (script ((press ?lamp) okay :asserts ((lit ?lamp))))
  (task (light hall))
  (expect (succeeds (light hall))))
"""


@pytest.mark.parametrize(
    ("old", "new", "same"),
    [
        ("(lit ?lamp))\n  (method", "(and (lit ?lamp) (lit hall)))\n  (method", True),
        ("(primitive (press ?lamp))", "(primitive (press attic))", False),
        ("(succeed (lit ?lamp))", "(succeed (lit attic))", False),
        ("(succeed (lit ?lamp))", "(succed (lit ?lamp))", False),
    ],
)
def test_a_slip_that_changes_no_trace_is_told_from_others(
    tmp_path: Path, old: str, new: str, same: bool
) -> None:
    file = tmp_path / "lamp.test.rap"
    file.write_text(_LAMP, encoding="utf-8")
    assert _LAMP.count(old) == 1
    changed = SourceFile(str(file), _LAMP.replace(old, new))
    assert Runs([tmp_path]).are_the_same(changed) is same


def test_without_tests_nobody_can_tell_what_a_slip_changes(tmp_path: Path) -> None:
    file = tmp_path / "lamp.rap"
    file.write_text("(define-rap (wait))\n", encoding="utf-8")
    assert Runs([tmp_path]).are_the_same(SourceFile(str(file), "")) is None


def test_tests_in_a_simulator_tell_what_a_slip_changes() -> None:
    folder = Path("examples/laboratory").absolute()
    shift = folder / "shift.rap"
    text = shift.read_text(encoding="utf-8")
    assert "(analyse s4) :priority 2 :deadline 500" in text
    changed = SourceFile(str(shift), text.replace("s4) :priority 2", "s4) :priority 5"))
    assert Runs([folder]).are_the_same(changed) is False


def test_the_opposite_of_a_denied_formula_is_the_formula() -> None:
    base = Bench(["examples/greenhouse.rap"]).base
    text = {edit.content for edit in KINDS["context negated"][1](base)}
    assert text == {"(can empty)", "(not (can empty))"}


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("each", [1, pytest.param(2, marks=pytest.mark.nightly)])
def test_slips_of_the_visible_kinds_are_found(
    benches: Sequence[Bench], each: int
) -> None:
    made: list[Outcome] = []
    missed = []
    for kind in KINDS:
        if kind not in NOT_SURE:
            there = [one for _, one in outcomes(kind, benches, each, 1)]
            made += there
            missed += [kind for one in there if not one.found]
    assert len(missed) <= len(made) // 20, missed
    assert sum(one.named for one in made) >= 0.85 * len(made)
    assert sum(len(one.found) == 1 for one in made) >= 0.85 * len(made)


@pytest.mark.slow
def test_the_same_seed_makes_the_same_slips(benches: Sequence[Bench]) -> None:
    kind = "predicate misspelt"
    one, two = ([o.edit for _, o in outcomes(kind, benches, 5, 3)] for _ in range(2))
    assert one == two
    assert len(one) == 5 * len(benches)
