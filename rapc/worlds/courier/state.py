"""All that changes in the courier's world, as one value that can be saved exactly."""

from __future__ import annotations

import msgspec

from rapc.base.values import Fact
from rapc.world import Message
from rapc.worlds.courier import building


class DriveUnderWay(msgspec.Struct, frozen=True):
    """The robot is on its way to a room, from a place that it left at a time."""

    ticket: int
    room: str
    since: int
    along: int
    depth: int

    @property
    def arrives(self) -> int:
        """Return when the robot will be there."""
        return self.since + building.way_to_room(self.along, self.depth, self.room)

    def place(self, now: int) -> tuple[int, int]:
        """Return where the robot has got to: along the corridor, and beside it."""
        return building.passed(self.along, self.depth, self.room, now - self.since)


class Work(msgspec.Struct, frozen=True):
    """Something that takes its time in a room, until it ends with a result."""

    ticket: int
    request: Fact
    until: int
    result: str


class Nurse(msgspec.Struct, frozen=True):
    """A nurse who was rung for, and when she comes; or who came, and when she goes."""

    ward: str
    time: int


class HandOver(msgspec.Struct, frozen=True):
    """Goods were handed over in a ward; `label` is the ward that they were for."""

    time: int
    goods: str
    label: str
    ward: str


class HospitalState(msgspec.Struct):
    """The whole state."""

    #: The room that the robot is in, or `corridor`.
    room: str = building.BASE
    #: How far along the corridor the robot is.
    along: int = 0
    now: int = 0
    #: What the battery held at the time `metered`, of 100.
    battery: int = 100
    metered: int = 0
    docked: bool = False
    drive: DriveUnderWay | None = None
    work: list[Work] = msgspec.field(default_factory=list)
    #: The nurses who are on their way, and one who stands before the robot.
    nurses: list[Nurse] = msgspec.field(default_factory=list)
    nurse: Nurse | None = None
    #: The wards that have called and nobody has helped yet.
    calls: list[str] = msgspec.field(default_factory=list)
    next_call: int | None = None
    #: Goods on the tray, each with the ward on its label.
    tray: list[tuple[str, str]] = msgspec.field(default_factory=list)
    deliveries: list[HandOver] = msgspec.field(default_factory=list)
    #: How often somebody was left standing: the robot drove off while goods were put on
    #: or help was given, or while or before a nurse came for whom it had rung.
    in_vain: int = 0
    #: The messages not taken in yet.
    sent: list[Message] = msgspec.field(default_factory=list)
    ended: str | None = None
