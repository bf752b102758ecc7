"""Activations: wiring, sharing, conflicts, events at their edge, saving."""

from __future__ import annotations

import random
from typing import Any

import msgspec
import pytest

from rapc.base.values import Atom
from rapc.console.graphs import NETWORK, dot, mermaid
from rapc.world import Refused
from rapc.worlds.skills.catalogue import Catalogue, SkillRequest
from rapc.worlds.skills.declarations import (
    Channel,
    Event,
    Input,
    Parameter,
    Ports,
    Skill,
    SkillError,
)
from rapc.worlds.skills.runtime import EventTold, SkillRuntime
from tests.worlds.skills.tank import FLOW, GOAL, LIMIT, SMOOTH, Tank

HOLD_TWO = SkillRequest("hold", (2,))


def test_network_connects_declared_channels() -> None:
    tank = Tank()
    parts = [SkillRequest("fill"), SkillRequest("aim", (2,)), SkillRequest("smooth")]
    assert tank.runtime.activate(1, parts, ["reached"]) is None
    tank.run(80)
    assert tank.level == pytest.approx(2, abs=0.1)
    assert [(event, tickets) for _, event, tickets in tank.heard] == [("reached", (1,))]


def test_a_compound_is_its_parts() -> None:
    one, other = Tank(), Tank()
    one.runtime.activate(1, [HOLD_TWO], ["reached"])
    parts = [SkillRequest("fill"), SkillRequest("aim", (2,)), SkillRequest("smooth")]
    other.runtime.activate(1, parts, ["reached"])
    one.run(60)
    other.run(60)
    assert (one.level, one.heard) == (other.level, other.heard)


def test_only_the_events_asked_for_are_told() -> None:
    tank = Tank()
    tank.runtime.activate(1, [HOLD_TWO], [])
    tank.run(80)
    assert tank.level > 1.9
    assert tank.heard == []


def test_an_input_without_a_writer_of_the_same_activation_is_refused() -> None:
    tank = Tank()
    tank.runtime.activate(1, [SkillRequest("smooth")], [])
    refused = tank.runtime.activate(2, [SkillRequest("aim", (2,))], [])
    assert refused == Refused(
        reason="`aim 2` reads `smooth-level`, "
        "which no skill that comes on with it writes"
    )
    assert list(tank.runtime.activations) == [1]


def test_event_of_no_skill_in_the_activation_is_refused() -> None:
    refused = Tank().runtime.activate(1, [SkillRequest("smooth")], ["reached"])
    assert refused == Refused(reason="no skill of the request emits `reached`")


def test_conflict_names_the_request_under_way() -> None:
    tank = Tank()
    tank.runtime.activate(1, [SkillRequest("watch", (1,))], [])
    tank.runtime.activate(2, [HOLD_TWO], [])
    refused = tank.runtime.activate(3, [SkillRequest("hold", (3,))], [])
    assert refused is not None
    assert refused.conflicts == (2,)
    assert refused.reason == "`aim 2` and `aim 3` both write `goal`"
    tank.runtime.deactivate(2)
    assert tank.runtime.activate(3, [SkillRequest("hold", (3,))], []) is None


def test_skills_with_a_common_thing_are_in_conflict() -> None:
    class Flush(Skill):
        """Open the valve wide."""

        name = "flush"
        uses = ("valve",)

        def step(self, now: float, ports: Ports) -> None:
            raise AssertionError("never on")

    class Lock(Flush):
        """Keep the valve where it is."""

        name = "lock"

    runtime = SkillRuntime(Catalogue([Flush, Lock]))
    assert runtime.activate(7, [SkillRequest("flush")], []) is None
    refused = runtime.activate(8, [SkillRequest("lock")], [])
    assert refused == Refused((7,), "`flush` and `lock` both use `valve`")


def test_an_arbiter_decides_between_several_writers() -> None:
    tank = Tank()
    tank.runtime.activate(1, [HOLD_TWO], [])
    tank.run(5)
    assert tank.runtime.value(FLOW) == 1
    tank.runtime.activate(2, [SkillRequest("limit-flow", (0.5,))], [])
    tank.runtime.activate(3, [SkillRequest("limit-flow", (0.25,))], [])
    tank.run(1)
    assert tank.runtime.value(LIMIT) == 0.25
    assert tank.runtime.value(FLOW) == 0.25
    tank.runtime.deactivate(3)
    tank.run(1)
    assert tank.runtime.value(FLOW) == 0.5


