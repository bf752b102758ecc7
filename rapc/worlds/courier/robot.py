"""The courier's robot: its position, its battery, its messages.

Position and charge follow from the state and the clock. The functions here update the
stored values only when the rate of change changes.
"""

from __future__ import annotations

from rapc.base.values import Fact
from rapc.world import Datum, Finished, Reply, Signal
from rapc.worlds.courier.building import CORRIDOR
from rapc.worlds.courier.state import HospitalState

FULL = 100
"""The charge of a full battery, as the distance that the robot can drive."""

CHARGE = 2
"""The charge that the dock adds in a time unit."""


def charge(state: HospitalState) -> int:
    """Return the present charge of the battery."""
    passed = state.now - state.metered
    driven = passed if state.drive is not None else 0
    gained = CHARGE * passed if state.docked else 0
    return max(0, min(FULL, state.battery - driven + gained))


def meter(state: HospitalState) -> None:
    """Update the stored charge of the battery."""
    state.battery = charge(state)
    state.metered = state.now


def level(state: HospitalState) -> Fact:
    """Return the datum with the charge of the battery."""
    return ("battery", charge(state))


def position(state: HospitalState) -> Fact:
    """Return the datum with the robot's position."""
    along = state.drive.place(state.now)[0] if state.drive else state.along
    return ("position", state.room, along)


def stop(state: HospitalState) -> None:
    """Stop the robot in the corridor at its present position."""
    meter(state)
    if state.drive is not None:
        state.along, _ = state.drive.place(state.now)
        state.drive = None


def end_drive(state: HospitalState, result: str, room: str = CORRIDOR) -> None:
    """Stop the robot in a room or the corridor, and send the result of its drive."""
    drive = state.drive
    stop(state)
    state.room = room
    if drive is not None:
        answer(state, drive.ticket, result, position(state), level(state))


def leave_behind(state: HospitalState) -> None:
    """End the work in progress and a nurse's visit; count the people left behind."""
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
    """Send the result of a request, with its data."""
    state.sent.append(Finished(ticket, Reply(result, data)))
