"""Declarations that cannot work together are refused before anything runs."""

from __future__ import annotations

import re
from typing import Any

import pytest

from rapc.base.values import Atom, Text
from rapc.worlds.skills.catalogue import Catalogue, SkillRequest
from rapc.worlds.skills.checks import CatalogueError
from rapc.worlds.skills.declarations import (
    Arbiter,
    Channel,
    Compound,
    Event,
    Parameter,
    Ports,
    Skill,
)
from tests.worlds.skills.tank import (
    FLOW,
    GOAL,
    HOLD,
    LEVEL,
    SMOOTH,
    Aim,
    Fill,
    LimitFlow,
    LowestLimit,
    Smooth,
    catalogue,
)


def test_compound_emits_and_uses_the_same_as_its_parts() -> None:
    hold = catalogue().describe("hold")
    assert hold.events == ("reached",)
    assert hold.uses == ("valve",)
    assert [p.name for p in hold.parameters] == ["height"]
    assert hold.doc == "Hold a level."


def test_an_input_needs_a_writer() -> None:
    with pytest.raises(CatalogueError, match=r"\(Fill\) reads `goal`, which nothing"):
        Catalogue([Smooth, Fill], [LEVEL])


def test_an_actuator_needs_a_writer() -> None:
    with pytest.raises(CatalogueError, match="no skill writes the actuator `goal`"):
        Catalogue([Smooth], [LEVEL], [GOAL])


def test_a_name_stands_for_one_channel() -> None:
    class Other(Skill):
        """Read feet."""

        name = "other"
        inputs = (Channel("level", float, "ft"),)
        step = Smooth.step

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
    with pytest.raises(CatalogueError, match=r"number in ft, but .* number in m$"):
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
        step = Smooth.step

    with pytest.raises(CatalogueError, match="duplicate event `reached`"):
        Catalogue([Smooth, Aim, Other], [LEVEL])


def test_a_parameter_is_of_a_known_kind() -> None:
    class Odd(Skill):
        """Take something odd."""

        name = "odd"
        parameters = (Parameter("x", "colour"),)
        step = Smooth.step

    with pytest.raises(CatalogueError, match="kind `colour` of `x`"):
        Catalogue([Odd])


class Nowhere(Arbiter):
    """An arbiter without a channel."""

    def decide(self, values: list[Any]) -> Any:
        return values[0]


def test_an_arbiter_decides() -> None:
    class Undecided(Arbiter):
        channel = LEVEL

    with pytest.raises(TypeError, match="decide"):
        Undecided()  # type: ignore[abstract]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((Smooth,), "`skills` of a catalogue is a list of skills, not <class"),
        (([Smooth], LEVEL), "`sensors` of a catalogue is a list of channels, not <ch"),
        (([Smooth], "level"), "`sensors` of a catalogue is a list of channels, not 'l"),
        (([Smooth], ["level"]), "`sensors` of a catalogue has channels, not 'level'"),
        (([Smooth], [LEVEL], GOAL), "`actuators` of a catalogue is a list"),
        (([Smooth], [LEVEL], [], 3), "`arbiters` of a catalogue is a list of arbiters"),
        (([Smooth], [LEVEL], [], [Smooth]), "has arbiters, not <class '.*Smooth'>"),
        (([Smooth], [LEVEL], [], [LowestLimit]), "has arbiters, not <class '.*Limit'>"),
        (([Smooth], [LEVEL], [], [Nowhere()]), "the class Nowhere has no `channel`"),
    ],
)
def test_a_catalogue_is_made_of_lists(given: Any, said: str) -> None:
    with pytest.raises(CatalogueError, match=said):
        Catalogue(*given)


A, B = Channel("a", float), Channel("b", float)


@pytest.mark.parametrize(
    ("has", "fault"),
    [
        ({"name": None}, "the class Odd has no `name`"),
        ({"name": "An odd one"}, "the name of the class Odd is a symbol"),
        ({"step": Skill.step}, "the class Odd does not define `step`"),
        ({"inputs": LEVEL}, "`inputs` of the class Odd is no tuple; one of a single"),
        ({"inputs": ("level",)}, "`inputs` of the class Odd has channels, not 'level'"),
        ({"outputs": A}, "`outputs` of the class Odd is no tuple"),
        ({"parameters": Parameter("x", "number")}, "`parameters` of the class Odd is"),
        ({"uses": "valve"}, "`uses` of the class Odd is no tuple"),
        ({"events": Event}, "`events` of the class Odd is no tuple"),
        ({"events": (Aim,)}, "`events` of the class Odd has classes of events"),
        ({"State": dict}, "`State` of the class Odd is no msgspec struct"),
    ],
)
def test_incomplete_class_is_named(has: dict[str, object], fault: str) -> None:
    body = {"name": "odd", "step": Smooth.step, **has}
    odd = type("Odd", (Skill,), body)
    with pytest.raises(CatalogueError, match=re.escape(fault)):
        Catalogue([odd], [LEVEL])


def test_an_event_needs_a_test() -> None:
    silent = type("Silent", (Event,), {"name": "silent"})
    odd = type("Odd", (Skill,), {"name": "odd", "events": (silent,), "step": Aim.step})
    with pytest.raises(CatalogueError, match="the class Silent does not define `test`"):
        Catalogue([odd])


