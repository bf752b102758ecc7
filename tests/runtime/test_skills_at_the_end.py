"""When a run is over no skill is on, whatever ended it; the world is asked itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import pytest

import rapc
from rapc.world import Fact, Refused
from rapc.worlds.skills.runtime import EventTold
from tests.worlds.skills.test_world import TankWorld

LIBRARY = rapc.loads(
    """
    (declare-event :reached (?level))
    (declare-event :leak ())
    (declare-event :high ())
    (declare-skill :hold (?height) :events (:reached) :uses (valve))
    (declare-skill :watch (?mark) :events (:high))
    (define-rap (fill ?height)
      (method
        (primitive (enable (:hold ?height)) (wait-for (:reached ?) :succeed))))
    (define-rap (fill-and-watch ?height)
      (method
        (skills (:watch 1))
        (task-net (t1 (fill ?height)))))
    (define-rap (fail-at-a-leak)
      (method
        (skills (:watch 5))
        (task-net (t1 (fill 9) (wait-for (:leak) :fail)))))
    """
)


class Ending(TankWorld):
    """A tank that may be over, or break, at a time."""

    over_at = broken_at = leak_at = 1e9
    asked = 0

    def activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Count how often skills come on."""
        self.asked += 1
        return super().activate(ticket, skills, events)

    def tick(self) -> Iterable[EventTold]:
        if self.time > self.broken_at:
            raise ValueError("no water")
        yield from super().tick()
        if self.time >= self.leak_at:
            yield EventTold("leak", (), ())

    def ended(self) -> str | None:
        """Return why the run is over, once it is."""
        return "emptied" if self.time > self.over_at else None


ENDS: dict[str, Callable[[Ending], str]] = {
    "done": lambda world: _run(world, "(fill 2)"),
    "until": lambda world: _run(world, "(fill-and-watch 9)", until=1),
    "cycles": lambda world: _run(world, "(fill-and-watch 9)", cycles=2),
    "failed": lambda world: _leaking(world, "(fail-at-a-leak)"),
    "world": lambda world: _over(world, "(fill-and-watch 9)"),
    "broken": lambda world: _broken(world, "(fill-and-watch 9)"),
    "cancelled": lambda world: _cancelled(world, "(fill-and-watch 9)"),
}


def _run(
    world: Ending, task: str, until: float | None = None, cycles: int | None = None
) -> str:
    return rapc.run(LIBRARY, world, task, until=until, cycles=cycles).reason


def _leaking(world: Ending, task: str) -> str:
    world.leak_at = 2
    done = rapc.run(LIBRARY, world, task)
    return done.tasks[0].outcome or ""


def _over(world: Ending, task: str) -> str:
    world.over_at = 1
    return _run(world, task)


def _broken(world: Ending, task: str) -> str:
    world.broken_at = 1
    with pytest.raises(rapc.PortError, match="no water"):
        rapc.run(LIBRARY, world, task)
    return "broken"


def _cancelled(world: Ending, task: str) -> str:
    run = LIBRARY.start(world, tasks=task)
    run.step()
    assert world.runtime.active()
    run.end("cancelled")
    return run.run()


@pytest.mark.parametrize("reason", ENDS)
def test_at_the_end_of_a_run_no_skill_is_on(reason: str) -> None:
    world = Ending()
    assert ENDS[reason](world) == reason
    assert world.asked
    assert world.runtime.active() == ()
