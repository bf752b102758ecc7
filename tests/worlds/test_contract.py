"""Our own worlds keep to the port."""

from __future__ import annotations

import random

from rapc.library.loader import load_text
from rapc.world import Handlers, Kit
from rapc.worlds.script import At, Row
from rapc.worlds.scripted import ScriptedWorld
from rapc.worlds.truck import TruckWorld

from .contract import check_world
from .robot import truck_words

ERRAND = """
eye-scan external | arm-move arm1 external | arm-move arm1 fuel-drum-1
arm-grasp arm1 fuel-drum-1 | arm-grasp arm1 fuel-drum-1 | arm-examine arm1 fuel-drum-1
eye-examine external fuel-drum-2 | arm-move arm1 fuel-bay | arm-pour arm1 fuel-drum-1
arm-ladle arm1 fuel-drum-1 | arm-move arm1 bay1 | arm-ungrasp arm1 fuel-drum-1
arm-toggle arm1 fuel-drum-1 | eye-monitor rock | truck-speed fast
truck-turn northeast | truck-move | eye-scan external | eye-scan bay1
truck-turn east | truck-move | eye-unmonitor rock | truck-move
"""

GATE = """
(declare-primitive open (?gate) (okay jammed))
(declare-primitive walk (?gate) (okay) :atomic false)
(declare-sensor-datum seen (?gate))
(declare-memory-proposition open-gate (?gate))
"""


def test_the_truck() -> None:
    requests = [tuple(part.split()) for part in ERRAND.replace("\n", "|").split("|")]
    check_world(
        lambda: TruckWorld(random.Random("3:world"), {}),
        truck_words(),
        [request for request in requests if request],
    )


def test_a_script() -> None:
    rows = (
        Row(("open", "?gate"), "jammed", times=1, takes=2),
        Row(("open", "?gate"), takes=3, asserts=(("open-gate", "?gate"),)),
        Row(("walk", "?gate"), takes=1, after=5, data=(("seen", "?gate"),)),
    )
    at = (At(4, erases=(("open-gate",),)), At(30, asserts=(("open-gate", "back"),)))
    library = load_text(GATE).library
    check_world(
        lambda: ScriptedWorld(
            rows,
            at,
            declared=library,
            kit=Kit(handlers=Handlers(data={"seen": lambda memory, datum: None})),
        ),
        library,
        [("open", "front"), ("open", "front"), ("walk", "front"), ("open", "back")],
    )
