"""Worlds by name, option values from text, and what is said when they are wrong."""

from __future__ import annotations

import random
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from rapc.base.values import Text
from rapc.errors import WorldError
from rapc.world import Kit, Option, World
from rapc.worlds import registry
from rapc.worlds.truck import TruckWorld


class Toy(TruckWorld):
    """A world with an option of each kind."""

    name = "toy"

    def __init__(self, rng: random.Random, options: Mapping[str, Any]) -> None:
        super().__init__(rng, {})
        self.given = options

    kit = Kit(
        options=(
            Option("speed", "number", 1.5, "metres", "how fast"),
            Option("count", "integer", 1, "", "how many"),
            Option("loud", "flag", False, "", "whether it is loud"),
            Option("shape", "symbol", "round", "", "what it looks like"),
            Option("note", "text", Text(""), "", "what is written on it"),
        )
    )


class Half(World):
    """A world that lacks most of what it needs."""

    name = "half"


def test_the_truck_is_found_by_name_and_by_place() -> None:
    assert "truck" in registry.available()
    assert registry.find_world("truck") is TruckWorld
    assert registry.find_world("rapc.worlds.truck:TruckWorld") is TruckWorld


@pytest.mark.parametrize(
    ("name", "message", "help_"),
    [
        ("trcuk", "unknown world `trcuk`", "did you mean `truck`?"),
        ("no_such_module:World", "cannot be loaded: ModuleNotFoundError", ""),
        ("rapc.worlds.truck:Nothing", "cannot be loaded: AttributeError", ""),
        ("rapc.base.values:number", "is not a subclass of `rapc.World`", ""),
        (f"{__name__}:Half", "does not define", ""),
        (":", "cannot be loaded: it is not `module:Class`", ""),
        ("rapc:", "cannot be loaded: it is not `module:Class`", ""),
    ],
)
def test_invalid_world_is_refused_on_one_line(
    name: str, message: str, help_: str
) -> None:
    with pytest.raises(WorldError) as caught:
        registry.find_world(name)
    assert message in caught.value.message
    assert "\n" not in caught.value.message
    assert caught.value.help == help_


def test_where_no_name_is_near_all_worlds_are_named() -> None:
    with pytest.raises(WorldError, match="unknown world `moon`") as caught:
        registry.find_world("moon")
    for name in registry.available():
        assert f"`{name}`" in caught.value.help
    assert "`module:Class`" in caught.value.help


def test_looking_for_a_world_leaves_the_path_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    before = list(sys.path)
    registry.find_world("truck")
    assert sys.path == before


def test_a_module_of_the_working_directory_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = "from rapc.worlds.truck import TruckWorld\nclass Mine(TruckWorld): ...\n"
    (tmp_path / "my_worlds_of_a_test.py").write_text(text)
    monkeypatch.chdir(tmp_path)
    assert registry.find_world("my_worlds_of_a_test:Mine").name == "truck"


def test_settings_are_split_into_owner_name_and_value() -> None:
    assert registry.split_setting("truck.fuel=20") == ("truck.fuel", "20")
    assert registry.split_setting(" a.b = c=d ") == ("a.b", "c=d")
    for wrong in ("fuel=20", "truck.fuel", "=3", "truck.=3", ".fuel=3"):
        with pytest.raises(WorldError, match="not of the form"):
            registry.split_setting(wrong)


def test_values_take_the_kind_of_their_option() -> None:
    texts = {
        "speed": "2.50",
        "count": "-3",
        "loud": "TRUE",
        "shape": "Square",
        "note": "Any Thing; (at all)",
    }
    assert registry.read_options(Toy, texts) == {
        "speed": 2.5,
        "count": -3,
        "loud": True,
        "shape": "square",
        "note": Text("Any Thing; (at all)"),
    }
    assert registry.read_options(Toy, {"speed": "2.0"}) == {"speed": 2}


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("speed", "fast", "`toy.speed` takes one number, not `fast`"),
        ("speed", "1e5", "`toy.speed` takes one number, not `1e5`"),
        ("speed", "inf", "`toy.speed` takes one number, not `inf`"),
        ("speed", "", "`toy.speed` takes one number, not ``"),
        ("count", "1.5", "`toy.count` takes one integer, not `1.5`"),
        ("loud", "yes", "`toy.loud` takes `true` or `false`, not `yes`"),
        ("shape", "two words", "`toy.shape` takes one symbol, not `two words`"),
        ("note", "@/no/such/file", "cannot read `/no/such/file`: missing file"),
        ("spede", "1", "the world `toy` has no option `spede`"),
    ],
)
def test_values_of_another_kind_are_refused(name: str, text: str, message: str) -> None:
    with pytest.raises(WorldError) as caught:
        registry.read_options(Toy, {name: text})
    assert message in caught.value.message
    if name == "spede":
        assert caught.value.help == "did you mean `speed`?"


def test_text_may_come_from_a_file(tmp_path: Path) -> None:
    (tmp_path / "note.txt").write_text("hello", encoding="utf-8")
    texts = {"note": f"@{tmp_path / 'note.txt'}"}
    assert registry.read_options(Toy, texts) == {"note": Text("hello")}


def test_a_world_is_built_from_a_seed_of_its_own_stream() -> None:
    one, other = [registry.build_world(TruckWorld, n, {"fuel": 10}) for n in (5, 6)]
    two = TruckWorld(random.Random("5:world"), {"fuel": 10})
    assert isinstance(one, TruckWorld)
    assert isinstance(other, TruckWorld)
    assert one.save() == two.save()
    assert one.save() != other.save()


def test_world_gets_an_option_of_kind_text_as_str() -> None:
    for options in ({}, {"note": Text("a b")}, {"note": "a b"}):
        world = registry.build_world(Toy, 0, options)
        assert isinstance(world, Toy)
        assert world.given["note"] == ((options and "a b") or "")
        assert type(world.given["note"]) is str


def test_values_a_world_refuses_are_the_users_fault() -> None:
    with pytest.raises(WorldError, match="the world `truck` refuses: `fuel` is more"):
        registry.build_world(TruckWorld, 0, {"fuel": 99})