def test_a_catalogue_has_classes() -> None:
    with pytest.raises(CatalogueError, match="has classes of skills, and compounds"):
        Catalogue([Smooth({})], [LEVEL])  # type: ignore[list-item]


def _writing(name: str, *inputs: Channel[float], output: Channel[float]) -> type[Skill]:
    body = {
        "name": name,
        "inputs": inputs,
        "outputs": (output,),
        "step": Smooth.step,
    }
    return type(name.title(), (Skill,), body)


def test_cyclic_skills_require_a_delay() -> None:
    one, other = _writing("one", A, output=B), _writing("other", B, output=A)
    with pytest.raises(CatalogueError, match=r" \(One\) reads .*without a delay"):
        Catalogue([one, other])
    thirds = (_writing("third", output=A), _writing("fourth", output=B))
    Catalogue([one, other, *thirds], [], [A, B])


def test_parts_of_a_compound_write_a_channel_each_or_have_an_arbiter() -> None:
    both = (_writing("one", output=A), _writing("other", output=A))
    Catalogue(both, [], [A])
    fault = r"`one` \(One\) and `other` \(Other\), which come on together, both write"
    with pytest.raises(CatalogueError, match=fault):
        Catalogue([Compound("both", both)])


def _skill(**has: object) -> type[Skill]:
    return type("Odd", (Skill,), {"name": "odd", "step": Smooth.step, **has})


class _Twice(LowestLimit):
    channel = A


_OWN = Channel("own-one", float, own=True)
_NAN = float("nan")
_WRONG: list[tuple[tuple[Any, ...], str]] = [
    (([_skill(outputs=(LEVEL,))], [LEVEL]), "writes the sensor `level`"),
    (([_skill(outputs=(A,))],), "writes `a`, which nothing reads; a channel that"),
    (([_writing("one", output=A)], [], [A], [_Twice(), _Twice()]), "two arbiters for"),
    (([Smooth], [LEVEL], [SMOOTH], [_Twice()]), "no skill writes `a`, which has an"),
    (
        ([_skill(inputs=(Channel("level", float, "m"),))], [LEVEL]),
        "another channel `level` than other classes: use the same `Channel` object",
    ),
    (
        ([_writing("one", output=_OWN), _skill(inputs=(_OWN,))],),
        "`odd` (Odd) reads `own-one`, an `own` channel, which only the events of "
        "`one` (One) can read",
    ),
    (
        ([_skill(parameters=(Parameter("x", "number", low=2, high=1),))],),
        "`odd` (Odd): `low` of `x` is above `high`",
    ),
    (
        ([_skill(parameters=(Parameter("x", "number", high=_NAN),))],),
        "`odd` (Odd): a bound of `x` is not a number",
    ),
    (
        ([Compound("both", (Smooth, Smooth))], [LEVEL]),
        "`both` has the part `smooth` twice",
    ),
    (
        ([Compound("only", (Smooth,), Aim.parameters)], [LEVEL]),
        "no part of `only` has a parameter `height`",
    ),
]


@pytest.mark.parametrize(("given", "fault"), _WRONG)
def test_wrong_network_is_refused(given: tuple[Any, ...], fault: str) -> None:
    with pytest.raises(CatalogueError, match=re.escape(fault)):
        Catalogue(*given)


def test_arbiter_is_allowed_for_one_writer() -> None:
    Catalogue([_writing("one", output=A)], [], [A], [_Twice()])


@pytest.mark.parametrize(
    ("request_", "fault"),
    [
        (SkillRequest("drain"), "unknown skill `drain`"),
        (SkillRequest("aim"), "`aim` takes 1 arguments, not 0"),
        (SkillRequest("aim", ("high",)), "`aim`: `height` must be a number"),
        (SkillRequest("aim", (Text("high"),)), "`aim`: `height` must be a number"),
        (SkillRequest("aim", (-1,)), "`aim`: `height` must not be below 0"),
        (SkillRequest("aim", (11,)), "`aim`: `height` must not be above 10"),
        (SkillRequest("aim", (10,)), None),
    ],
)
def test_a_request_is_held_to_the_declaration(
    request_: SkillRequest, fault: str | None
) -> None:
    assert catalogue().fault(request_) == fault


class Leap(Fill):
    """Open the valve wide."""

    def step(self, now: float, ports: Ports) -> None:
        ports[FLOW] = 5.0


def test_an_extended_catalogue_replaces_a_skill_in_compounds_too() -> None:
    extended = catalogue().extended([Leap])
    assert list(extended.entries) == list(catalogue().entries)
    assert extended.entries["fill"] is Leap
    assert extended.parts("hold") == (Smooth, Aim, Leap)
    assert catalogue().parts("hold") == (Smooth, Aim, Fill)


def test_an_extended_catalogue_replaces_a_part_that_is_no_skill_of_its_own() -> None:
    hold = Catalogue([HOLD, LimitFlow], [LEVEL], [FLOW]).extended([Leap])
    assert list(hold.entries) == ["hold", "limit-flow"]
    assert hold.parts("hold") == (Smooth, Aim, Leap)


def test_an_extended_catalogue_is_checked() -> None:
    class Deep(Aim):
        """Aim at nothing."""

        parameters = ()  # type: ignore[assignment]

    with pytest.raises(CatalogueError, match="no part of `hold` has a parameter"):
        catalogue().extended([Deep])
    with pytest.raises(CatalogueError, match="has classes of skills, and compounds"):
        catalogue().extended([3])  # type: ignore[list-item]
