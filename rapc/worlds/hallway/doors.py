"""What opens and closes in a building: doors now and then, a lift that others use too.

The state of both is a part of the hallway's, and is handed in: another is taken up when
a saved run is. What is closed stands in the plans of the floors as a wall.
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
"""How long a door stays closed on average, in seconds."""

CLEAR = 0.5
"""How near to the middle of a doorway somebody keeps its door open, in metres."""

A_FLOOR = 6.0
"""What the lift takes from one floor to the next, doors included, in seconds."""

DWELL = 20.0
"""How long the lift stays for the robot before somebody else can call it."""


def doors(openings: Iterable[Opening], every: float, rng: Random) -> list[DoorState]:
    """Return the doors of a building, all open.

    Args:
        openings: all doorways.
        every: how long a door stays open on average, in seconds; 0: for ever.
        rng: the stream of doors.
    """
    names = [gap.doorway.name for gap in openings if gap.doorway.door]
    return [DoorState(name, changes=_after(every, rng)) for name in names]


def lift(map: Map, every: float, rng: Random) -> Lift | None:
    """Return the lift of a map at its lowest floor, or None.

    Args:
        map: the building.
        every: how often somebody else wants it, in seconds on average; 0: never.
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

        A door that somebody stands in waits a second.

        Args:
            state: of the hallway; its doors are changed.
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
        """Let the lift arrive, or go where the robot or somebody else calls it.

        Args:
            state: of the hallway; its lift is changed, and the floor of a robot inside.
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
        """Let the cabin go, unless somebody stands in its door."""
        if not any(_occupied(gap, state) for gap in self._of_lift.values()):
            cabin.towards = floor
            cabin.arrives = now + A_FLOOR * abs(floor - cabin.floor)
            self.close(state)


def _occupied(opening: Opening, state: HallwayState) -> bool:
    """Return whether somebody is in a doorway, or about to be."""
    x, y = middle(opening.box)
    bodies: list[Robot | Walker] = [state.robot, *state.walkers]
    return any(
        one.floor == opening.floor and abs(one.x - x) < CLEAR and abs(one.y - y) < CLEAR
        for one in bodies
    )
