"""`SkillWorld`: what it does for a world, and what it says of one that slips."""

from __future__ import annotations

import re
from collections.abc import Iterable
from random import Random
from typing import Any

import msgspec
import pytest

from rapc.base.source import SourceFile
from rapc.base.values import Atom
from rapc.compiler.program import Program
from rapc.errors import PortError
from rapc.events import MethodEnded
from rapc.library.library import link
from rapc.parser.parse import parse
from rapc.runtime.held_world import HeldWorld
from rapc.runtime.interpreter import Interpreter
from rapc.world import NOT_KNOWN, Kit, Signal
from rapc.worlds.skills.catalogue import Catalogue
from rapc.worlds.skills.declarations import Event, Parameter, Ports, Skill
from rapc.worlds.skills.runtime import EventTold, SkillRuntime
from rapc.worlds.skills.world import SkillWorld, offer
from tests.worlds.skills.tank import FLOW, catalogue


class Water(msgspec.Struct):
    """What changes in the tank."""

    level: float = 0.0


class TankWorld(SkillWorld):
    """The tank behind the port."""

    name = "tank"
    kit = Kit(offer(catalogue(), {":leak": 0}))

    def __init__(self, level: float = 0) -> None:
        super().__init__(SkillRuntime(catalogue()), Water(level))

    def tick(self) -> Iterable[EventTold]:
        told = self.runtime.tick(self.time, {"level": lambda: self.state.level})
        self.state.level += (self.runtime.value(FLOW) or 0.0) / 10
        return told


def _filling() -> TankWorld:
    world = TankWorld()
    assert world.activate(1, [(":hold", 2)], [":reached"]) is None
    return world


def test_time_stops_at_the_first_signal() -> None:
    world = _filling()
    assert world.next_time() == NOT_KNOWN
    world.advance(100)
    assert world.next_time() == world.now() == world.time
    assert world.now() < 100
    [signal] = world.messages()
    assert isinstance(signal, Signal)
    assert (signal.content[0], signal.tickets) == (":reached", (1,))
    assert signal.content[1] == pytest.approx(2, abs=0.2)
    world.deactivate(1)
    world.advance(100)
    assert (world.now(), world.messages()) == (100, [])


def test_a_saved_world_goes_on_as_if_nothing_had_been() -> None:
    world, other = _filling(), TankWorld()
    world.advance(1)
    other.restore(world.save())
    assert other.save() == world.save()
    for one in (world, other):
        one.advance(50)
    assert other.messages() == world.messages()
    assert other.save() == world.save()


def test_a_whole_number_in_the_state_is_saved_as_it_is_read() -> None:
    world, other = TankWorld(1), TankWorld()
    other.restore(world.save())
    assert other.save() == world.save()


class RainyWorld(TankWorld):
    """A tank with rain."""

    def __init__(self, seed: int) -> None:
        SkillWorld.__init__(self, SkillRuntime(catalogue()), Water(), Random(seed))

    def tick(self) -> Iterable[EventTold]:
        self.state.level += self.rng.random()
        return super().tick()


def test_the_random_stream_is_saved_with_the_world() -> None:
    world, other = RainyWorld(1), RainyWorld(2)
    world.advance(1)
    other.restore(world.save())
    for one in (world, other):
        one.advance(50)
    assert other.save() == world.save()
    assert world.state.level > 0


def test_a_state_without_the_random_stream_is_refused() -> None:
    with pytest.raises(ValueError, match="the random stream is missing or unexpected"):
        RainyWorld(1).restore(TankWorld().save())
    with pytest.raises(ValueError, match="the random stream is missing or unexpected"):
        TankWorld().restore(RainyWorld(1).save())


@pytest.mark.parametrize(
    "bad", [b"{", b"{}", b'{"now":0,"ticks":0,"sent":[],"rest":3}']
)
def test_wrong_state_is_refused_and_changes_nothing(bad: bytes) -> None:
    world = _filling()
    before = world.save()
    with pytest.raises(ValueError, match="no state of the world `tank`"):
        world.restore(bad)
    assert world.save() == before


def test_more_events_are_offered() -> None:
    assert TankWorld.kit.offer.events[":leak"] == 0
    assert TankWorld.kit.offer.events[":reached"] == 1


