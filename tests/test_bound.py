"""`bench.bound`: the planner's answers to problems that can be worked out by hand."""

from __future__ import annotations

from bench.bound import Problem, problem, quickest


def on_a_line(made: list[list[float]], sources: list[list[str]]) -> Problem:
    """A pit, a works 10 away and a shed 10 beyond; a rock takes 2 up and 1 down."""
    places = ["pit", "works", "shed"]
    legs = {
        (one, other): 10.0 * abs(places.index(one) - places.index(other))
        for one in places
        for other in places
    }
    return Problem(
        legs=legs,
        places=places,
        sources=sources,
        targets=["works", "shed"][: len(made)],
        made=made,
        begin=5,
        start="works",
        up=2,
        down=1,
    )


def test_one_rock_is_fetched() -> None:
    assert quickest(on_a_line([[0]], [["pit"]])) == 5 + 10 + 2 + 10 + 1


def test_a_rock_that_is_made_late_is_waited_for() -> None:
    assert quickest(on_a_line([[0, 40]], [["pit"]])) == 40 + 2 + 10 + 1


def test_two_colours_are_delivered_on_one_way() -> None:
    both = on_a_line([[0], [0]], [["pit"], ["pit"]])
    assert quickest(both) == 5 + 10 + 2 + 2 + 10 + 1 + 10 + 1


def test_a_rock_that_lies_nearer_to_the_way_is_taken_there() -> None:
    blue = on_a_line([[90], [0]], [["pit"], ["pit", "works"]])
    assert quickest(blue) == 90 + 2 + 10 + 1


def test_what_is_left_out_never_makes_the_bound_greater() -> None:
    one, two = (
        quickest(problem(1000, last, usual=False, anywhere=False)) for last in (1, 2)
    )
    assert one <= two
    assert one <= quickest(problem(1000, 1, usual=True, anywhere=False))
    assert quickest(problem(1000, 1, usual=False, anywhere=True)) <= one
