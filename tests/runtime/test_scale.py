"""Many tasks: nothing recurses, and nothing grows faster than the program does.

Work is counted in lines of Python executed, so that the tests say the same on every
machine. Twice the tasks may take little more than twice the lines.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rapc import events
from tests.effort import first
from tests.work import lines

from .helpers import Play, at

SMALL, LARGE = 150, 300

NEST = """
(define-rap (down ?n)
  (succeed (or (= ?n 0) (last-result okay)))
  (method (task-net (t1 (down (- ?n 1))))))
"""
WAIT = "(define-rap (wait ?x) (monitor-state (p ?x)) (method (primitive (act ?x))))"
USE = "(define-rap (use ?x) (method (primitive (act ?x))))"
FIND = "(define-rap (find => ?x) (succeed (p ?x)))"


def nested(size: int) -> Play:
    """Tasks within tasks."""
    return Play(NEST, f"(down {size})")


def dormant(size: int) -> Play:
    """Blocked tasks, and as many changes that concern one of them each."""
    times = [at(n + 1, f"(p w{n})") for n in range(size)]
    return Play(WAIT, *[f"(wait w{n})" for n in range(size)], times=times)


def undisturbed(size: int) -> Play:
    """Blocked tasks, and as many changes that concern none of them."""
    times = [at(n + 1, f"(p other{n})") for n in range(size)]
    return Play(WAIT, *[f"(wait w{n})" for n in range(size)], times=times)


def eligible(size: int) -> Play:
    """Tasks that could all go on."""
    return Play(USE, *[f"(use w{n})" for n in range(size)])


def net(steps: str) -> Play:
    """One task with many steps."""
    text = USE + FIND + f"(define-rap (top) (method (task-net {steps})))"
    return Play(text, "(top)", facts=["(p a)"])


def broad(size: int) -> Play:
    """Steps without an order."""
    return net("".join(f"(t{n} (use w{n}))" for n in range(size)))


def chain(size: int) -> Play:
    """Steps one after the other."""
    steps = (f"(t{n} (use w{n}) (for t{n + 1}))" for n in range(size))
    return net("".join(steps) + f"(t{size} (use last))")


def handing_on(size: int) -> Play:
    """Steps that bind what another one each needs."""
    steps = (
        f"(t{n} (find => ?v{n}) (for u{n})) (u{n} (use ?v{n}))" for n in range(size)
    )
    return net("".join(steps))


@pytest.mark.parametrize(
    "make", [nested, dormant, undisturbed, eligible, broad, chain, handing_on]
)
def test_twice_the_tasks_take_twice_the_work(make: Callable[[int], Play]) -> None:
    make(10).run()
    small, large = make(SMALL), make(LARGE)
    few = lines(lambda: small.run(until=10_000))
    many = lines(lambda: large.run(until=10_000))
    assert few * 1.5 < many < few * 2.3


def test_ten_thousand_levels_of_tasks() -> None:
    ran = nested(10_000).run()
    assert ran.told("over") == ["over done"]
    assert ran.events[-1].cycle == 20_001
    assert len(ran.of(events.TaskSucceeded)) == 10_001


def test_ten_thousand_levels_leave_descendants_first() -> None:
    text = NEST.replace("(= ?n 0)", "(p zero)") + "(define-rap (unused))"
    ran = Play(text, "(down 10000)").run(cycles=10_000)
    removed = [event.task for event in ran.of(events.TaskRemoved)]
    assert removed == list(range(len(removed), 0, -1))
    assert len(removed) > 9_999


@pytest.mark.parametrize("many", first(1, [1000, 10_000]))
def test_thousands_of_monitors_one_of_which_is_concerned(many: int) -> None:
    ran = Play(
        WAIT,
        *[f"(wait w{n})" for n in range(many)],
        times=[at(1, "(q a b)"), at(2, "(p w77)"), at(3, "(p nobody)")],
    ).run()
    assert len(ran.told("blocked")) == many
    assert [event.task for event in ran.of(events.TaskWoken)] == [78]
    assert ran.told("asked", "over", times=True) == [
        "2 asked (act w77)",
        "3 over stuck",
    ]


@pytest.mark.parametrize("many", first(1, [1000, 10_000]))
def test_thousands_of_tasks_at_once(many: int) -> None:
    ran = eligible(many).run()
    assert ran.told("over") == ["over done"]
    assert len(set(ran.told("asked"))) == many