def _circle(delayed: bool) -> Catalogue:
    left, right = Channel("left", float), Channel("right", float)

    class One(Skill):
        """Read what the other writes."""

        name = "one"
        inputs = (Input(right, delayed=delayed),)
        outputs = (left,)

        def step(self, now: float, ports: Ports) -> None:
            ports[left] = (ports.get(right) or 0.0) + 1

    class Other(Skill):
        """Read what the one writes."""

        name = "other"
        inputs = (left,)
        outputs = (right,)

        def step(self, now: float, ports: Ports) -> None:
            ports[right] = ports[left] * 2

    class Third(Skill):
        """Write what the others write, in their place."""

        name = "third"
        outputs = (left, right)

        def step(self, now: float, ports: Ports) -> None:
            ports[left] = ports[right] = 0.0

    return Catalogue([One, Other, Third], [], [left, right])


def test_a_circle_without_a_delay_is_refused() -> None:
    runtime = SkillRuntime(_circle(delayed=False))
    refused = runtime.activate(1, [SkillRequest("one"), SkillRequest("other")], [])
    assert refused == Refused(reason="`one` reads `other` reads `one`, without a delay")


def test_a_delayed_input_reads_the_tick_before() -> None:
    catalogue = _circle(delayed=True)
    runtime = SkillRuntime(catalogue)
    runtime.activate(1, [SkillRequest("one"), SkillRequest("other")], [])
    right = catalogue.actuators[1]
    seen = []
    for tick in range(3):
        runtime.tick(tick / 10, {})
        seen.append(runtime.value(right))
    assert seen == [2, 6, 14]
    other = SkillRuntime(catalogue)
    other.restore(runtime.save())
    other.tick(0.3, {})
    assert other.value(right) == 30


def test_a_shared_skill_runs_once_until_its_last_activation_ends() -> None:
    tank = Tank()
    watch = [SkillRequest("watch", (0.5,))]
    tank.runtime.activate(1, [HOLD_TWO], [])
    tank.runtime.activate(2, watch, ["high"])
    tank.runtime.activate(3, watch, ["high"])
    assert tank.runtime.active() == ("smooth", "aim 2", "fill", "watch 0.5")
    tank.run(8)
    assert [tickets for _, _, tickets in tank.heard] == [(2, 3)]
    tank.runtime.deactivate(2)
    assert "watch 0.5" in tank.runtime.active()
    tank.runtime.deactivate(3)
    assert "watch 0.5" not in tank.runtime.active()


def test_equal_numbers_as_arguments_make_one_skill() -> None:
    tank = Tank()
    tank.runtime.activate(1, [SkillRequest("watch", (2,))], [])
    tank.runtime.activate(2, [SkillRequest("watch", (2.0,))], [])
    tank.runtime.activate(3, [SkillRequest("watch", (2.0000001,))], [])
    assert tank.runtime.active() == ("watch 2", "watch 2.0000001")


def test_an_event_speaks_at_its_edge_and_is_armed_again_when_it_fails() -> None:
    tank = Tank()
    tank.runtime.activate(1, [SkillRequest("watch", (1,))], ["high"])
    for level in (0.0, 1.5, 1.6, 0.5, 1.5):
        tank.level = level
        tank.run(1)
    assert [now for now, _, _ in tank.heard] == [0.2, 0.5]


def test_an_event_can_be_told_again_while_it_holds() -> None:
    tank = Tank()
    tank.level = 2
    tank.runtime.activate(1, [SkillRequest("watch", (1,))], ["high"])
    tank.run(50)
    assert [now for now, _, _ in tank.heard] == [0.1, 2.1, 4.1]


def test_late_activation_receives_the_current_state() -> None:
    tank = Tank()
    tank.level = 2
    tank.runtime.activate(1, [SkillRequest("watch", (1,))], ["high"])
    tank.run(3)
    tank.runtime.activate(2, [SkillRequest("watch", (1,))], ["high"])
    tank.run(1)
    assert tank.heard == [(0.1, "high", (1,)), (0.4, "high", (2,))]


