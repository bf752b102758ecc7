"""Names of earlier versions: the message says what has their place now."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

import rapc
from rapc.base.former import MODULES, NAMES
from rapc.world import Handlers, Offer, World
from tests.worlds.broken_worlds import LIBRARY, Good


class Former(World):
    """A world as an earlier version wanted it."""

    name = "former"

    now, perform, next_time = Good.now, Good.perform, Good.next_time
    advance, messages = Good.advance, Good.messages

    def offer(self) -> Offer:
        return Good.kit.offer

    def handlers(self) -> Handlers:
        return Good.kit.handlers


SAID = (
    "`offer`, `handlers`: fields of `kit = Kit(...)`, no methods; "
    'see "Upgrading" in CHANGELOG.md'
)


def test_world_with_methods_for_a_kit_is_told_of_the_kit() -> None:
    library = rapc.loads(LIBRARY)
    for world in (f"{__name__}:Former", Former, Former()):
        with pytest.raises(rapc.WorldError, match="does not define kit") as caught:
            library.start(world)
        assert caught.value.help == SAID


@pytest.mark.parametrize("module", MODULES)
def test_world_importing_a_former_module_learns_the_new_name(
    module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = f"imports_{module.replace('.', '_')}"
    (tmp_path / f"{name}.py").write_text(f"from {module} import Any\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(
        rapc.WorldError, match=f"{name}.py:1.: (Module|Import)"
    ) as caught:
        rapc.open_world(f"{name}:Any")
    assert f"`{module}` is replaced by {MODULES[module]}; see" in caught.value.help


def test_import_of_the_former_port_names_the_new_module() -> None:
    former = importlib.import_module("rapc.runtime.world")
    with pytest.raises(ImportError, match=r"is replaced by `rapc\.world`"):
        former.World  # noqa: B018


@pytest.mark.parametrize("name", NAMES)
def test_former_names_of_the_package_are_told_of_the_new_ones(name: str) -> None:
    with pytest.raises(AttributeError) as caught:
        getattr(rapc, name)
    assert f"no attribute {name!r}; it is replaced by `" in str(caught.value)


def test_the_changelog_says_how_to_upgrade() -> None:
    text = (Path(__file__).parents[2] / "CHANGELOG.md").read_text(encoding="utf-8")
    upgrading = text.split("### Upgrading")[1].split("###")[0]
    for old in (*MODULES, *[f"rapc.{name}" for name in NAMES]):
        assert f"`{old}`" in upgrading
