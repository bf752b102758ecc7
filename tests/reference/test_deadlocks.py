"""Deadlocks, which both interpreters report at the same moment and as one circle."""

from __future__ import annotations

import random

import pytest

from tests.effort import first
from tests.reference.play import play

_PAUSE = "(define-rap (pause) (method (primitive (slow a))))"


def _program(rng: random.Random) -> tuple[str, list[str]]:
    """Return RAPs that claim one lock within another, and a task for each."""
    raps, tasks = [_PAUSE], []
    for number in range(rng.randrange(3, 9)):
        body = "(primitive (act a))"
        for depth, lock in enumerate(rng.sample("wxyz", rng.choice((2, 2, 3)))):
            name = f"rap-{number}-{depth}"
            claims = [lock, rng.choice("wxyz")][: rng.choice((1, 1, 2))]
            methods = [f"(method (claims (lock {one})) {body})" for one in claims]
            raps.append(f"(define-rap ({name}) {' '.join(methods)})")
            body = f"(task-net (t1 (pause) (for t2)) (t2 ({name})))"
        at, priority = rng.choice((0, 0, 1, 3)), rng.choice((0, 0, 0, 1))
        tasks.append(f"({name}) :at {at} :priority {priority}")
    return "\n".join(raps), tasks


@pytest.mark.parametrize("chunk", first(1, range(20)))
def test_random_deadlocks_are_the_same(chunk: int) -> None:
    found = 0
    for seed in range(chunk * 40, (chunk + 1) * 40):
        text, tasks = _program(random.Random(f"deadlocks:{seed}"))
        found += len(play(text, *tasks, only="deadlock"))
    assert found > 5


def test_longer_deadlock_begins_with_the_task_that_closed_it() -> None:
    text = _PAUSE + "".join(
        f"""
        (define-rap (has-{one}) (method (claims (lock {one}))
          (task-net (t1 (pause) (for t2)) (t2 (take-{other})))))
        (define-rap (take-{one}) (method (claims (lock {one})) (primitive (act a))))
        """
        for one, other in ("xy", "yz", "zx")
    )
    tasks = ("(has-x)", "(has-y)", "(has-z)", "(take-x)")
    told = play(text, *tasks, only="task-blocked deadlock")
    assert told == [
        "0 blocked 4 (lock x) 1",
        "1 blocked 10 (lock x) 1",
        "1 blocked 6 (lock z) 3",
        "1 blocked 8 (lock y) 2",
        "1 deadlock (8, 6, 10)",
    ]