def test_disabled_skill_writes_nothing() -> None:
    tank = Tank()
    tank.runtime.activate(1, [HOLD_TWO], [])
    tank.run(3)
    tank.runtime.deactivate(1)
    level = tank.level
    assert tank.runtime.value(FLOW) is None
    tank.run(3)
    assert tank.level == level


def test_unused_sensors_are_not_read() -> None:
    tank = Tank()
    tank.sensors = {}
    tank.runtime.activate(1, [SkillRequest("limit-flow", (1,))], [])
    tank.run(3)
    assert tank.runtime.value(LIMIT) == 1


def test_a_ticket_serves_once() -> None:
    tank = Tank()
    tank.runtime.activate(1, [HOLD_TWO], [])
    with pytest.raises(ValueError, match="1 is under way"):
        tank.runtime.activate(1, [HOLD_TWO], [])


def test_skill_reads_only_declared_channels() -> None:
    a, b = Channel("a", float), Channel("b", float)

    class Sneak(Skill):
        """Do what is asked for."""

        name = "sneak"
        inputs = (Input(a, optional=True),)
        does: Any = None

        def step(self, now: float, ports: Ports) -> None:
            type(self).does(ports)

    def tried(does: Any) -> None:
        Sneak.does = staticmethod(does)
        runtime = SkillRuntime(Catalogue([Sneak], [a]))
        runtime.activate(1, [SkillRequest("sneak")], [])
        runtime.tick(0, {"a": lambda: 1.0})

    tried(lambda ports: ports[a])
    with pytest.raises(
        SkillError, match=r"`sneak` \(Sneak\) reads `b`, which it does not"
    ):
        tried(lambda ports: ports[b])
    with pytest.raises(SkillError, match=r"`sneak` \(Sneak\) reads `b`"):
        tried(lambda ports: ports.get(b))
    with pytest.raises(SkillError, match=r"`sneak` \(Sneak\) writes `a`"):
        tried(lambda ports: ports.__setitem__(a, 1.0))


def test_missing_required_input_is_a_fault_of_its_writer() -> None:
    a = Channel("a", float)

    class Silent(Skill):
        """Write nothing."""

        name = "silent"
        outputs = (a,)

        def step(self, now: float, ports: Ports) -> None:
            pass

    class Reader(Skill):
        """Read it."""

        name = "reader"
        inputs = (a,)

        def step(self, now: float, ports: Ports) -> None:
            ports[a]

    runtime = SkillRuntime(Catalogue([Silent, Reader]))
    runtime.activate(1, [SkillRequest("silent"), SkillRequest("reader")], [])
    with pytest.raises(SkillError, match=r"before `reader` \(Reader\)"):
        runtime.tick(0, {})


def _walk(rng: random.Random, tank: Tank, moments: int) -> None:
    """Switch skills on and off at random."""
    for _ in range(moments):
        known = sorted(tank.runtime.activations)
        if known and rng.random() < 0.4:
            tank.runtime.deactivate(rng.choice(known))
        else:
            name, value = rng.choice([("hold", 2), ("watch", 1), ("limit-flow", 0.5)])
            events = {"hold": ["reached"], "watch": ["high"]}.get(name, [])
            ticket = max(known, default=0) + 1 + tank.ticks
            tank.runtime.activate(ticket, [SkillRequest(name, (value,))], events)
        tank.run(rng.randrange(12))


@pytest.mark.parametrize("seed", range(20))
def test_a_saved_runtime_goes_on_as_if_nothing_had_been(seed: int) -> None:
    rng = random.Random(seed)
    tank, other = Tank(), Tank()
    _walk(rng, tank, 12)
    _walk(random.Random(seed + 1), other, 5)
    saved = tank.runtime.save()
    other.runtime.restore(saved)
    assert other.runtime.save() == saved
    other.level, other.ticks, other.heard = tank.level, tank.ticks, []
    tank.heard = []
    state = rng.getstate()
    _walk(rng, tank, 8)
    rng.setstate(state)
    _walk(rng, other, 8)
    assert (other.level, other.heard) == (tank.level, tank.heard)
    assert other.runtime.save() == tank.runtime.save()


