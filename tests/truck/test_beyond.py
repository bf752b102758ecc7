"""The library beyond the thesis in the simulator: rounds, and the hospital's ice."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import pytest

from rapc.base.values import Atom, Text
from rapc.experiments import definition
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import TaskRequest, of_agenda
from tests.effort import first

from .runs import EXAMPLES, FACTORIES, STDLIB, Run, library, task

LIBRARY = STDLIB / "truck-beyond"
WORLDS: Mapping[str, Mapping[str, Atom | bool]] = {
    "every-8": {"shuffle-interval": 8, "shuffle-efficiency": 40},
    "still": {},
    "barred": {"road-troops": True, "enemy-interval": 100},
    "all-moved": {"shuffle-interval": 15, "shuffle-efficiency": 100},
}
HOSPITAL = Text((EXAMPLES / "truck-maps" / "hospital.json").read_text("utf-8"))
MIRE = Text(HOSPITAL.value.replace('"mud": 0.25', '"mud": 1'))
FOUL: Mapping[str, Atom | bool] = {"map": HOSPITAL, "rain": 50, "day-length": 400}


def given(agenda: str) -> tuple[TaskRequest, ...]:
    """The tasks of an agenda of the library."""
    return of_agenda(library(LIBRARY).library, agenda)


def run(*tasks: TaskRequest, seed: int, options: Mapping[str, Atom | bool]) -> Run:
    """Run tasks; handlers are held to what the library says of them."""
    return Run(
        *tasks,
        seed=seed,
        options=options,
        compiled=library(LIBRARY),
        settings=Settings(strict=True),
    )


@pytest.mark.parametrize("case", first(1, product(range(3), WORLDS)), ids=str)
def test_all_orders_are_filled_by_rounds(case: tuple[int, str]) -> None:
    seed, name = case
    made = run(*given("nine-orders-on-rounds"), seed=seed, options=WORLDS[name])
    assert made.reason == "done"
    assert set(made.outcomes) == {"succeeded"}
    assert made.delivered == dict.fromkeys(FACTORIES.items(), 12)
    made.assert_honest()
    memory = made.interpreter.memory
    for color, factory in FACTORIES.items():
        for account in (
            ("wanted", color),
            ("owed", color, factory),
            ("carried", color),
        ):
            assert memory.value(*account) == 0


@pytest.mark.parametrize("seed", first(1, range(10)))
def test_the_hospital_gets_its_ice(seed: int) -> None:
    made = run(*given("ice-for-the-hospital"), seed=seed, options=FOUL)
    assert made.reason == "done"
    assert made.moves["ice", "hospital"] == 3
    assert made.answers["arm-toggle", "okay"] >= 1
    assert made.answers["arm-ladle", "okay"] >= 1


@pytest.mark.slow
def test_the_factory_gets_its_rocks_with_the_ice_nine_times_of_ten() -> None:
    """An order is given up after so many drops: under seed 9 it lacks one rock."""
    tasks = given("ice-for-the-hospital")
    made = [run(*tasks, seed=seed, options=FOUL) for seed in range(10)]
    filled = [one.delivered == {("red", "works"): 5} for one in made]
    assert sum(filled) >= 9
    assert [set(one.outcomes) == {"succeeded"} for one in made] == filled


def test_who_minds_the_mud_arrives_and_who_does_not_is_stuck() -> None:
    places = ("hospital", "camp", "hospital", "camp")
    for seed, minding in ((0, "drive-to"), (1, "drive-to"), (0, "truck-travel-to")):
        trips = [task(minding, to, priority=8 - n) for n, to in enumerate(places)]
        made = run(
            task("eye-scan-p", "external", priority=9),
            *trips,
            seed=seed,
            options={"map": MIRE, "fuel": 30, "rain": 100},
        )
        stuck = minding == "truck-travel-to"
        assert made.reason == ("world" if stuck else "done")
        assert made.world.ended() == ("mishap on pass" if stuck else None)


def test_the_experiment_sets_both_ways_to_the_same_worlds() -> None:
    made = definition.read_experiment(definition.experiment_file("rounds"))
    parts = {part.name: part for part in made.part}
    for mine, theirs in (
        ("still", "orders-still"),
        ("interval", "orders-interval"),
        ("efficiency", "orders-efficiency"),
    ):
        assert parts[theirs].agenda == "nine-orders"
        assert parts[mine].agenda is None
        assert parts[mine].vary == parts[theirs].vary
        assert parts[mine].values == parts[theirs].values
        assert parts[mine].set == parts[theirs].set
    assert made.library == f"rapc:{LIBRARY.name}"


@pytest.mark.parametrize(
    ("goal", "where", "many"),
    [
        (("deliver-all", "fuel-drum", "depot", "warehouse"), "warehouse", 6),
        (("move-object", "fuel-drum", "zone-1"), "zone-1", 1),
    ],
    ids=lambda value: str(value[0]) if isinstance(value, tuple) else "",
)
def test_drums_are_brought(goal: tuple[str, ...], where: str, many: int) -> None:
    look = task("eye-scan-p", "external", priority=3)
    made = run(look, task(*goal), seed=0, options={"depot-interval": 0})
    assert (made.reason, set(made.outcomes)) == ("done", {"succeeded"})
    items = made.world.state.items.values()
    lying = [item for item in items if (item.kind, item.place) == ("fuel-drum", where)]
    assert len(lying) == many


WORN: Mapping[str, Atom | bool] = {
    "map": Text((EXAMPLES / "truck-maps" / "junk-yard.json").read_text("utf-8")),
    "wear": 30,
}


@pytest.mark.parametrize("seed", first(1, range(10)))
def test_a_machine_that_breaks_is_mended_and_the_hospital_gets_its_ice(
    seed: int,
) -> None:
    made = run(*given("ice-from-worn-machines"), seed=seed, options=WORN)
    assert made.reason == "done"
    assert made.moves["ice", "hospital"] == 4
    assert made.answers["arm-toggle", "arm-cant-toggle"] == 0
