"""`rapc worlds`: what it prints, in wide and in narrow terminals."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from click.testing import CliRunner

from rapc.cli.worlds import worlds
from rapc.console.worlds import columns, describe_world
from rapc.library.loader import load
from rapc.worlds.registry import find_world
from rapc.worlds.truck import TruckWorld

from ..cli.command import rapc


def truck(width: int) -> str:
    return describe_world(TruckWorld(random.Random(0), {}), width)


def test_installed_worlds_are_listed_with_descriptions() -> None:
    done = CliRunner().invoke(worlds, [])
    assert done.exit_code == 0
    assert "truck    A delivery truck among quarries and factories" in done.output


def test_a_world_is_described_with_all_it_offers() -> None:
    done = CliRunner().invoke(worlds, ["truck"], env={"COLUMNS": "80"})
    assert done.exit_code == 0
    assert done.output == truck(80) + "\n"
    for line in (
        "  arm-move/2       okay, arm-cant-find",
        "sensor primitives",
        "  arm-examine  eye-examine  eye-scan  eye-monitor  eye-unmonitor",
        "  arm1-drops          15 %: grasps that arm1 drops",
        "  eye-scan-time       2 time units: for eye-scan",
        "  item-limit          10 items (integer): none is put there, none made above",
    ):
        assert line in done.output.splitlines()


@pytest.mark.parametrize("width", [80, 60, 40, 30])
def test_no_line_is_wider_than_the_terminal(width: int) -> None:
    assert max(len(line) for line in truck(width).splitlines()) <= width


@pytest.mark.parametrize("columns", ["1", "2", "19"])
def test_a_terminal_may_be_too_narrow_for_any_text(columns: str) -> None:
    done = CliRunner().invoke(worlds, ["truck"], env={"COLUMNS": columns})
    assert done.exit_code == 0
    assert done.output == truck(20) + "\n"


def test_where_it_is_narrow_texts_go_below_their_names() -> None:
    assert columns([("a-long-name", "some text")], 30) == [
        "a-long-name",
        "    some text",
    ]
    assert columns([("a-long-name", "some text")], 40) == ["a-long-name  some text"]


def test_an_unknown_world_exits_2_with_the_near_name() -> None:
    done = rapc("worlds", "truk")
    assert done.returncode == 2
    assert done.stderr == "error: unknown world `truk`\n  did you mean `truck`?\n"


def test_arguments_are_declared_as_the_offer_calls_them() -> None:
    done = CliRunner().invoke(worlds, ["courier", "--declare"])
    assert "(declare-primitive hand-over (?goods ?ward)" in done.output
    assert "(declare-event :nurse (?ward))" in done.output


@pytest.mark.parametrize("name", ["courier", "truck"])
def test_included_worlds_name_all_arguments(
    name: str,
) -> None:
    """As the library that comes with the world calls them, too."""
    offer = find_world(name).kit.offer
    unnamed = [
        told
        for told in (*offer.primitives, *offer.data, *offer.skills, *offer.events)
        if offer.counts(told) != {len(offer.arguments.get(told, ()))}
    ]
    assert unnamed == []
    folder = "examples" if name == "courier" else "stdlib"
    library = load([Path(f"{folder}/{name}/world.rap")]).library
    declared = {
        form.name: tuple([arg.variable.name[1:] for arg in form.args])
        for table in ("primitives", "data", "skills", "events")
        for form in getattr(library, table).values()
    }
    assert {one: offer.arguments.get(one, ()) for one in declared} == declared


def test_the_command_lists_results_never_seen() -> None:
    done = CliRunner().invoke(worlds, ["courier", "--test", "--requests", "20"])
    assert done.exit_code == 0
    lines = [line.strip() for line in done.output.splitlines()]
    at = lines.index("results that no request had:")
    assert lines[at - 1].endswith("requests and messages")
    assert "hand-over: okay, nobody-there" in lines[at:]
    assert lines[-1].startswith("courier: 8 checks passed, ")


def test_the_number_of_requests_is_for_tests_only() -> None:
    done = CliRunner().invoke(worlds, ["courier", "--requests", "20"])
    assert done.exit_code == 2
    assert "--requests requires --test" in done.output
