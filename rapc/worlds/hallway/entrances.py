"""What opens and closes in a building: the doors, and the lift with its own.

The state of both is a part of the hallway's, and is handed in: another is taken up when
a saved run is. What is closed stands in the plans of the floors as a wall.
"""

from __future__ import annotations

from collections.abc import Mapping
from random import Random

from rapc.worlds.hallway import doors
from rapc.worlds.hallway.doors import Lift
from rapc.worlds.hallway.map import Map, Opening
from rapc.worlds.hallway.plan import FloorPlan, door_box
from rapc.worlds.hallway.state import HallwaySettings, HallwayState


class Entrances:
    """The doorways of a building, some of them with doors.

    Args:
        map: the building.
        plans: its floors, which are told what is closed.
        openings: its doorways by name.
        settings: how often doors close, and the lift is called by others.
    """

    def __init__(
        self,
        map: Map,
        plans: Mapping[int, FloorPlan],
        openings: Mapping[str, Opening],
        settings: HallwaySettings,
    ) -> None:
        self._plans = plans
        self._openings = openings
        self._settings = settings
        lifts = [space.name for space in map.space if space.kind == "lift"]
        self._cabin = lifts[0] if lifts else None
        self._of_lift = {
            name: gap
            for name, gap in openings.items()
            if self._cabin in gap.doorway.joins
        }

    def shut(self, state: HallwayState) -> frozenset[str]:
        """Return the doorways whose doors are closed now, the lift's among them."""
        closed = {door.doorway for door in state.doors if door.closed}
        cabin = state.lift
        if cabin is not None:
            closed |= {
                name
                for name, gap in self._of_lift.items()
                if cabin.towards is not None or gap.floor != cabin.floor
            }
        return frozenset(closed)

    def close(self, state: HallwayState) -> None:
        """Let the plans have the doors that are closed now."""
        closed = sorted(self.shut(state))
        for floor, plan in self._plans.items():
            gaps = (self._openings[name] for name in closed)
            plan.close([door_box(gap) for gap in gaps if gap.floor == floor])

    def move_doors(self, state: HallwayState, now: float, rng: Random) -> None:
        """Open and close the doors whose time has come.

        Args:
            state: of the hallway; its doors are changed.
            now: the time in seconds.
            rng: the stream of doors.
        """
        moved = False
        for door in state.doors:
            if door.changes is not None and now >= door.changes:
                gap, every = self._openings[door.doorway], self._settings.doors
                moved |= doors.swing(door, gap, now, _spots(state), every, rng)
        if moved:
            self.close(state)

    def move_lift(self, state: HallwayState, now: float, rng: Random) -> None:
        """Let the lift arrive, or go where the robot or somebody else calls it.

        Args:
            state: of the hallway; its lift is changed, and the floor of a robot inside.
            now: the time in seconds.
            rng: the stream of the lift.
        """
        cabin = state.lift
        if cabin is None:
            return
        inside = state.space == self._cabin
        if cabin.towards is not None:
            if doors.arrive(cabin, now):
                if inside:
                    state.robot.floor = cabin.floor
                self.close(state)
            return
        called = state.called
        if called is not None:
            cabin.free_from = now + doors.DWELL
            if called != cabin.floor and called in self._plans:
                self._send(state, cabin, called, now)
        elif cabin.wanted is not None and now >= cabin.wanted:
            if now >= cabin.free_from and not inside:
                floors = [f for f in sorted(self._plans) if f != cabin.floor]
                self._send(state, cabin, rng.choice(floors), now)
            cabin.wanted = now + rng.expovariate(1 / self._settings.lift)

    def _send(self, state: HallwayState, cabin: Lift, floor: int, now: float) -> None:
        """Let the cabin go, unless somebody stands in its door."""
        gaps = self._of_lift.values()
        if not any(doors.occupied(gap, _spots(state)) for gap in gaps):
            doors.send(cabin, floor, now)
            self.close(state)


def _spots(state: HallwayState) -> list[doors.Spot]:
    """Return where everybody is, the robot first."""
    body = state.robot
    walkers = [(walker.floor, walker.x, walker.y) for walker in state.walkers]
    return [(body.floor, body.x, body.y), *walkers]