@pytest.mark.parametrize(
    "bad", [b"", b"{}", b'{"activations": 3}', b"[1]", b"\xff\xfe"]
)
def test_wrong_state_is_refused_and_changes_nothing(bad: bytes) -> None:
    tank = Tank()
    tank.runtime.activate(1, [HOLD_TWO], [])
    tank.run(3)
    before = tank.runtime.save()
    with pytest.raises(ValueError, match="no state of these skills"):
        tank.runtime.restore(bad)
    assert tank.runtime.save() == before


def test_a_drawing_shows_sensors_skills_events_and_actuators() -> None:
    tank = Tank()
    tank.runtime.activate(1, [HOLD_TWO], ["reached"])
    tank.runtime.activate(2, [SkillRequest("limit-flow", (0.5,))], [])
    drawing = tank.runtime.network.graph()
    assert {(box.label, box.kind) for box in drawing.vertices} == {
        ("level", "sensor"),
        ("smooth", "skill"),
        ("aim 2", "skill"),
        ("fill", "skill"),
        ("limit-flow 0.5", "skill"),
        ("reached", "event"),
        ("arbiter of limit", "arbiter"),
        ("flow", "actuator"),
    }
    ends = {(edge.source, edge.target): edge.label for edge in drawing.edges}
    assert ends["level", "smooth"] == "level"
    assert ends["aim 2", "fill"] == GOAL.name
    assert ends["smooth", "reached of aim 2"] == SMOOTH.name
    assert ends["aim 2", "reached of aim 2"] == "gap"
    assert ends["limit-flow 0.5", "arbiter of limit"] == "limit"
    assert ends["arbiter of limit", "fill"] == "limit"
    assert ends["fill", "flow (actuator)"] == "flow"
    graphviz, flowchart = dot(drawing, NETWORK), mermaid(drawing, NETWORK)
    assert '"aim 2" -> "fill" [label="goal"];' in graphviz
    assert graphviz.count("->") == flowchart.count("-->") == len(drawing.edges)


def test_a_delayed_edge_is_drawn_dashed() -> None:
    runtime = SkillRuntime(_circle(delayed=True))
    runtime.activate(1, [SkillRequest("one"), SkillRequest("other")], [])
    drawing = runtime.network.graph()
    assert '"other" -> "one" [label="right", style=dashed];' in dot(drawing, NETWORK)
    assert '-.->|"right"|' in mermaid(drawing, NETWORK)


class Ticks(msgspec.Struct):
    """How often a skill has been stepped."""

    ticks: int = 0


class Dialled(Event):
    """The valve is open; with the opening and the ticks so far."""

    name = "dialled"
    inputs = (FLOW,)
    carries = (Parameter("most", "number"), Parameter("flow", "number"))

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        return (self.arguments["most"], ports[FLOW])


class Dial(Skill):
    """Open the valve as far as told, and count the ticks."""

    name = "dial"
    outputs = (FLOW,)
    parameters = (Parameter("most", "number", "m/s"),)
    events = (Dialled,)
    uses = ("valve",)
    single = True
    State = Ticks
    state: Ticks

    def step(self, now: float, ports: Ports) -> None:
        self.state.ticks += 1
        ports[FLOW] = float(self.arguments["most"])


def test_single_skill_has_the_arguments_of_the_newest_activation() -> None:
    runtime = SkillRuntime(Catalogue([Dial], [], [FLOW]))
    flows = []

    def tick(now: float) -> list[EventTold]:
        told = runtime.tick(now, {})
        flows.append(runtime.value(FLOW))
        return told

    assert runtime.activate(1, [SkillRequest("dial", (1,))], ["dialled"]) is None
    [told] = tick(0.1)
    assert (told.arguments, told.tickets) == ((1, 1), (1,))
    assert runtime.activate(2, [SkillRequest("dial", (3,))], ["dialled"]) is None
    assert runtime.active() == ("dial",)
    [told] = tick(0.2)
    assert (told.arguments, told.tickets) == ((3, 3), (2,))
    other = SkillRuntime(Catalogue([Dial], [], [FLOW]))
    other.restore(runtime.save())
    other.tick(0.3, {})
    assert (other.value(FLOW), other.save()) == (3, (tick(0.3), runtime.save())[1])
    runtime.deactivate(2)
    assert tick(0.4) == []
    assert '"ticks":4' in runtime.save().decode()
    assert flows == [1, 3, 3, 1]
