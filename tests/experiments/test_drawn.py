"""What is drawn by seed, agendas, libraries by part, and figures about the truth."""

from __future__ import annotations

import msgspec
import pytest

from rapc.experiments.definition import ExperimentError
from rapc.experiments.draws import Between, Draws, drawn, extremes, with_draws
from rapc.experiments.run import measure

from .small_experiment import LIBRARY, TRUCK, session

TASKS = f"{TRUCK.partition('tasks = [')[0]}"
DRAWN = """\
tasks = ["(fill-order {color} 1 factory-1) :at {when}"]
figures = ["delivered", "encounters"]

[draw]
color = ["red", "blue"]
when = { from = 5, to = 9 }
slow = [2, 3]

[set.truck]
fuel = 1000
fuel-capacity = 1000
arm-move-time = "{slow}"

[[part]]
name = "all"
"""
AGENDA = """\
agenda = "nine-orders"

[[part]]
name = "as-given"

[[part]]
name = "one"
library = "examples/rock-order.rap"
tasks = ["(fill-order red 1 factory-1)"]
"""


def test_the_same_seed_draws_the_same() -> None:
    draws: Draws = {"a": Between(1, 6), "b": (1, True, "x")}
    assert drawn(draws, 7) == drawn(draws, 7)
    many = [drawn(draws, seed) for seed in range(100)]
    assert {each["a"] for each in many} == set("123456")
    assert {each["b"] for each in many} == {"1", "true", "x"}


def test_each_value_is_tried_once_beforehand() -> None:
    tried = [*extremes({"a": Between(1, 6), "b": ("x", "y", "z")})]
    assert [tuple(each.values()) for each in tried] == [
        ("1", "x"),
        ("6", "y"),
        ("6", "z"),
    ]
    assert [*extremes({})] == [{}]


def test_only_drawn_names_are_replaced() -> None:
    assert with_draws("(go {a} {b}) {", {"a": "x"}) == "(go x {b}) {"


def test_tasks_and_options_are_drawn() -> None:
    batch = session(TASKS + DRAWN)
    [point] = batch.points
    seen = set()
    for seed in range(8):
        made = measure(point.config, seed)
        assert (made.completed, made.figures) == (1, {"delivered": 1, "encounters": 0})
        values = drawn(batch.made.draw, seed)
        assert f"{values['color']} 1" in made.tasks[0].goal
        assert made.tasks[0].came >= int(values["when"])
        again = batch.command(point, seed)
        assert f"truck.arm-move-time={values['slow']}" in again
        assert f":at {values['when']}'" in again
        seen.add(values["color"])
    assert seen == {"red", "blue"}


def test_drawn_values_change_the_hash() -> None:
    [one] = session(TASKS + DRAWN).points
    [other] = session(TASKS + DRAWN.replace("to = 9", "to = 8")).points
    assert one.digest != other.digest


def test_a_part_has_an_agenda_or_a_library_of_its_own() -> None:
    text = TASKS.replace(str(LIBRARY), "stdlib/truck") + AGENDA
    batch = session(text)
    given, one = batch.points
    assert len(given.config.spec.tasks) == 13
    assert one.config.spec.tasks == ("(fill-order red 1 factory-1)",)
    assert one.library.endswith("/rock-order.rap")
    assert "--agenda nine-orders" in batch.command(given, 1)
    assert "--agenda" not in batch.command(one, 1)
    assert measure(one.config, 0).completed == 1


REFUSED = {
    ('["delivered", ', '["deliverd", '): (
        "`figures`: the world `truck` has no figure `deliverd`",
        "did you mean `delivered`?",
    ),
    ('"encounters"]', '"time"]'): (
        "`figures`: `time` is the name of a measure",
        None,
    ),
    ("from = 5", "frm = 5"): (
        "unknown key `frm` in `when` of `draw`",
        "did you mean `from`?",
    ),
    ("to = 9", "to = 3"): ("`draw`, when: `from` is greater than `to`", None),
    ('["red", "blue"]', "[]"): ("`draw`, color: the list is empty", None),
    ('["red", "blue"]', "3"): (
        "`draw`: expected a list or a table, got a whole number",
        None,
    ),
    ("slow = [", "fast = ["): (
        "`draw`, fast: no task and no option has `{fast}`",
        None,
    ),
    ("{color}", "{colour}"): (
        "`draw`, color: no task and no option has `{color}`",
        None,
    ),
    ("[2, 3]", "[2, -1]"): (
        "the world `truck` refuses: `arm-move-time` must be between 0 and 1000000",
        None,
    ),
    ('"red", "blue"', '"red", "green"'): (
        "(fill-order green 1 factory-1): `green` is not a value of kind color, as "
        "declared for `?color` in `(fill-order ?color ?number "
        "?factory)`",
        None,
    ),
    ("tasks = [", "tusks = ["): (
        "unknown key `tusks`",
        "did you mean `tasks`?",
    ),
}
"""What is said of a file in which a text is changed into another."""


@pytest.mark.parametrize("change", REFUSED, ids=lambda change: change[1])
def test_undrawable_graph_is_refused(change: tuple[str, str]) -> None:
    text = TASKS + DRAWN
    assert change[0] in text
    with pytest.raises(ExperimentError) as caught:
        session(text.replace(*change, 1))
    assert (caught.value.message, caught.value.help or None) == REFUSED[change]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("nine-orders", "nine-order", "unknown agenda `nine-order`"),
        (
            'agenda = "nine-orders"\n',
            "",
            "part `as-given` requires `agenda` or `tasks`",
        ),
    ],
)
def test_unknown_agenda(old: str, new: str, message: str) -> None:
    text = TASKS.replace(str(LIBRARY), "stdlib/truck") + AGENDA
    with pytest.raises(ExperimentError) as caught:
        session(text.replace(old, new, 1))
    assert caught.value.message.startswith(message)


def test_reasons_and_times_are_measured() -> None:
    text = TRUCK.replace("(fill-order blue 1 factory-2)", "(fill-order blue 1 depot)")
    made = measure(session(text).points[0].config, 3)
    red, blue = made.tasks
    assert (red.goal, red.outcome) == ("(fill-order red 1 factory-1)", "succeeded")
    assert red.reason == ""
    assert red.ended is not None
    assert 100 < red.ended <= made.time
    assert blue.outcome == "failed"
    assert blue.reason == (
        "interference: preconditions of `fill-order`, (place ?factory factory)"
    )
    assert msgspec.json.decode(msgspec.json.encode(made), type=type(made)) == made
