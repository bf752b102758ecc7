"""Declarations that cannot work together are refused before anything runs."""

from __future__ import annotations

import pytest

from rapc.base.values import Atom, Text
from rapc.worlds.skills.catalogue import Catalogue, CatalogueError, Request
from rapc.worlds.skills.declarations import (
    Channel,
    Compound,
    Event,
    Parameter,
    Ports,
    Skill,
)
from tests.worlds.skills.tank import GOAL, HOLD, LEVEL, Aim, Fill, Smooth, catalogue


def test_a_compound_tells_and_uses_what_its_parts_do() -> None:
    hold = catalogue().describe("hold")
    assert hold.events == ("reached",)
    assert hold.uses == ("valve",)
    assert [p.name for p in hold.parameters] == ["height"]
    assert hold.doc == "Hold a level."


def test_an_input_needs_a_writer() -> None:
    with pytest.raises(CatalogueError, match=r"`fill` reads `goal`, which nothing"):
        Catalogue([Smooth, Fill], [LEVEL])


def test_an_actuator_needs_a_writer() -> None:
    with pytest.raises(CatalogueError, match="the world` reads `goal`"):
        Catalogue([Smooth], [LEVEL], [GOAL])


def test_a_name_stands_for_one_channel() -> None:
    class Other(Skill):
        """Read feet."""

        name = "other"
        inputs = (Channel("level", float, "ft"),)

    with pytest.raises(CatalogueError, match="float in ft instead of float in m"):
        Catalogue([Smooth, Other], [LEVEL])


def test_a_name_stands_for_one_skill() -> None:
    with pytest.raises(CatalogueError, match="two skills are named `hold`"):
        Catalogue([HOLD, HOLD], [LEVEL])


def test_a_compound_has_the_parameters_of_its_parts() -> None:
    bare = Compound("bare", (Smooth, Aim))
    with pytest.raises(CatalogueError, match="no parameter `height` for its part"):
        Catalogue([bare], [LEVEL])
    feet = Compound("feet", (Smooth, Aim), (Parameter("height", "number", "ft"),))
    with pytest.raises(CatalogueError, match="`height` of `feet` is not what"):
        Catalogue([feet], [LEVEL])


def test_an_event_carries_the_same_wherever_it_is_told() -> None:
    class Reached(Event):
        """Another event of the same name."""

        name = "reached"

        def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
            return None

    class Other(Skill):
        """Tell the other one."""

        name = "other"
        events = (Reached,)

    with pytest.raises(CatalogueError, match="`reached` is declared twice"):
        Catalogue([Smooth, Aim, Other], [LEVEL])


def test_a_parameter_is_of_a_known_kind() -> None:
    class Odd(Skill):
        """Take something odd."""

        name = "odd"
        parameters = (Parameter("x", "colour"),)

    with pytest.raises(CatalogueError, match="kind `colour` of `x`"):
        Catalogue([Odd])


@pytest.mark.parametrize(
    ("request_", "fault"),
    [
        (Request("drain"), "there is no skill `drain`"),
        (Request("aim"), "`aim` takes 1 arguments, not 0"),
        (Request("aim", ("high",)), "`aim`: `height` must be a number"),
        (Request("aim", (Text("high"),)), "`aim`: `height` must be a number"),
        (Request("aim", (-1,)), "`aim`: `height` must not be below 0"),
        (Request("aim", (11,)), "`aim`: `height` must not be above 10"),
        (Request("aim", (10,)), None),
    ],
)
def test_a_request_is_held_to_the_declaration(
    request_: Request, fault: str | None
) -> None:
    assert catalogue().fault(request_) == fault
