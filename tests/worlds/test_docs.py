"""The pages docs/reference/truck.md and docs/reference/worlds-api.md are true."""

from __future__ import annotations

import re
from pathlib import Path

from rapc.base.values import Text
from rapc.compiler.program import Program
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import read_task_request
from rapc.worlds.truck.kinds import KINDS
from rapc.worlds.truck.map_text import read_map
from rapc.worlds.truck.primitives import OFFER

from . import script_of_the_manual
from .drive import Driver

DOCS = Path(__file__).parents[2] / "docs"
TRUCK = (DOCS / "reference" / "truck.md").read_text(encoding="utf-8")
WORLDS = (DOCS / "reference" / "worlds-api.md").read_text(encoding="utf-8")


def test_the_truck_page_names_all_primitives_results_and_data() -> None:
    for name, (_, results) in OFFER.primitives.items():
        assert f"`({name}" in TRUCK
        assert all(r == "okay" or f"`{r}`" in TRUCK for r in results), name
    for datum in set(OFFER.data) - {"object-seen", "road-seen"}:
        assert f"`{datum}`" in TRUCK, datum


def test_the_truck_page_gives_the_kinds_their_sizes() -> None:
    for name, kind in KINDS.items():
        liquid = kind.liquid or kind.rounds
        holds = f"{kind.capacity} {liquid} " if liquid else ""
        assert f"| `{name}` | {kind.size} | {holds}|" in TRUCK


def test_the_map_of_the_truck_page_can_be_driven_on() -> None:
    shown = re.search(r"```json\n(.*?)```", TRUCK, re.DOTALL)
    assert shown is not None
    made = read_map(shown[1])
    assert [leg.to for leg in made.legs("pit")] == ["depot", "works"]
    driver = Driver(map=Text(shown[1]))
    driver.do("arm-move arm1 external", "arm-move arm1 crate-1")
    driver.do("arm-move arm1 pitcher-1", "arm-grasp arm1 pitcher-1")
    driver.do("arm-move arm1 water-tank-1", "arm-ladle arm1 pitcher-1")
    driver.do("arm-move arm1 ice-machine-1", "arm-pour arm1 pitcher-1")
    driver.do("arm-toggle arm1 ice-machine-1")
    driver.world.advance(60)
    assert driver.place("ice-2") == "depot"


def test_script_of_the_world_api_works() -> None:
    text = Path(script_of_the_manual.__file__).read_text(encoding="utf-8")
    assert text[text.index("from") :].strip() in WORLDS
    library = Program(script_of_the_manual.library, "shown")
    interpreter = Interpreter(library, script_of_the_manual.world, 0)
    interpreter.submit(read_task_request("(take cup)"))
    interpreter.run()
    assert interpreter.now == 2
    assert interpreter.memory.query("holding", None, None) == [
        ("holding", "left", "cup")
    ]
