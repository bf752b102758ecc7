"""What is on a channel, and what an event carries, is what was declared."""

from __future__ import annotations

from typing import Any

import pytest

from rapc.errors import PortError
from rapc.worlds.skills.catalogue import Catalogue, SkillRequest
from rapc.worlds.skills.declarations import (
    Arbiter,
    Channel,
    Event,
    Parameter,
    Ports,
    Skill,
    SkillError,
)
from rapc.worlds.skills.runtime import SkillRuntime

HEAT = Channel("heat", float, "degrees")
WAY = Channel("way", tuple[float, ...], "m")
SAID = Channel("said", str)
ANY: Channel[Any] = Channel("any", Any)
EITHER: Channel[Any] = Channel("either", int | None)  # type: ignore[arg-type]


class Hot(Event):
    """It is hot."""

    name = "hot"
    inputs = (HEAT,)
    carries = (Parameter("heat", "number"),)
    says: Any = (1,)

    def test(self, now: float, ports: Ports) -> Any:
        return self.says


class Write(Skill):
    """Write what is asked for."""

    name = "write"
    inputs = (HEAT,)
    outputs = (WAY, SAID, ANY, EITHER)
    events = (Hot,)
    writes: Any = (SAID, "well")

    def step(self, now: float, ports: Ports) -> None:
        channel, value = self.writes
        ports[channel] = value


class First(Arbiter):
    """Decide wrongly."""

    channel = SAID

    def decide(self, values: list[Any]) -> Any:
        return 3


def tick(sensors: Any, arbiters: tuple[Arbiter, ...] = ()) -> SkillRuntime:
    """Return a runtime after one tick."""
    runtime = SkillRuntime(Catalogue([Write], [HEAT], Write.outputs, arbiters))
    assert runtime.activate(1, [SkillRequest("write")], ["hot"]) is None
    runtime.tick(0.1, sensors)
    return runtime


WARM = {"heat": lambda: 20}


@pytest.mark.parametrize(
    "writes",
    [(WAY, (1.0, 2)), (SAID, "well"), (ANY, object()), (EITHER, None), (EITHER, 3)],
)
def test_channel_receives_its_declared_value(
    writes: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Write, "writes", writes)
    assert tick(WARM).value(writes[0]) is writes[1]


@pytest.mark.parametrize(
    ("writes", "said"),
    [
        ((SAID, 3), "writes 3 to `said`, which is str"),
        ((WAY, 1.0), r"writes 1.0 to `way`, which is tuple\[float, ...\] in m"),
        ((EITHER, "3"), r"writes '3' to `either`, which is int \| None"),
        ((WAY, (1.0, "2")), r"writes \(1.0, '2'\) to `way`, which is tuple.* in m"),
        ((WAY, (True,)), r"writes \(True,\) to `way`, which is tuple.* in m"),
        ((EITHER, True), r"writes True to `either`, which is int \| None"),
    ],
)
def test_skill_output_has_the_type_of_the_channel(
    writes: Any, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Write, "writes", writes)
    with pytest.raises(SkillError, match=r"^`write` \(Write\) " + said + "$"):
        tick(WARM)


@pytest.mark.parametrize(
    ("sensors", "said"),
    [
        ({"heat": lambda: "hot"}, "is 'hot', and the channel float in degrees"),
        ({"heat": lambda: True}, "is True, and the channel float in degrees"),
        ({"heat": 20}, "is read by calling a function, not 20"),
        ({}, "is given no function that reads it"),
    ],
)
def test_sensor_value_has_the_type_of_the_channel(sensors: Any, said: str) -> None:
    with pytest.raises(SkillError, match=f"^the sensor `heat` {said}$"):
        tick(sensors)


def test_arbiter_result_has_the_type_of_the_channel() -> None:
    with pytest.raises(
        SkillError, match=r"^the class First decides on 3 for `said`, w"
    ):
        tick(WARM, (First(),))


@pytest.mark.parametrize(
    ("says", "said"),
    [
        (20, "returns a tuple or None, not 20"),
        ((), "returns 1 value, as `carries` says, not 0"),
        ((1, 2), "returns 1 value, as `carries` says, not 2"),
        (("hot",), "returns 'hot': `heat` must be a number"),
        (({},), "returns {}: `heat` must be a number"),
    ],
)
def test_event_values_have_declared_kinds(
    says: Any, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Hot, "says", says)
    with pytest.raises(PortError) as fault:
        tick(WARM)
    assert str(fault.value).startswith(
        f"`test` of the class Hot {said} (test_values.py"
    )
