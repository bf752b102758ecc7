"""Two standing tasks and three orders on one body, under many seeds."""

from __future__ import annotations

import pytest

from rapc.testing.discover import find
from rapc.testing.run import Case, Status, run_case
from tests.claims import claimants_of, users_of
from tests.courier.shifts import CLAIM, COURIER, library, work_a_shift
from tests.effort import first


@pytest.mark.parametrize("seed", first(5, range(60)))
def test_who_claims_the_wheels_keeps_them_and_everything_is_delivered(
    seed: int,
) -> None:
    shift = work_a_shift(seed)
    assert (shift.reason, shift.delivered, shift.failed) == ("done", 3, 0)
    assert shift.moved_from_under == 0
    assert shift.suspended > 0
    assert shift.not_resumed == 0


@pytest.mark.parametrize("seed", first(3, range(20)))
def test_without_its_claims_the_same_library_runs_the_battery_down(seed: int) -> None:
    shift = work_a_shift(seed, claims=False)
    assert (shift.reason, shift.delivered) == ("world", 0)
    assert shift.moved_from_under > 0


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    "option", [{"tray": 1}, {"calls": 40}, {"absent": 70}], ids=str
)
def test_harder_shifts_come_to_an_end_too(seed: int, option: dict[str, int]) -> None:
    shift = work_a_shift(seed, options=option)
    assert (shift.reason, shift.moved_from_under) == ("done", 0)


def test_a_shift_is_the_same_each_time() -> None:
    assert work_a_shift(3) == work_a_shift(3)


def test_every_claim_is_known_to_what_is_counted() -> None:
    files = [file for file in COURIER.glob("*.rap") if ".test." not in file.name]
    text = "".join(file.read_text(encoding="utf-8") for file in files)
    declared = library(True).program.library
    claimants = claimants_of(declared, "wheels")
    assert text.count("(claims ") == text.count(CLAIM) == len(claimants)
    assert "drive" in users_of(declared, "wheels")


def _name(case: Case) -> str:
    return case.test.name


@pytest.mark.parametrize("case", find([COURIER]).cases, ids=_name)
def test_its_own_tests_hold_whatever_chance_does(case: Case) -> None:
    for seed in range(5):
        assert run_case(case, seed).status is Status.PASSED
