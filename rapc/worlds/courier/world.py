"""The courier's world: one robot, one corridor, people who need their time.

Whatever takes time ends by a message, so the robot could do several things at once, and
drive off in the middle of any. What happens by itself happens in `advance`, which goes
from one event to the next; `_due` says what is next.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial

import msgspec

from rapc.base.values import Atom, Fact
from rapc.world import (
    OKAY,
    Datum,
    Finished,
    Gauge,
    Kit,
    Message,
    Offer,
    Option,
    Picture,
    Refused,
    Reply,
    Signal,
    Spot,
    Thing,
    Time,
    World,
)
from rapc.worlds.courier import building
from rapc.worlds.courier.building import BASE, CORRIDOR, DEPTH, ROOMS, SOLD, WARDS
from rapc.worlds.courier.handlers import HANDLERS, way
from rapc.worlds.courier.state import Delivery, Drive, Nurse, Sent, State, Work
from rapc.worlds.streams import Stream, stream_in, stream_state

FULL = 100
"""What a full battery holds: so long a way."""

STEP = 10
"""The battery is told of whenever it has changed by so much."""

CHARGE = 2
"""What the dock gives in a time unit."""

PATIENCE = 20
"""How long a nurse stands at the door."""

RING_TIME, DOCK_TIME, HAND_TIME = 1, 2, 3
"""How long the robot is held by what it does alone."""

_OPTIONS = (
    Option("battery", "integer", 70, "of 100", "what the battery holds at first"),
    Option("tray", "integer", 3, "parcels", "what the tray holds"),
    Option("blocked", "integer", 15, "%", "drives that end before a blocked door"),
    Option("sold-out", "integer", 10, "%", "stores that have nothing left just then"),
    Option("absent", "integer", 20, "%", "times that nobody comes when it rings"),
    Option("calls", "integer", 150, "time units", "between calls, about; 0: none"),
)

_OFFER = Offer(
    primitives={
        "drive": (1, (OKAY, "blocked", "battery-empty")),
        "take-on": (2, (OKAY, "sold-out", "not-here", "tray-full", "robot-left")),
        "ring": (0, (OKAY, "not-here")),
        "hand-over": (2, (OKAY, "nobody-there", "not-aboard")),
        "dock": (0, (OKAY, "not-here")),
        "help": (1, (OKAY, "not-here", "not-called", "robot-left")),
    },
    data={"position": 2, "battery": 1, "call": 1},
    events={":nurse": 1},
    not_atomic=("drive", "take-on", "help"),
    arguments={
        "drive": ("room",),
        "take-on": ("goods", "ward"),
        "hand-over": ("goods", "ward"),
        "help": ("ward",),
        "position": ("room", "along"),
        "battery": ("level",),
        "call": ("ward",),
        ":nurse": ("ward",),
    },
)


class Saved(msgspec.Struct, frozen=True):
    """What `save` writes: the options are kept to refuse a state of other ones."""

    options: dict[str, int]
    state: State
    rng: Stream


class CourierWorld(World):
    """A courier robot in a hospital, with one battery and one pair of wheels.

    Raises:
        ValueError: for an option out of range.
    """

    name = "courier"
    kit = Kit(_OFFER, HANDLERS, _OPTIONS, functions={"way": way})

    def __init__(self, rng: random.Random, options: Mapping[str, Atom | bool]) -> None:
        self._options = {
            option.name: int(str(options.get(option.name, option.default)))
            for option in _OPTIONS
        }
        for option in _OPTIONS:
            value = self._options[option.name]
            if value < 0 or (option.unit in {"%", "of 100"} and value > FULL):
                raise ValueError(f"`{option.name}` is out of range")
        self._rng = rng
        self._state = State(battery=self._options["battery"])
        self._tell(self._position(), self._level())
        self._plan_call()

    # --- the port -----------------------------------------------------------------

    def facts(self) -> Iterable[Fact]:
        """The building: rooms, and what the stores give out."""
        return building.facts()

    def now(self) -> Time:
        """The clock."""
        return self._state.now

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Begin what takes its time, or do what the robot does alone.

        Raises:
            ValueError: for a primitive or a number of arguments not on offer.
        """
        name, *arguments = (str(part) for part in request)
        if (
            name not in _OFFER.primitives
            or len(arguments) != _OFFER.primitives[name][0]
        ):
            raise ValueError(f"the courier has no primitive `{name}` of that form")
        acts: Mapping[str, Callable[..., Reply | Refused | None]] = {
            "drive": self._drive,
            "take-on": self._take_on,
            "ring": self._ring,
            "hand-over": self._hand_over,
            "dock": self._dock,
            "help": self._help,
        }
        return acts[name](ticket, *arguments)

    def cancel(self, ticket: int) -> None:
        """Stop where the robot is, or leave off what was to be done."""
        state = self._state
        if state.drive is not None and state.drive.ticket == ticket:
            self._stop()
            self._tell(self._position(), self._level())
        state.work = [work for work in state.work if work.ticket != ticket]

    def next_time(self) -> Time | None:
        """The next thing to be sent, or now if something waits to be taken in.

        A nurse for whom the robot is not there sends nothing. What could bring it there
        before she comes sends something, and this is asked again.
        """
        state = self._state
        if state.sent:
            return state.now
        nurses = [nurse for nurse in state.nurses if nurse.ward == state.room]
        return min((time for time, _ in self._due(nurses)), default=None)

    def advance(self, to: Time) -> None:
        """Move the clock on; what is due until then happens, one after the other."""
        state = self._state
        while due := sorted(self._due(state.nurses), key=lambda event: event[0]):
            time, happens = due[0]
            if time > to:
                break
            state.now = time
            happens()
        state.now = max(state.now, int(to))

    def messages(self) -> Sequence[Message]:
        """Return what was sent since this was last asked."""
        sent, self._state.sent = self._state.sent, []
        return [_message(one) for one in sent]

    def ended(self) -> str | None:
        """An empty battery ends the run."""
        return self._state.ended

    def picture(self) -> Picture:
        """The corridor with its rooms, the tray, and who waits where."""
        state = self._state
        spots = [
            Spot(
                room,
                at=(along / 2, 0 if kind == "ward" else 2),
                note="calls" if room in state.calls else "",
            )
            for room, (along, kind) in ROOMS.items()
        ]
        tray = tuple(Thing(goods, ward) for goods, ward in state.tray)
        gauges = (
            Gauge("at", state.room, ("robot-at",)),
            Gauge("battery", self._charge(), ("battery",)),
        )
        corridor = Spot(CORRIDOR, at=(state.along / 2, 1))
        return Picture(
            state.room, (*spots, corridor, Spot("tray", tray)), gauges=gauges
        )

    def save(self) -> bytes:
        """The state of world and random stream, as JSON."""
        saved = Saved(self._options, self._state, stream_state(self._rng))
        return msgspec.json.encode(saved)

    def restore(self, state: bytes) -> None:
        """Take up a saved state.

        Raises:
            ValueError: if it is none, or one of a courier's world with other options.
        """
        try:
            saved = msgspec.json.decode(state, type=Saved)
        except msgspec.DecodeError as error:
            raise ValueError(f"no state of a courier's world: {error}") from error
        if saved.options != self._options:
            raise ValueError("the state is that of a courier's world otherwise made")
        self._rng, self._state = stream_in(saved.rng), saved.state

    @property
    def state(self) -> State:
        """A copy of the whole truth, for tests; the robot has no part in it."""
        return msgspec.json.decode(msgspec.json.encode(self._state), type=State)

    # --- what the robot is asked for ------------------------------------------------

    def _drive(self, ticket: int, room: str) -> Reply | Refused | None:
        state = self._state
        if state.drive is not None:
            return Refused((state.drive.ticket,))
        if room not in ROOMS:
            return Reply("blocked", (self._position(),))
        if state.room == room:
            return Reply(OKAY, (self._position(),))
        self._leave_behind()
        self._meter()
        state.docked = False
        depth = 0 if state.room == CORRIDOR else DEPTH
        state.drive = Drive(ticket, room, state.now, state.along, depth)
        state.room = CORRIDOR
        self._tell(self._position())
        return None

    def _take_on(self, ticket: int, goods: str, ward: str) -> Reply | None:
        state = self._state
        if goods not in SOLD.get(state.room, ()):
            return Reply("not-here")
        if len(state.tray) >= self._options["tray"]:
            return Reply("tray-full")
        result = "sold-out" if self._happens("sold-out") else OKAY
        until = state.now + self._rng.randint(5, 20)
        state.work.append(Work(ticket, ("take-on", goods, ward), until, result))
        return None

    def _ring(self, ticket: int) -> Reply:
        self.advance(self._state.now + RING_TIME)
        state = self._state
        if state.room not in WARDS:
            return Reply("not-here")
        if not self._happens("absent"):
            comes = state.now + self._rng.randint(5, 40)
            state.nurses.append(Nurse(state.room, comes))
        return Reply(OKAY)

    def _hand_over(self, ticket: int, goods: str, ward: str) -> Reply:
        self.advance(self._state.now + HAND_TIME)
        state = self._state
        if (goods, ward) not in state.tray:
            return Reply("not-aboard")
        if state.nurse is None or state.now > state.nurse.time:
            return Reply("nobody-there")
        state.nurse = None
        state.tray.remove((goods, ward))
        state.deliveries.append(Delivery(state.now, goods, ward, state.room))
        return Reply(OKAY)

    def _dock(self, ticket: int) -> Reply:
        self.advance(self._state.now + DOCK_TIME)
        if self._state.room != BASE:
            return Reply("not-here")
        self._meter()
        self._state.docked = True
        return Reply(OKAY, (self._level(),))

    def _help(self, ticket: int, ward: str) -> Reply | None:
        state = self._state
        if state.room != ward:
            return Reply("not-here")
        if ward not in state.calls:
            return Reply("not-called")
        until = state.now + self._rng.randint(10, 30)
        state.work.append(Work(ticket, ("help", ward), until, OKAY))
        return None

    # --- what happens by itself -----------------------------------------------------

    def _due(self, nurses: Iterable[Nurse]) -> Iterator[tuple[int, Callable[[], None]]]:
        """Yield what will happen, with its time, in the order in which it is done.

        Args:
            nurses: those on their way whose coming counts.
        """
        state = self._state
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
        """The battery is empty, on the way."""
        self._end_drive("battery-empty")
        self._state.ended = "the battery is empty"

    def _arrive(self) -> None:
        room = self._state.drive.room if self._state.drive else CORRIDOR
        if self._happens("blocked"):
            self._end_drive("blocked")
        else:
            self._end_drive(OKAY, room)

    def _finish(self, work: Work) -> None:
        state = self._state
        state.work.remove(work)
        name, what, *rest = (str(part) for part in work.request)
        if work.result == OKAY and name == "take-on":
            state.tray.append((what, rest[0]))
        if work.result == OKAY and name == "help":
            state.calls.remove(what)
        self._answer(work.ticket, work.result)

    def _come(self, nurse: Nurse) -> None:
        """A nurse comes to the door, and sees whether the robot is there."""
        state = self._state
        state.nurses.remove(nurse)
        if state.room == nurse.ward:
            state.nurse = Nurse(nurse.ward, nurse.time + PATIENCE)
            self._tell((":nurse", nurse.ward))
        else:
            state.in_vain += 1

    def _call(self) -> None:
        state = self._state
        ward = self._rng.choice(WARDS)
        if ward not in state.calls:
            state.calls.append(ward)
        self._tell(("call", ward))
        self._plan_call()

    def _tell_level(self) -> None:
        self._meter()
        if self._state.drive is not None:
            self._tell(self._position())
        self._tell(self._level())

    # --- parts of these -------------------------------------------------------------

    def _leave_behind(self) -> None:
        """The robot sets off: who does something with it is left standing."""
        state = self._state
        for work in state.work:
            self._answer(work.ticket, "robot-left")
        state.in_vain += len(state.work) + (state.nurse is not None)
        state.work, state.nurse = [], None

    def _meter(self) -> None:
        """Bring the battery up to date."""
        self._state.battery = self._charge()
        self._state.metered = self._state.now

    def _stop(self) -> Drive | None:
        """The robot stops in the corridor, beside where it has got to."""
        self._meter()
        state = self._state
        drive, state.drive = state.drive, None
        if drive is not None:
            state.along, _ = drive.place(state.now)
        return drive

    def _end_drive(self, result: str, room: str = CORRIDOR) -> None:
        drive = self._stop()
        self._state.room = room
        if drive is not None:
            self._answer(drive.ticket, result, self._position(), self._level())

    def _plan_call(self) -> None:
        """Settle when the next ward will call."""
        often = self._options["calls"]
        pause = self._rng.randint(often // 2, often + often // 2) if often else 0
        self._state.next_call = self._state.now + pause if pause else None

    def _happens(self, option: str) -> bool:
        """Whether something happens that does so in so many of a hundred cases."""
        return self._rng.randrange(FULL) < self._options[option]

    def _position(self) -> Fact:
        state = self._state
        along = state.drive.place(state.now)[0] if state.drive else state.along
        return ("position", state.room, along)

    def _level(self) -> Fact:
        return ("battery", self._charge())

    def _charge(self) -> int:
        """Return what the battery holds now."""
        state = self._state
        passed = state.now - state.metered
        driven = passed if state.drive is not None else 0
        gained = CHARGE * passed if state.docked else 0
        return max(0, min(FULL, state.battery - driven + gained))

    def _tell(self, *contents: Fact) -> None:
        self._state.sent.extend(Sent(content) for content in contents)

    def _answer(self, ticket: int, result: str, *data: Fact) -> None:
        self._state.sent.append(Sent((result,), ticket, data))


def _message(sent: Sent) -> Message:
    """Return what was sent, as the port has it."""
    if sent.ticket is not None:
        return Finished(sent.ticket, Reply(str(sent.content[0]), sent.data))
    if str(sent.content[0]).startswith(":"):
        return Signal(sent.content)
    return Datum(sent.content)
