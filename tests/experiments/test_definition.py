"""Files of experiments: what is read from them, and what is refused in which words."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.experiments import definition
from rapc.experiments.definition import ExperimentError, decode_experiment

from .small_experiment import LIBRARY, TRUCK, session


def refusal(text: str) -> tuple[str, str | None]:
    """What is said of a text that is no experiment, or names what is not there."""
    with pytest.raises(ExperimentError) as caught:
        session(text)
    return caught.value.message, caught.value.help or None


def changed(old: str, new: str) -> str:
    assert old in TRUCK
    return TRUCK.replace(old, new)


def test_omitted_option_has_its_default() -> None:
    made = decode_experiment(changed("seeds = 5\n", ""), "name")
    assert (made.name, made.seeds, made.time_limit) == ("name", 30, 120)
    assert made.part[2] == definition.Series("usual")


def test_seeds_count_from_the_first() -> None:
    assert session(TRUCK).seeds == range(5)
    fresh = changed("seeds = 5\n", "seeds = 5\nfirst-seed = 1000\n")
    assert session(fresh).seeds == range(1000, 1005)
    assert session(fresh, seeds=2).seeds == range(1000, 1002)


@pytest.mark.parametrize(
    ("text", "message", "help_"),
    [
        ("until = ", "invalid value (at end of document)", None),
        ("a = " + "[" * 20_000, "nested too deeply", None),
        ("seads = 3\n" + TRUCK, "unknown key `seads`", "did you mean `seeds`?"),
        (
            changed("notes =", "note ="),
            "unknown key `note` in part 1",
            "did you mean `notes`?",
        ),
        (
            changed("figures =", "figure ="),
            "unknown key `figure` in `reference` of part 1",
            "did you mean `figures`?",
        ),
        (
            changed("label =", "name ="),
            "unknown key `name` in `mark` of part 1",
            None,
        ),
    ],
)
def test_keys_and_toml(text: str, message: str, help_: str | None) -> None:
    assert refusal(text) == (message, help_)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (changed('world = "truck"\n', ""), "the key `world` is missing"),
        (changed('name = "slow"\n', ""), "`part 2`: the key `name` is missing"),
        (changed(f'"{LIBRARY}"', '""'), "`library`: expected a text that is not empty"),
        (changed("= 4000", "= -1"), "`until`: expected a whole number >= 1"),
        (
            changed("= 4000", "= inf"),
            "`until`: expected a number <= 1000000000.0",
        ),
        (changed("= 4000", '= "soon"'), "`until`: expected a number, got text"),
        (changed("seeds = 5", "seeds = 0"), "`seeds`: expected a whole number >= 1"),
        (
            changed('"slow"', '"Slow one"'),
            "`part 2, name`: expected text of small letters, digits and hyphens",
        ),
        (
            changed("[2, 4]", "[2, [4]]"),
            "`part 2, values 2`: expected text, a number or true or false, got a list",
        ),
        (
            changed("tasks = [", "tasks = [3,"),
            "`tasks 1`: expected text, got a whole number",
        ),
        (
            "part = [3]\n" + TRUCK.partition("[[part]]")[0],
            "`part 1`: expected a table, got a whole number",
        ),
    ],
)
def test_kinds_of_values(text: str, message: str) -> None:
    assert refusal(text) == (message, None)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            changed(f'"{LIBRARY}"', '"-"'),
            "`library`: expected a file, not standard input",
        ),
        (changed('"slow"', '"drops"'), "duplicate part `drops`"),
        (
            changed("values = [2, 4]", ""),
            "part `slow` requires both `vary` and `values`, or neither",
        ),
        (changed("[2, 4]", "[2, 2]"), "part `slow` has a duplicate value"),
        (
            changed("at = [40]", "at = [0, 40]"),
            "part `drops` has 1 reference figures for `completed`, expected 2",
        ),
        (
            changed("at = [40]", "at = [44]"),
            "part `drops` has reference figures at 44, which is not in its `values`",
        ),
        (
            changed("figures =", "bounds = { time = [[44, 1, 2]] }\nfigures ="),
            "part `drops` has a bound of `time` at 44, which is not in its `values`",
        ),
        (
            changed("figures =", "bounds = { time = [[40, 3, 2]] }\nfigures ="),
            "part `drops` has a bound of `time` with `to` less than `from`",
        ),
        (
            changed("values = [2, 4]", 'values = [2, 4]\nbeside = ["drops"]'),
            "part `slow` has `beside` `drops`, which is not a part with the same "
            "`vary`",
        ),
        (
            TRUCK + 'mark = { at = 1, label = "here" }\n',
            "`mark` of part `usual` requires `vary`",
        ),
        (
            TRUCK + '[part.reference]\ntitle = "T"\nat = [1]\nfigures = {}\n',
            "`at` in the reference of part `usual` requires `vary`",
        ),
    ],
)
def test_contradictions_are_reported(text: str, message: str) -> None:
    assert refusal(text) == (message, None)


@pytest.mark.parametrize(
    ("text", "message", "help_"),
    [
        (
            changed('world = "truck"', 'world = "truk"'),
            "unknown world `truk`",
            "did you mean `truck`?",
        ),
        (
            changed("truck.arm1-drops", "truck.arm1-drop"),
            "the world `truck` has no option `arm1-drop`",
            "did you mean `arm1-drops`?",
        ),
        (
            changed('"truck.arm1-drops"', '"trucks.arm1-drops"'),
            "`trucks.arm1-drops`: unknown owner `trucks`; expected `rapc` or `truck`",
            "did you mean `truck`?",
        ),
        (
            changed('"truck.arm1-drops"', '"rapc.futile-limits"'),
            "unknown setting `rapc.futile-limits`; did you mean `futile-limit`?",
            None,
        ),
        (
            changed("fuel = 1000", "fuel = true"),
            "`truck.fuel` takes one number, not `true`",
            "in the fuel bay at the start",
        ),
        (
            changed("fuel-capacity = 1000", "fuel-capacity = 10"),
            "the world `truck` refuses: `fuel` is more than `fuel-capacity`",
            None,
        ),
        (
            changed('"move-thing-to"', '"move-thing-too"'),
            "`count`, moves: no RAP or primitive is named `move-thing-too`",
            "did you mean `move-thing-to`?",
        ),
        (
            changed("{ moves =", "{ time ="),
            "`count`: `time` is the name of a measure",
            None,
        ),
        (
            changed('["fill-order"]', '["fil-order"]'),
            "`counted`: no foreground task of the RAP `fil-order`",
            "did you mean `fill-order`?",
        ),
        (
            changed("completed = [2]", "complete = [2]"),
            "part `drops`: unknown measure `complete`",
            "did you mean `completed`?",
        ),
    ],
)
def test_unknown_names(text: str, message: str, help_: str | None) -> None:
    assert refusal(text) == (message, help_)


@pytest.mark.parametrize(
    ("task", "message"),
    [
        ("(fill-order red", "task 2: "),
        ("(fill-orders red 1 factory-1)", "unknown RAP `fill-orders`"),
        ("(fill-order red)", "`fill-order` "),
    ],
)
def test_invalid_tasks(task: str, message: str) -> None:
    text = changed("(fill-order blue 1 factory-2) :priority 2 :at 60", task)
    assert refusal(text)[0].startswith(message)


def test_there_must_be_a_task_to_count() -> None:
    text = changed(" :priority 2", " :background true")
    message, _ = refusal(text)
    assert message == "all tasks are in the background; at least one must be counted"


def test_parts_are_found_by_name() -> None:
    assert session(parts=["slow"]).chosen == {"slow"}
    with pytest.raises(ExperimentError) as caught:
        session(parts=["slo"])
    assert caught.value.message == "the experiment `truck` has no part `slo`"
    assert caught.value.help == "did you mean `slow`?"


def test_files_are_found_by_name(tmp_path: Path) -> None:
    with pytest.raises(ExperimentError) as caught:
        definition.experiment_file("chapter")
    assert caught.value.message == "unknown experiment `chapter`"
    file = tmp_path / "my.toml"
    assert definition.experiment_file(str(file)) == file
    with pytest.raises(ExperimentError) as caught:
        definition.read_experiment(file)
    assert caught.value.message == f"cannot read `{file}`: missing file or folder"
    file.write_bytes(b"\xff")
    with pytest.raises(ExperimentError) as caught:
        definition.read_experiment(file)
    assert caught.value.message == f"`{file}` is not UTF-8: byte 0xff in line 1"
    file.write_text(TRUCK)
    assert definition.read_experiment(file).name == "my"
