"""The contract of worlds: ours keep to it, and each way to break it is found."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Sequence
from typing import Any

import pytest

import rapc
from rapc.compiler.program import Program
from rapc.ir.layout import laid_out
from rapc.library.loader import load_text
from rapc.testing.contract.declarations import declaring
from rapc.testing.contract.trials import (
    ASKING,
    HANDLERS,
    PICTURE,
    SAVING,
    SKILLS,
    TIMES,
    TRUTH,
    Trial,
    try_world,
)
from rapc.world import (
    Datum,
    Fact,
    Finished,
    Handlers,
    Kit,
    Offer,
    Option,
    Picture,
    Refused,
    Reply,
    Spot,
    World,
)
from rapc.worlds.faults import FaultyWorld, InjectedFault
from rapc.worlds.hallway.world import HallwayWorld
from rapc.worlds.script import At, Row
from rapc.worlds.scripted import ScriptedWorld
from rapc.worlds.truck import TruckWorld
from tests.worlds.broken_worlds import (
    ARITIES,
    LIBRARY,
    OFFER,
    RAISING,
    TYPES,
    Good,
    ignored,
    looked,
    with_,
)

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
REQUESTS = [tuple(part.split()) for part in ERRAND.replace("\n", "|").split("|")]

GATE = """
(declare-primitive open (?gate) (okay jammed))
(declare-primitive walk (?gate) (okay) :atomic false)
(declare-sensor-datum seen (?gate))
(declare-memory-proposition open-gate (?gate))
"""


def faults(trials: Sequence[Trial]) -> list[str]:
    return [fault for trial in trials for fault in trial.faults]


def truck(seed: int) -> TruckWorld:
    return TruckWorld(random.Random(f"{seed}:world"), {})


def test_the_truck() -> None:
    requests = [request for request in REQUESTS if request]
    trials = try_world(truck, Program(truck_words()), requests)
    assert faults(trials) == []
    assert [trial.part for trial in trials if trial.left_out] == [SKILLS]


def test_the_truck_with_faults_put_in() -> None:
    fault = InjectedFault(("eye-scan", "?"), "eye-cant-find", 0.5)
    trials = try_world(
        lambda seed: FaultyWorld(truck(seed), (fault,), seed), Program(truck_words())
    )
    assert faults(trials) == []


def test_unused_results_are_listed() -> None:
    (before,) = [t.unseen for t in try_world(truck) if t.part == ASKING]
    assert before["truck-move"] == ("okay", "truck-mishap")
    requests = [request for request in REQUESTS if request]
    (after,) = [t.unseen for t in try_world(truck, None, requests) if t.part == ASKING]
    assert after["truck-move"] == ("truck-mishap",)
    assert all(set(after.get(name, ())) <= {*told} for name, told in before.items())


def test_more_requests_are_made_when_asked_for() -> None:
    made: list[int] = []

    class Counted(TruckWorld):
        def perform(self, ticket: int, request: Fact) -> Any:
            made[-1] += 1
            return super().perform(ticket, request)

    for count in (3, 30):
        made.append(0)
        try_world(lambda seed: Counted(random.Random(seed), {}), count=count)
    assert made[0] < made[1]


def test_the_hallway() -> None:
    trials = try_world(lambda seed: HallwayWorld(random.Random(f"{seed}:world"), {}))
    assert faults(trials) == []


def test_a_script() -> None:
    rows = (
        Row(("open", "?gate"), "jammed", times=1, takes=2),
        Row(("open", "?gate"), takes=3, asserts=(("open-gate", "?gate"),)),
        Row(("walk", "?gate"), takes=1, after=5, data=(("seen", "?gate"),)),
    )
    at = (At(4, erases=(("open-gate",),)), At(30, asserts=(("open-gate", "back"),)))
    library = load_text(GATE).library
    seen = Handlers(data={"seen": lambda memory, datum: None})

    def make(seed: int) -> World:
        return ScriptedWorld(rows, at, declared=library, kit=Kit(handlers=seen))

    assert (
        faults(try_world(make, requests=[("walk", "front"), ("open", "front")])) == []
    )


# --- broken ones ------------------------------------------------------------------


def tried(world: type[World], library: str = LIBRARY) -> list[str]:
    """What is wrong with a world that is made like the good one."""
    make: Any = world
    program = rapc.loads(library).program
    return faults(try_world(lambda seed: make(random.Random(seed), {}), program))


def test_nothing_is_wrong_with_the_good_one() -> None:
    assert tried(Good) == []


@pytest.mark.parametrize("case", TYPES)
def test_worlds_violating_the_port_are_found(case: str) -> None:
    world, _ = TYPES[case]
    found = tried(world)
    assert found
    assert "comparator" in case or "broken_worlds.py:" in " ".join(found)


@pytest.mark.parametrize("case", [case for case in RAISING if case != "a function"])
def test_worlds_raising_exceptions_are_found(case: str) -> None:
    world, whose = RAISING[case]
    assert f"{whose} failed at broken_worlds.py:" in " ".join(tried(world))


@pytest.mark.parametrize("case", ARITIES)
def test_code_with_wrong_arguments_is_found(case: str) -> None:
    world, said = ARITIES[case]
    assert [line for line in tried(world) if re.search(said, line)]


class Whole(Good):
    """A world with all parts of the port, and nothing wrong with any."""

    kit = Kit(
        Offer(OFFER.primitives, OFFER.data, events=OFFER.events, not_atomic=("doze",)),
        *[getattr(Good.kit, name) for name in Kit.__struct_fields__[1:]],
    )

    def __init__(self, rng: Any, options: Any) -> None:
        super().__init__(rng, options)
        self.rng = rng
        self.dozing: list[int] = []

    def perform(self, ticket: int, request: Fact) -> Any:
        if request[0] == "doze":
            self.dozing.append(ticket)
            return None
        return super().perform(ticket, request)

    def next_time(self) -> Any:
        return self.time + 1 if self.dozing else None

    def advance(self, to: Any) -> None:
        if to > self.time:
            self.sent = [Finished(n, Reply("okay")) for n in self.dozing]
            self.dozing = []
        super().advance(to)

    def cancel(self, ticket: int) -> None:
        self.dozing = [one for one in self.dozing if one != ticket]

    def save(self) -> bytes:
        return json.dumps([self.time, self.dozing, len(self.sent)]).encode()

    def restore(self, state: bytes) -> None:
        self.time, self.dozing, sent = json.loads(state)
        self.sent = [Datum(("spotted", "mouse"))] * sent

    def picture(self) -> Picture:
        return Picture("shelf", (Spot("shelf"), Spot("box")), (("shelf", "box"),))

    def usual_time(self, request: Fact) -> Any:
        return 1


def forgets(self: Any, state: bytes) -> None:
    Whole.restore(self, state)
    self.time += 1


def restores_anything(self: Any, state: bytes) -> None:
    if state != b"no state":
        Whole.restore(self, state)


def saves_otherwise(self: Any) -> bytes:
    self.time += 1
    return Whole.save(self)


def saves_too_little(self: Any) -> bytes:
    return json.dumps([self.time, [], 0]).encode()


def counts_again(self: Any, ticket: int, request: Fact) -> Any:
    self.asked = getattr(self, "asked", 0) + 1
    self.time += self.asked
    return Reply("okay")


def by_chance(self: Any, ticket: int, request: Fact) -> Any:
    self.time += random.SystemRandom().random()
    return Reply("okay")


def drawn_apart(self: Any) -> Picture:
    return Picture("moon", (Spot("box"), Spot("box")))


def drawn_on(self: Any) -> Picture:
    self.time += 1
    return Picture("box", (Spot("box"),))


def in_no_time(self: Any, request: Fact) -> Any:
    self.time += 1
    return 1


def never(self: Any) -> Any:
    return None


def refuses(self: Any, ticket: int, request: Fact) -> Any:
    return Refused((17,))


def unheard_of(self: Any, ticket: int) -> None:
    self.dozing.remove(ticket)


WORSE: dict[str, tuple[dict[str, Any], str]] = {
    "restores another": ({"restore": forgets}, "does not restore the whole state"),
    "restores nonsense": (
        {"restore": restores_anything},
        "accepts a state that is not",
    ),
    "saves otherwise": (
        {"save": saves_otherwise},
        "returns a different state when called",
    ),
    "saves too little": (
        {"save": saves_too_little, "perform": counts_again},
        "continues differently from the saved world",
    ),
    "by its own chance": ({"perform": by_chance}, "two runs with seed 0 differ"),
    "a picture of nowhere": ({"picture": drawn_apart}, "has no spot `moon`"),
    "two spots of one name": ({"picture": drawn_apart}, "two spots of the picture"),
    "drawn on": ({"picture": drawn_on}, "changes the world"),
    "a time that takes time": ({"usual_time": in_no_time}, "advances the clock"),
    "a time that is none": ({"usual_time": lambda *_: -1}, "a usual time .* is `-1`"),
    "a request without end": ({"next_time": never}, "started .doze., which never ends"),
    "a refusal of nothing": ({"perform": refuses}, "because of request 17, which is"),
    "a ticket unheard of": ({"cancel": unheard_of}, "failed at test_contract.py:"),
}


def test_complete_world_has_no_errors() -> None:
    assert tried(Whole) == []


@pytest.mark.parametrize("case", WORSE)
def test_each_other_fault_is_told_with_its_place(case: str) -> None:
    parts, said = WORSE[case]
    found = tried(type("Bad", (Whole,), parts))
    assert [line for line in found if re.search(said, line)], found


def test_an_offer_fits_its_options_and_handlers() -> None:
    options = (
        Option("one", "number", "many", "", "a number"),
        Option("one", "flag", False, "", "a flag"),
    )
    offer = Offer(
        {"look": (1, ("dark", "dark"))}, {"spotted": 1, "smelt": 1}, sensors=("see",)
    )
    handlers = Handlers({"lok": looked}, {"spotted": ignored})
    world = with_(kit=Kit(offer, handlers, options))
    make: Any = world
    (first, *_) = try_world(lambda seed: make(random.Random(seed), {}))
    assert first.faults == (
        "duplicate option `one`",
        "the default of the option `one`, 'many', is not of kind number",
        "the results of `look` must be different and include `okay`",
        "the handler of `lok`: unknown name; did you mean `look`?",
        "the sensor `see`: unknown name",
    )


def test_handlers_do_not_run_without_a_library() -> None:
    world, _ = RAISING["a handler"]
    make: Any = world
    trials = try_world(lambda seed: make(random.Random(seed), {}))
    assert faults(trials) == []
    left_out = [trial.part for trial in trials if trial.left_out]
    assert left_out == [SAVING, PICTURE, TRUTH, TIMES, SKILLS, HANDLERS]


def test_handlers_are_checked_against_declared_effects() -> None:
    library = LIBRARY.replace(
        "look (?thing) (okay)", "look (?thing) (okay) :on (okay (not (seen ?thing)))"
    )
    assert "which `:on` does not declare" in " ".join(tried(Good, library))


def test_offer_is_declared() -> None:
    offer = Offer(
        {"look": (2, ("okay", "dark")), "doze": (0, ("okay",))},
        {"seen": 1},
        {":roll": 1},
        {":bump": 30},
        ("look",),
        ("doze",),
    )
    library = declaring(offer)
    text = "\n".join(laid_out(form) for form in library.forms)
    again = load_text(text)
    assert again.diagnostics == ()
    assert again.library.primitives == library.primitives
    assert not library.primitives["doze"].atomic
    assert again.library.data == library.data
    assert again.library.skills == library.skills
    assert again.library.events == library.events
    names = [arg.variable.name for arg in library.events[":bump"].args]
    assert (len(set(names)), names[0], names[27]) == (30, "?a", "?b1")