def test_there_are_no_primitives() -> None:
    with pytest.raises(ValueError, match="the world `tank` has no primitive `drain`"):
        TankWorld().perform(1, ("drain",))


@pytest.mark.parametrize("returned", [None, 3, ["reached"]])
def test_tick_with_a_wrong_result_is_named(returned: Any) -> None:
    kind: Any = type("Odd", (TankWorld,), {"tick": lambda self: returned})
    with pytest.raises(PortError, match=r"`tick` of the world `tank` .*test_world.py"):
        kind().advance(1)


def test_uninitialised_world_is_named() -> None:
    class Odd(TankWorld):
        def __init__(self) -> None:
            """Forget what SkillWorld needs."""

    with pytest.raises(PortError, match="of the class Odd does not call that"):
        Odd().now()
    with pytest.raises(PortError, match="of the class Odd does not call that"):
        Odd().advance(1)


def test_event_test_returning_true_is_named() -> None:
    class Said(Event):
        name = "said"

        def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
            return True  # type: ignore[return-value]

    class Say(Skill):
        name = "say"
        events = (Said,)

        def step(self, now: float, ports: Ports) -> None:
            """Do nothing."""

    world = TankWorld()
    world.runtime = SkillRuntime(Catalogue([Say]))
    world.activate(1, [(":say",)], [":said"])
    with pytest.raises(PortError, match="`test` of the class Said returns a tuple"):
        world.advance(1)


def test_refusal_gives_its_reason_as_the_cause_of_the_failure() -> None:
    library = """
        (declare-skill :aim (?height))
        (declare-event :reached (?level))
        (define-rap (top)
          (method (primitive (enable (:aim 1)) (wait-for (:reached ?) :succeed))))"""
    ended: list[MethodEnded] = []
    parsed, wrong = link([parse(SourceFile("t.rap", library))])
    assert not wrong
    interpreter = Interpreter(Program(parsed, "t"), TankWorld(), 0)
    interpreter.listen(ended.append, MethodEnded)  # type: ignore[arg-type]
    interpreter.start()
    interpreter.submit("(top)")
    interpreter.run(until=5)
    cause = ended[0].because
    assert cause is not None
    assert cause.note == (
        "the world refused it: `aim 1` reads `smooth-level`, which no skill that comes "
        "on with it writes"
    )


def test_breach_of_an_inherited_method_names_the_class_of_the_author() -> None:
    message = str(HeldWorld(TankWorld()).breach("restore", "goes wrong"))
    assert re.search(r"see `restore` of `TankWorld` \(test_world.py:\d+\)$", message)


class Dial(Skill):
    """Open the valve as far as told."""

    name = "dial"
    outputs = (FLOW,)
    parameters = (Parameter("most", "number", "m/s"),)
    uses = ("valve",)
    single = True

    def step(self, now: float, ports: Ports) -> None:
        ports[FLOW] = float(self.arguments["most"])


class DialWorld(TankWorld):
    """A tank whose valve is a single skill."""

    kit = Kit(offer(Catalogue([Dial], [], [FLOW])))

    def __init__(self) -> None:
        super().__init__()
        self.runtime = SkillRuntime(Catalogue([Dial], [], [FLOW]))
        self.flows: list[float | None] = []

    def tick(self) -> Iterable[EventTold]:
        told = super().tick()
        self.flows.append(self.runtime.value(FLOW))
        return told


def test_descendant_changes_the_arguments_of_a_single_skill() -> None:
    library = """
        (declare-skill :dial (?most) :events () :uses (valve))
        (define-rap (top)
          (method (skills (:dial 1))
            (task-net (t1 (wait 1) (for t2)) (t2 (more) (for t3)) (t3 (wait 3)))))
        (define-rap (more) (method (skills (:dial 5)) (task-net (t1 (wait 1)))))
        (define-rap (wait ?for) (succeed true) (monitor-time now ?for 99))"""
    parsed, wrong = link([parse(SourceFile("t.rap", library))])
    assert not wrong
    world = DialWorld()
    interpreter = Interpreter(Program(parsed, "t"), world, 0)
    interpreter.start()
    interpreter.submit("(top)")
    interpreter.run(until=10)
    assert interpreter.results()[0].outcome == "succeeded"
    assert world.flows == [1] * 10 + [5] * 10 + [1] * 10
