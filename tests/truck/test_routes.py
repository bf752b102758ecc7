"""The route planner: what it returns for maps given as plain facts."""

from __future__ import annotations

from rapc.base.values import Atom, Fact
from rapc.ir.nodes import And, Const, For, TaskNet
from rapc.worlds.truck.routes import find_route, plan_route


class Facts:
    """A memory that holds a few facts and nothing else."""

    def __init__(self, *facts: Fact) -> None:
        self.facts = facts

    def query(self, *pattern: Atom | None) -> list[Fact]:
        """As `HandlerMemory.query`."""
        return [
            fact
            for fact in self.facts
            if len(fact) == len(pattern)
            and all(p is None or p == f for p, f in zip(pattern, fact, strict=True))
        ]


def road(name: str, a: str, direction: str, b: str, time: float) -> tuple[Fact, Fact]:
    """A road one way, with the time it takes."""
    return ("road", name, a, direction, b), ("road-time", name, time)


DIAMOND = Facts(
    *road("r1", "a", "east", "b", 10),
    *road("r2", "b", "east", "d", 10),
    *road("r3", "a", "south", "c", 5),
    *road("r4", "c", "east", "d", 20),
    *road("r5", "d", "north", "a", 1),
)


def test_takes_the_quickest_roads_not_the_fewest() -> None:
    assert [leg[2] for leg in find_route(DIAMOND, "a", "d")] == ["b", "d"]
    longer = Facts(*DIAMOND.facts, *road("r6", "c", "west", "e", 1))
    quick = Facts(*longer.facts, *road("r7", "e", "south", "d", 1))
    assert [leg[2] for leg in find_route(quick, "a", "d")] == ["c", "e", "d"]


def test_of_equal_routes_takes_the_first_of_the_map() -> None:
    left = (*road("r1", "a", "west", "b", 1), *road("r2", "b", "west", "d", 1))
    right = (*road("r3", "a", "east", "c", 1), *road("r4", "c", "east", "d", 1))
    assert find_route(Facts(*left, *right), "a", "d")[0][2] == "b"
    assert find_route(Facts(*right, *left), "a", "d")[0][2] == "c"


def test_roads_lead_one_way_unless_a_second_fact_says_so() -> None:
    assert find_route(DIAMOND, "b", "a") != ()
    assert find_route(Facts(*road("r1", "a", "east", "b", 1)), "b", "a") == ()


def test_no_way_and_no_journey_give_no_method() -> None:
    assert plan_route(("travel-route", "a", "nowhere"), DIAMOND) == ()
    assert plan_route(("travel-route", "a", "a"), DIAMOND) == ()


def test_a_route_becomes_a_method_for_these_two_places() -> None:
    (method,) = plan_route(("travel-route", "a", "d"), DIAMOND)
    assert method.name == "a-to-d"
    assert isinstance(method.context, And)
    assert isinstance(method.body, TaskNet)
    first, second = method.body.steps
    assert first.goal.args == (Const("a"), Const("east"), Const("b"))
    assert first.annotations == (For(None, "t2"),)
    assert second.goal.args == (Const("b"), Const("east"), Const("d"))
    assert second.annotations == ()
