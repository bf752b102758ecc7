"""Doors that close now and then, and a lift shared with other users.

Doors and lift are parts of the hallway's state. Each function gets the state as an
argument, because restoring a saved run replaces the state. A closed door is a wall in
the plan of its floor.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from random import Random

from rapc.worlds.hallway.map import Map, Opening, middle
from rapc.worlds.hallway.people import Walker
from rapc.worlds.hallway.plan import FloorPlan, door_box
from rapc.worlds.hallway.robot import Robot
from rapc.worlds.hallway.state import DoorState, HallwaySettings, HallwayState, Lift

SHUT_FOR = 25.0
"""The average time that a door stays closed, in seconds."""

CLEAR = 0.5
"""The distance from a doorway's middle at which its door cannot close, in metres."""

A_FLOOR = 6.0
"""The lift's travel time between neighbouring floors, doors included, in seconds."""

DWELL = 20.0
"""The time that the lift waits for the robot before other users can call the lift."""


def doors(openings: Iterable[Opening], every: float, rng: Random) -> list[DoorState]:
    """Return the doors of a building, all open.

    Args:
        openings: all doorways.
        every: the average time that a door stays open, in seconds; 0: for ever.
        rng: the stream of doors.
    """
    names = [gap.doorway.name for gap in openings if gap.doorway.door]
    return [DoorState(name, changes=_after(every, rng)) for name in names]


def lift(map: Map, every: float, rng: Random) -> Lift | None:
    """Return the lift of a map at its lowest floor, or None.

    Args:
        map: the building.
        every: the average time between calls by other users, in seconds; 0: no calls.
        rng: the stream of the lift.
    """
    for space in map.space:
        if space.kind == "lift":
            return Lift(min(space.floors), wanted=_after(every, rng))
    return None


def _after(every: float, rng: Random) -> float | None:
    return rng.expovariate(1 / every) if every > 0 else None


class Entrances:
    """The doorways of a building, some of them with doors.

    Args:
        map: the building.
        plans: the floors; closed doors are entered here.
        openings: the doorways by name.
        settings: the rates of closing doors and of lift calls by other users.
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
        """Return the doorways with a closed door, the lift's included."""
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
        """Enter the closed doors into the plans."""
        closed = sorted(self.shut(state))
        for floor, plan in self._plans.items():
            gaps = (self._openings[name] for name in closed)
            plan.close([door_box(gap) for gap in gaps if gap.floor == floor])

    def move_doors(self, state: HallwayState, now: float, rng: Random) -> None:
        """Open and close the doors that are due.

        A door with a person or the robot in it is tried again a second later.

        Args:
            state: the state of the hallway; its doors are changed.
            now: the time in seconds.
            rng: the stream of doors.
        """
        moved = False
        for door in state.doors:
            if door.changes is None or now < door.changes:
                continue
            if not door.closed and _occupied(self._openings[door.doorway], state):
                door.changes = now + 1
                continue
            moved, door.closed = True, not door.closed
            often = SHUT_FOR if door.closed else self._settings.doors
            door.changes = now + rng.expovariate(1 / often)
        if moved:
            self.close(state)

    def move_lift(self, state: HallwayState, now: float, rng: Random) -> None:
        """Let the lift arrive, or send the lift to a caller.

        Args:
            state: the state of the hallway; its lift is changed, and the floor of a
            robot
                inside.
            now: the time in seconds.
            rng: the stream of the lift.
        """
        cabin, called = state.lift, state.called
        if cabin is None:
            return
        inside = state.space == self._cabin
        if cabin.towards is not None:
            if now >= cabin.arrives - 1e-9:
                cabin.floor, cabin.towards = cabin.towards, None
                cabin.free_from = now + DWELL
                if inside:
                    state.robot.floor = cabin.floor
                self.close(state)
        elif called is not None:
            cabin.free_from = now + DWELL
            if called != cabin.floor and called in self._plans:
                self._send(state, cabin, called, now)
        elif cabin.wanted is not None and now >= cabin.wanted:
            if now >= cabin.free_from and not inside:
                floors = [f for f in sorted(self._plans) if f != cabin.floor]
                self._send(state, cabin, rng.choice(floors), now)
            cabin.wanted = now + rng.expovariate(1 / self._settings.lift)

    def _send(self, state: HallwayState, cabin: Lift, floor: int, now: float) -> None:
        """Send the cabin to a floor, unless its door is occupied."""
        if not any(_occupied(gap, state) for gap in self._of_lift.values()):
            cabin.towards = floor
            cabin.arrives = now + A_FLOOR * abs(floor - cabin.floor)
            self.close(state)


def _occupied(opening: Opening, state: HallwayState) -> bool:
    """Return whether a person or the robot is in a doorway, or close to it."""
    x, y = middle(opening.box)
    bodies: list[Robot | Walker] = [state.robot, *state.walkers]
    return any(
        one.floor == opening.floor and abs(one.x - x) < CLEAR and abs(one.y - y) < CLEAR
        for one in bodies
    )
