"""The events in the courier's hospital: a robot, a corridor, people.

Every action that takes time ends with a message. So the robot can do several actions at
once, and drive off during each of them. Events without a request happen in `advance`,
which goes from one event to the next; `_due` yields the next event. Values that follow
from the state alone, such as the battery charge, are in `robot`.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial

import msgspec

from rapc.base.chance import Stream, stream_in, stream_state
from rapc.base.values import readable
from rapc.world import OKAY, Message, Refused, Reply, Time, World
from rapc.worlds.courier import robot
from rapc.worlds.courier.building import BASE, CORRIDOR, DEPTH, ROOMS, SOLD, WARDS
from rapc.worlds.courier.robot import CHARGE, FULL
from rapc.worlds.courier.state import (
    DriveUnderWay,
    HandOver,
    HospitalState,
    Nurse,
    Work,
)
from rapc.worlds.states import reading_state

STEP = 10
"""The change of the battery charge between two data about the battery."""

PATIENCE = 20
"""The time that a nurse waits at the door."""

RING_TIME, DOCK_TIME, HAND_TIME = 1, 2, 3
"""Durations of the robot's atomic actions."""


class _Saved(msgspec.Struct, frozen=True):
    """The data that `save` writes; `restore` refuses a state with other options."""

    options: dict[str, int]
    state: HospitalState
    rng: Stream


