"""The complete changing state of the courier's world, as a value to be saved."""

from __future__ import annotations

import msgspec

from rapc.base.values import Fact
from rapc.world import Message
from rapc.worlds.courier import building


class DriveUnderWay(msgspec.Struct, frozen=True):
    """A drive of the robot to a room, from a position and a start time."""

    ticket: int
    room: str
    since: int
    along: int
    depth: int

    @property
    def arrives(self) -> int:
        """Return the robot's time of arrival."""
        return self.since + building.way_to_room(self.along, self.depth, self.room)

    def place(self, now: int) -> tuple[int, int]:
        """Return the robot's position: along the corridor, and depth."""
        return building.passed(self.along, self.depth, self.room, now - self.since)


class Work(msgspec.Struct, frozen=True):
    """Work in a room that takes time and ends with a result."""

    ticket: int
    request: Fact
    until: int
    result: str


class Nurse(msgspec.Struct, frozen=True):
    """A nurse on her way with her time of arrival, or at the door with her end time."""

    ward: str
    time: int


class HandOver(msgspec.Struct, frozen=True):
    """A hand-over of goods in a ward; `label` is the ward on the goods."""

    time: int
    goods: str
    label: str
    ward: str


class HospitalState(msgspec.Struct):
    """The complete state."""

    #: The robot's room, or `corridor`.
    room: str = building.BASE
    #: The robot's coordinate along the corridor.
    along: int = 0
    now: int = 0
    #: The charge of the battery at the time `metered`, of 100.
    battery: int = 100
    metered: int = 0
    docked: bool = False
    drive: DriveUnderWay | None = None
    work: list[Work] = msgspec.field(default_factory=list)
    #: The nurses on their way, and a nurse at the robot.
    nurses: list[Nurse] = msgspec.field(default_factory=list)
    nurse: Nurse | None = None
    #: The wards that have called and wait for help.
    calls: list[str] = msgspec.field(default_factory=list)
    next_call: int | None = None
    #: Goods on the tray, each with the ward on its label.
    tray: list[tuple[str, str]] = msgspec.field(default_factory=list)
    deliveries: list[HandOver] = msgspec.field(default_factory=list)
    #: The number of people left behind. The robot drove off during loading or help, or
    #: before or during the visit of a nurse for whom the robot had rung.
    in_vain: int = 0
    #: The messages not fetched yet.
    sent: list[Message] = msgspec.field(default_factory=list)
    ended: str | None = None
