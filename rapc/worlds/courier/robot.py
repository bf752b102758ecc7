"""The courier's robot: where it is, what its battery holds, what it sends.

Place and battery follow from the state and its clock. They are brought up to date there
only when the way in which they change is another one.
"""

from __future__ import annotations

from rapc.base.values import Fact
from rapc.world import Datum, Finished, Reply, Signal
from rapc.worlds.courier.building import CORRIDOR
from rapc.worlds.courier.state import HospitalState

FULL = 100
"""What a full battery holds: so long a way."""

CHARGE = 2
"""What the dock gives in a time unit."""


def charge(state: HospitalState) -> int:
    """Return what the battery holds now."""
    passed = state.now - state.metered
    driven = passed if state.drive is not None else 0
    gained = CHARGE * passed if state.docked else 0
    return max(0, min(FULL, state.battery - driven + gained))


def meter(state: HospitalState) -> None:
    """Bring the battery up to date."""
    state.battery = charge(state)
    state.metered = state.now


def level(state: HospitalState) -> Fact:
    """Return the datum that tells what the battery holds."""
    return ("battery", charge(state))


def position(state: HospitalState) -> Fact:
    """Return the datum that tells where the robot is."""
    along = state.drive.place(state.now)[0] if state.drive else state.along
    return ("position", state.room, along)


def stop(state: HospitalState) -> None:
    """Stop the robot in the corridor, beside where it has got to."""
    meter(state)
    if state.drive is not None:
        state.along, _ = state.drive.place(state.now)
        state.drive = None


def end_drive(state: HospitalState, result: str, room: str = CORRIDOR) -> None:
    """Stop the robot in a room or the corridor, and answer for its drive."""
    drive = state.drive
    stop(state)
    state.room = room
    if drive is not None:
        answer(state, drive.ticket, result, position(state), level(state))


def leave_behind(state: HospitalState) -> None:
    """Set off: whoever does something with the robot is left standing."""
    for work in state.work:
        answer(state, work.ticket, "robot-left")
    state.in_vain += len(state.work) + (state.nurse is not None)
    state.work, state.nurse = [], None


def tell(state: HospitalState, *contents: Fact) -> None:
    """Send data and signals, in this order."""
    for content in contents:
        kind = Signal if str(content[0]).startswith(":") else Datum
        state.sent.append(kind(content))


def answer(state: HospitalState, ticket: int, result: str, *data: Fact) -> None:
    """Send the result of what was asked for under a ticket, with its data."""
    state.sent.append(Finished(ticket, Reply(result, data)))