class Hospital(World):
    """The hospital with its robot, and the clock of the port.

    Args:
        rng: the source of all chance.
        options: values of all options of the world, by name.
    """

    def __init__(self, rng: random.Random, options: Mapping[str, int]) -> None:
        self._options = dict(options)
        self._rng = rng
        self._state = HospitalState(battery=options["battery"])
        robot.tell(self._state, robot.position(self._state), robot.level(self._state))
        self._plan_call()

    @property
    def state(self) -> HospitalState:
        """Return a copy of the complete truth, for tests; hidden from the robot."""
        whole = msgspec.json.encode(self._state)
        return msgspec.json.decode(whole, type=HospitalState)

    def now(self) -> Time:
        """The time of the clock."""
        return self._state.now

    def messages(self) -> Sequence[Message]:
        """Return the messages sent since the preceding call."""
        sent, self._state.sent = self._state.sent, []
        return sent

    def ended(self) -> str | None:
        """Return the reason for the end of the run: an empty battery; None before."""
        return self._state.ended

    def cancel(self, ticket: int) -> None:
        """Stop the robot's drive, or drop the work under this ticket."""
        state = self._state
        if state.drive is not None and state.drive.ticket == ticket:
            robot.stop(state)
            robot.tell(state, robot.position(state), robot.level(state))
        state.work = [work for work in state.work if work.ticket != ticket]

    def next_time(self) -> Time | None:
        """Return the time of the next message; None if no message is to come.

        A nurse who will not meet the robot sends no message. Every event that could
        bring the robot to the nurse in time sends a message itself, and the interpreter
        then calls `next_time` again.
        """
        state = self._state
        if state.sent:
            return state.now
        nurses = [nurse for nurse in state.nurses if nurse.ward == state.room]
        return min((time for time, _ in self._due(state, nurses)), default=None)

    def advance(self, to: Time) -> None:
        """Advance the clock; events that are due happen in order of time."""
        state = self._state
        while due := sorted(self._due(state, state.nurses), key=lambda event: event[0]):
            time, happens = due[0]
            if time > to:
                break
            state.now = time
            happens()
        state.now = max(state.now, int(to))

    def save(self) -> bytes:
        """Return the state of world and random stream, as JSON."""
        saved = _Saved(self._options, self._state, stream_state(self._rng))
        return msgspec.json.encode(saved)

    def restore(self, state: bytes) -> None:
        """Restore a saved state.

        Raises:
            ValueError: if the state is invalid or belongs to other options.
        """
        with reading_state("a courier's world"):
            read = msgspec.json.decode(state, type=_Saved)
        if read.options != self._options:
            raise ValueError("a courier's world with other options saved the state")
        with reading_state("a courier's world"):
            rng = stream_in(read.rng)
            nurses = [*read.state.nurses, read.state.nurse]
            wards = {*read.state.calls, *(nurse.ward for nurse in nurses if nurse)}
            goal = BASE if read.state.drive is None else read.state.drive.room
            known = read.state.room in {*ROOMS, CORRIDOR} and goal in ROOMS
            if not (known and wards <= {*WARDS}):
                raise ValueError("a room is unknown")
            due = self._due(read.state, read.state.nurses)
            if any(time < read.state.now for time, _ in due):
                raise ValueError("something is overdue")
        self._state, self._rng = read.state, rng

    # --- requests to the robot ------------------------------------------------------

    def drive(self, ticket: int, room: str) -> Reply | Refused | None:
        """Start a drive to a room; a message reports its end."""
        state = self._state
        if state.drive is not None:
            return Refused((state.drive.ticket,))
        if room not in ROOMS:
            return Reply("blocked", (robot.position(state),))
        if state.room == room:
            return Reply(OKAY, (robot.position(state),))
        robot.leave_behind(state)
        robot.meter(state)
        state.docked = False
        depth = 0 if state.room == CORRIDOR else DEPTH
        state.drive = DriveUnderWay(ticket, room, state.now, state.along, depth)
        state.room = CORRIDOR
        robot.tell(state, robot.position(state))
        return None

    def take_on(self, ticket: int, goods: str, ward: str) -> Reply | None:
        """Start loading goods that are labelled with a ward."""
        state = self._state
        if goods not in SOLD.get(state.room, ()):
            return Reply("not-here")
        if len(state.tray) >= self._options["tray"]:
            return Reply("tray-full")
        result = "sold-out" if self._happens("sold-out") else OKAY
        until = state.now + self._rng.randint(5, 20)
        state.work.append(Work(ticket, ("take-on", goods, ward), until, result))
        return None

    def ring(self, ticket: int) -> Reply:
        """Ring for the nurse of the robot's ward."""
        self.advance(self._state.now + RING_TIME)
        state = self._state
        if state.room not in WARDS:
            return Reply("not-here")
        if not self._happens("absent"):
            comes = state.now + self._rng.randint(5, 40)
            state.nurses.append(Nurse(state.room, comes))
        return Reply(OKAY)

    def hand_over(self, ticket: int, goods: str, ward: str) -> Reply:
        """Hand goods over to the nurse at the robot."""
        self.advance(self._state.now + HAND_TIME)
        state = self._state
        if (goods, ward) not in state.tray:
            return Reply("not-aboard")
        if state.nurse is None or state.now > state.nurse.time:
            return Reply("nobody-there")
        state.nurse = None
        state.tray.remove((goods, ward))
        state.deliveries.append(HandOver(state.now, goods, ward, state.room))
        return Reply(OKAY)

    def dock(self, ticket: int) -> Reply:
        """Dock at the base, which charges the battery."""
        self.advance(self._state.now + DOCK_TIME)
        if self._state.room != BASE:
            return Reply("not-here")
        robot.meter(self._state)
        self._state.docked = True
        return Reply(OKAY, (robot.level(self._state),))

    def help(self, ticket: int, ward: str) -> Reply | None:
        """Start helping in a ward that has called."""
        state = self._state
        if state.room != ward:
            return Reply("not-here")
        if ward not in state.calls:
            return Reply("not-called")
        until = state.now + self._rng.randint(10, 30)
        state.work.append(Work(ticket, ("help", ward), until, OKAY))
        return None

    # --- events without a request ---------------------------------------------------

    def _due(
        self, state: HospitalState, nurses: Iterable[Nurse]
    ) -> Iterator[tuple[int, Callable[[], None]]]:
        """Yield future events, each with its time, in the order of their execution.

        Args:
            state: the state of the hospital.
            nurses: the nurses on their way whose arrival matters.
        """
        if state.ended is not None:
            return
        if state.drive is not None:
            yield state.metered + state.battery, self._run_down
            yield state.drive.arrives, self._arrive
        for work in state.work:
            yield work.until, partial(self._finish, work)
        for nurse in nurses:
            yield nurse.time, partial(self._come, nurse)
        if state.next_call is not None:
            yield state.next_call, self._call
        if state.drive is not None and state.battery > STEP:
            yield state.metered + STEP, self._tell_level
        if state.docked and state.battery < FULL:
            yield state.metered + -(-STEP // CHARGE), self._tell_level

    def _run_down(self) -> None:
        """End the drive and the run: the battery is empty."""
        robot.end_drive(self._state, "battery-empty")
        place = f"{readable(self._state.along)} along the corridor"
        self._state.ended = f"the battery is empty, {place}"

    def _arrive(self) -> None:
        room = self._state.drive.room if self._state.drive else CORRIDOR
        if self._happens("blocked"):
            robot.end_drive(self._state, "blocked")
        else:
            robot.end_drive(self._state, OKAY, room)

    def _finish(self, work: Work) -> None:
        state = self._state
        state.work.remove(work)
        name, what, *rest = (str(part) for part in work.request)
        if work.result == OKAY and name == "take-on":
            state.tray.append((what, rest[0]))
        if work.result == OKAY and name == "help":
            state.calls.remove(what)
        robot.answer(state, work.ticket, work.result)

    def _come(self, nurse: Nurse) -> None:
        """Bring a nurse to the door; count a visit in vain if the robot is away."""
        state = self._state
        state.nurses.remove(nurse)
        if state.room == nurse.ward:
            state.nurse = Nurse(nurse.ward, nurse.time + PATIENCE)
            robot.tell(state, (":nurse", nurse.ward))
        else:
            state.in_vain += 1

    def _call(self) -> None:
        state = self._state
        ward = self._rng.choice(WARDS)
        if ward not in state.calls:
            state.calls.append(ward)
        robot.tell(state, ("call", ward))
        self._plan_call()

    def _tell_level(self) -> None:
        robot.meter(self._state)
        if self._state.drive is not None:
            robot.tell(self._state, robot.position(self._state))
        robot.tell(self._state, robot.level(self._state))

    def _plan_call(self) -> None:
        """Choose the time of the next call from a ward."""
        often = self._options["calls"]
        pause = self._rng.randint(often // 2, often + often // 2) if often else 0
        self._state.next_call = self._state.now + pause if pause else None

    def _happens(self, option: str) -> bool:
        """Draw whether an event happens; the option is its probability in per cent."""
        return self._rng.randrange(FULL) < self._options[option]
