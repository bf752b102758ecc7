"""The world of the laboratory: a bench, two arms, and people.

The robot heats samples, measures them and reports the values. The
file has four parts: the offer of the world, the handlers that update
the memory of the robot, the state of the bench, and the world.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from random import Random
from typing import Any

from rapc.world import (
    Atom,
    Datum,
    Fact,
    Finished,
    Gauge,
    HandlerMemory,
    Handlers,
    Kit,
    Message,
    Offer,
    Option,
    Picture,
    Refused,
    Reply,
    Signal,
    SimpleWorld,
    Spot,
    Time,
)

STATIONS = {"rack": 0, "bench": 2, "heater": 4, "instrument": 6, "tray": 8}
"""The stations and their positions along the bench."""

SPACE = {"heater": 1, "instrument": 1}
"""The number of samples at a station; at the others there is no limit."""

ARMS = ("left", "right")
SAMPLES = ("s1", "s2", "s3", "s4", "s5", "s6")
WALK_INS = ("s5", "s6")
"""The samples that people bring during the shift."""

DUE = {"s1": 260, "s2": 340, "s3": 420, "s4": 500}
"""The deadlines of the samples that are in the rack at the start."""

DEGREES = {"s1": 60, "s2": 80, "s3": 60, "s4": 80, "s5": 70, "s6": 70}
"""The temperature that each sample requires."""

ROOM = 20
HEATS = 5
"""The degrees that the heater gains or loses in a time unit."""
STEP = 10
"""The degrees between two messages of the thermometer."""
COOLS = 150
"""The time after which a heated sample is cold again."""
STANDARD = 50
"""The true value of the reference standard in the instrument."""
TOLERANCE = 3
"""The largest error of a report that is right."""

POWERED = ("reach", "grip", "release", "change-fuse", "wipe", "close-hood")
"""The actions of the arms: none while the stop button is pressed."""

TAKES = {
    "grip": 2,
    "release": 1,
    "look": 1,
    "set-heater": 1,
    "incubate": 20,
    "measure": 6,
    "read-standard": 2,
    "calibrate": 8,
    "report": 1,
    "change-fuse": 10,
    "wipe": 6,
    "close-hood": 4,
    "ventilate": 15,
    "acknowledge": 1,
    "call-for": 1,
}
"""The time that each action takes; `reach` depends on the way."""

OPTIONS = (
    Option(
        "people", "integer", 90, "time units", "between visits; 0: none"
    ),
    Option("slips", "integer", 15, "%", "grips that slip"),
    Option("drops", "integer", 2, "%", "grips that break the sample"),
    Option("blocked", "integer", 8, "%", "movements that meet a hand"),
    Option("missed", "integer", 10, "%", "samples that the camera misses"),
    Option("fuse", "integer", 8, "%", "starts that blow the fuse"),
    Option("smoke", "integer", 10, "%", "heatings that begin to smoke"),
    Option(
        "drift", "number", 0.4, "per reading", "drift of the instrument"
    ),
    Option("noise", "number", 0.8, "units", "noise of a reading"),
    Option("absent", "integer", 25, "%", "calls that nobody hears"),
    Option("walk-ins", "integer", 2, "samples", "brought in the shift"),
)

OFFER = Offer(
    primitives={
        "reach": (2, ("okay", "blocked", "stopped")),
        "grip": (
            2,
            (
                "okay",
                "slipped",
                "broken",
                "not-here",
                "hand-full",
                "stopped",
            ),
        ),
        "release": (
            1,
            ("okay", "occupied", "no-place", "empty-hand", "stopped"),
        ),
        "look": (1, ("okay",)),
        "set-heater": (1, ("okay", "fuse-blown")),
        "incubate": (1, ("okay", "no-sample", "too-cold")),
        "measure": (1, ("okay", "no-sample", "no-signal")),
        "read-standard": (0, ("okay",)),
        "calibrate": (0, ("okay", "failed")),
        "report": (2, ("okay", "refused")),
        "change-fuse": (1, ("okay", "hand-full", "no-fuse", "stopped")),
        "wipe": (2, ("okay", "hand-full", "stopped")),
        "close-hood": (1, ("okay", "jammed", "stopped")),
        "ventilate": (0, ("okay", "still-smoky")),
        "acknowledge": (0, ("okay", "still-pressed")),
        "call-for": (1, ("okay", "busy")),
    },
    data={
        "seen": 2,
        "looked": 1,
        "temperature": 1,
        "reading": 2,
        "standard": 1,
        "spilt": 1,
        "hood": 1,
        "stop": 1,
        "arrived": 3,
        "moving": 1,
    },
    events={":alarm": 1, ":broken": 1, ":helper": 1, ":jolt": 0},
    sensors=("look", "read-standard"),
    not_atomic=(
        "reach",
        "incubate",
        "measure",
        "calibrate",
        "change-fuse",
        "wipe",
        "close-hood",
        "ventilate",
    ),
    arguments={
        "reach": ("arm", "station"),
        "grip": ("arm", "sample"),
        "release": ("arm",),
        "look": ("station",),
        "set-heater": ("degrees",),
        "incubate": ("sample",),
        "measure": ("sample",),
        "report": ("sample", "value"),
        "change-fuse": ("arm",),
        "wipe": ("arm", "station"),
        "close-hood": ("arm",),
        "call-for": ("need",),
        "seen": ("sample", "station"),
        "looked": ("station",),
        "temperature": ("degrees",),
        "reading": ("sample", "value"),
        "standard": ("value",),
        "spilt": ("station",),
        "hood": ("state",),
        "stop": ("state",),
        "arrived": ("sample", "degrees", "due"),
        "moving": ("arm",),
        ":alarm": ("trouble",),
        ":broken": ("sample",),
        ":helper": ("need",),
    },
)


# --- the handlers: what the robot remembers --------------------------


def reach_ended(memory: HandlerMemory, request: Fact, result: str) -> None:
    """Note the station of the arm."""
    _, arm, station = request
    there = station if result == "okay" else "unknown"
    memory.assert_fact("arm-at", arm, there)


def moving(memory: HandlerMemory, datum: Fact) -> None:
    """Note that an arm has left its station."""
    memory.assert_fact("arm-at", datum[1], "unknown")


def grip_ended(memory: HandlerMemory, request: Fact, result: str) -> None:
    """Note a sample in the hand, or a sample that is not here."""
    _, arm, sample = request
    if result == "okay":
        memory.assert_fact("sample-at", sample, arm)
    elif result == "not-here":
        memory.assert_fact("sample-at", sample, "unknown")
    elif result == "broken":
        memory.assert_fact("sample-at", sample, "lost")


def release_ended(
    memory: HandlerMemory, request: Fact, result: str
) -> None:
    """Note the new place of the sample that the arm held."""
    arm = request[1]
    place = memory.value("arm-at", arm)
    if result != "okay" or place is None:
        return
    for solution in memory.ask("(sample-at ?sample ?arm)", {"?arm": arm}):
        memory.assert_fact("sample-at", solution["?sample"], place)


def looked(memory: HandlerMemory, datum: Fact) -> None:
    """Note the look; samples that were expected here are not here.

    The datum comes before the data `seen` of the same look.
    """
    station = datum[1]
    for solution in memory.ask(
        "(sample-at ?sample ?station)", {"?station": station}
    ):
        memory.assert_fact("sample-at", solution["?sample"], "unknown")
    memory.assert_fact("looked", station)


def seen(memory: HandlerMemory, datum: Fact) -> None:
    """Note the station of a sample."""
    _, sample, station = datum
    memory.assert_fact("sample-at", sample, station)


def heater_set(memory: HandlerMemory, request: Fact, result: str) -> None:
    """Note the temperature that the heater is set to."""
    if result == "okay":
        memory.assert_fact("heater-set", request[1])
    else:
        memory.assert_fact("heater-set", ROOM)
        memory.assert_fact("fuse-blown")


def fuse_changed(
    memory: HandlerMemory, request: Fact, result: str
) -> None:
    """Note the new fuse, or that the box is empty."""
    if result == "okay":
        memory.erase("fuse-blown")
    elif result == "no-fuse":
        memory.assert_fact("no-fuses")


def standard_read(memory: HandlerMemory, datum: Fact) -> None:
    """Note the value of the reference standard."""
    memory.assert_fact("standard-value", datum[1])


def calibrate_ended(
    memory: HandlerMemory, request: Fact, result: str
) -> None:
    """Note the calibration: the standard now has its value."""
    if result == "okay":
        memory.assert_fact("standard-value", STANDARD)


def report_ended(
    memory: HandlerMemory, request: Fact, result: str
) -> None:
    """Note the value that was reported."""
    if result == "okay":
        memory.assert_fact("reported", request[1], request[2])


def wipe_ended(memory: HandlerMemory, request: Fact, result: str) -> None:
    """Note the end of the spill."""
    if result == "okay":
        memory.erase("spill", request[2])


def hood_closed(memory: HandlerMemory, request: Fact, result: str) -> None:
    """Note the closed hood."""
    if result == "okay":
        memory.assert_fact("hood", "closed")


def air_clear(memory: HandlerMemory, request: Fact, result: str) -> None:
    """Note the end of the smoke."""
    if result == "okay":
        memory.erase("alarm", "smoke")


def acknowledged(
    memory: HandlerMemory, request: Fact, result: str
) -> None:
    """Note that the arms have power; where they are is not known."""
    if result == "okay":
        memory.assert_fact("stop", "ready")
        for arm in ARMS:
            memory.assert_fact("arm-at", arm, "unknown")


def noted(memory: HandlerMemory, datum: Fact) -> None:
    """Note a datum as a fact of the same name."""
    memory.assert_fact(*datum)


def spilt(memory: HandlerMemory, datum: Fact) -> None:
    """Note a spill."""
    memory.assert_fact("spill", datum[1])


def arrived(memory: HandlerMemory, datum: Fact) -> None:
    """Note a sample that somebody has put into the rack."""
    _, sample, degrees, due = datum
    memory.assert_fact("requires", sample, degrees)
    memory.assert_fact("due", sample, due)
    memory.assert_fact("sample-at", sample, "rack")
    memory.assert_fact("walk-in", sample)


HANDLERS = Handlers(
    results={
        "reach": reach_ended,
        "grip": grip_ended,
        "release": release_ended,
        "set-heater": heater_set,
        "change-fuse": fuse_changed,
        "calibrate": calibrate_ended,
        "report": report_ended,
        "wipe": wipe_ended,
        "close-hood": hood_closed,
        "ventilate": air_clear,
        "acknowledge": acknowledged,
    },
    data={
        "looked": looked,
        "seen": seen,
        "temperature": noted,
        "reading": noted,
        "standard": standard_read,
        "spilt": spilt,
        "hood": noted,
        "stop": noted,
        "arrived": arrived,
        "moving": moving,
    },
)


# --- the state of the bench ------------------------------------------


@dataclass
class Bench:
    """Everything that changes, as plain data."""

    #: The place of each arm; "between" while the arm moves.
    arms: dict[str, str]
    #: The place of each sample: a station, an arm, "lost" or "away".
    samples: dict[str, str]
    #: The true value of each sample.
    values: dict[str, float]
    #: When each heated sample was heated.
    heated: dict[str, Time] = field(default_factory=dict)
    reports: dict[str, list[Any]] = field(default_factory=dict)
    #: The heater: its temperature at a time, and where it is set to.
    degrees: Time = ROOM
    degrees_at: Time = 0
    target: int = ROOM
    fuses: int = 1
    fuse_blown: bool = False
    drift: float = 0.0
    spills: list[str] = field(default_factory=list)
    smoke: bool = False
    hood: str = "closed"
    stop: str = "ready"
    due: dict[str, int] = field(default_factory=lambda: dict(DUE))
    #: The requests under way: end, ticket, request.
    under_way: list[list[Any]] = field(default_factory=list)
    #: The events to come: time, event, argument.
    events: list[list[Any]] = field(default_factory=list)
    broken: int = 0
    hood_open: Time = 0
    hood_since: Time = 0


def understood(request: Fact) -> bool:
    """Return whether all arguments are values of the laboratory."""
    known: dict[str, Any] = {
        "arm": ARMS,
        "station": STATIONS,
        "sample": SAMPLES,
        "need": ("fuses", *SAMPLES),
    }
    name, *arguments = request
    names = OFFER.arguments.get(str(name), ())
    return all(
        argument in known[key]
        if key in known
        else isinstance(argument, (int, float))
        for key, argument in zip(names, arguments, strict=True)
    )


# --- the world -------------------------------------------------------

QUIET = ("move",)
"""The events without a message: nobody tells the robot."""


class LaboratoryWorld(SimpleWorld):
    """A robot with two arms at a bench with a heater and an instrument.

    Raises:
        ValueError: for an option out of range.
    """

    name = "laboratory"
    kit = Kit(OFFER, HANDLERS, OPTIONS)
    state: Bench

    def __init__(
        self, rng: Random, options: Mapping[str, Atom | bool]
    ) -> None:
        super().__init__(rng, options)
        for option in OPTIONS:
            most = 100 if option.unit == "%" else 10_000
            if not 0 <= self.number(option.name) <= most:
                raise ValueError(f"`{option.name}` is out of range")
        samples = {
            sample: "away" if sample in WALK_INS else "rack"
            for sample in SAMPLES
        }
        values = {
            sample: rng.randrange(100, 900) / 10 for sample in SAMPLES
        }
        arms = dict.fromkeys(ARMS, "bench")
        self.state = Bench(arms, samples, values)
        for sample in WALK_INS[: int(self.number("walk-ins"))]:
            self.plan(rng.randrange(80, 400), "arrive", sample)
        self.plan_visit()

    def number(self, option: str) -> float:
        """Return the value of an option."""
        value = self.options[option]
        assert isinstance(value, (int, float))
        return value

    def chance(self, option: str) -> bool:
        """Return whether an event with a chance in per cent happens."""
        return self.rng.random() * 100 < self.number(option)

    def facts(self) -> list[Fact]:
        """Return the stations, the samples in the rack and the devices."""
        facts: list[Fact] = [("station", name) for name in STATIONS]
        facts += [("arm", arm) for arm in ARMS]
        for arm in ARMS:
            facts.append(("arm-at", arm, "bench"))
        for sample, due in DUE.items():
            facts.append(("sample-at", sample, "rack"))
            facts.append(("requires", sample, DEGREES[sample]))
            facts.append(("due", sample, due))
        facts += [("hood", "closed"), ("stop", "ready")]
        facts += [("temperature", ROOM), ("heater-set", ROOM)]
        return facts

    # --- time ---

    def plan(self, after: Time, event: str, about: str = "") -> None:
        """Plan an event: a method of this class."""
        self.state.events.append([self.time + after, event, about])

    def forget(self, event: str) -> None:
        """Remove all planned events of a name."""
        self.state.events = [
            planned for planned in self.state.events if planned[1] != event
        ]

    def next_time(self) -> Time | None:
        """Return the time of the next message."""
        times = [end for end, _, _ in self.state.under_way]
        times += [
            time
            for time, event, _ in self.state.events
            if event not in QUIET
        ]
        message = super().next_time()
        if message is not None:
            times.append(message)
        return max(self.time, min(times)) if times else None

    def advance(self, to: Time) -> None:
        """Advance the clock, with all ends and events on the way."""
        while True:
            plans = self.state.events + self.state.under_way
            plan = min(plans, key=lambda plan: plan[0], default=None)
            if plan is None or plan[0] > to:
                break
            super().advance(plan[0])
            if plan in self.state.events:
                self.state.events.remove(plan)
                getattr(self, plan[1])(plan[2])
            else:
                self.end(plan)
        super().advance(to)

    def tell(self, *content: Atom) -> None:
        """Send a signal or a datum."""
        signal = str(content[0]).startswith(":")
        message: Message = Signal(content) if signal else Datum(content)
        self.send(message)

    # --- requests ---

    def perform(
        self, ticket: int, request: Fact
    ) -> Reply | Refused | None:
        """Carry out an action, or start one that takes time."""
        name = str(request[0])
        if not understood(request):
            return Reply(OFFER.primitives[name][1][-1])
        if name in POWERED and self.state.stop != "ready":
            return Reply("stopped")
        if name in OFFER.not_atomic:
            takes = self.usual_time(request)
            self.state.under_way.append(
                [self.time + takes, ticket, list(request)]
            )
            if name == "reach":
                self.state.arms[str(request[1])] = "between"
                self.tell("moving", request[1])
            return None
        self.advance(self.time + self.usual_time(request))
        return self.outcome(request)

    def outcome(self, request: Fact | list[Atom]) -> Reply:
        """Return the reply to a request whose time has passed."""
        name, *arguments = request
        act = getattr(self, "do_" + str(name).replace("-", "_"))
        reply = act(*arguments)
        return reply if isinstance(reply, Reply) else Reply(reply)

    def end(self, action: list[Any], result: str = "") -> None:
        """End an action under way, with its outcome or another result."""
        self.state.under_way.remove(action)
        reply = Reply(result) if result else self.outcome(action[2])
        self.send(Finished(action[1], reply))

    def end_all(self, names: tuple[str, ...], result: str) -> None:
        """End all actions under way of some names."""
        for action in list(self.state.under_way):
            if action[2][0] in names:
                self.end(action, result)

    def cancel(self, ticket: int) -> None:
        """Stop an action; an arm stays where it is."""
        super().cancel(ticket)
        self.state.under_way = [
            action
            for action in self.state.under_way
            if action[1] != ticket
        ]

    def usual_time(self, request: Fact) -> Time:
        """Return the time that a request takes."""
        name = str(request[0])
        if name == "reach" and understood(request):
            here = STATIONS.get(self.state.arms[str(request[1])], 0)
            return 2 + abs(here - STATIONS[str(request[2])]) // 2
        return TAKES.get(name, 1)

    # --- arms ---

    def do_reach(self, arm: str, station: str) -> str:
        """Move an arm to a station."""
        if self.chance("blocked"):
            return "blocked"
        self.state.arms[arm] = station
        return "okay"

    def held(self, place: str) -> list[str]:
        """Return the samples at a station or in an arm."""
        samples = self.state.samples
        return [sample for sample in samples if samples[sample] == place]

    def do_grip(self, arm: str, sample: str) -> Reply | str:
        """Take a sample into the hand."""
        state = self.state
        place = state.arms[arm]
        if self.held(arm):
            return "hand-full"
        if place not in STATIONS or state.samples[sample] != place:
            return "not-here"
        if self.chance("slips"):
            return "slipped"
        if self.chance("drops"):
            state.samples[sample] = "lost"
            state.broken += 1
            if place not in state.spills:
                state.spills.append(place)
            self.tell(":broken", sample)
            self.tell(":alarm", "spill")
            return Reply("broken", (("spilt", place),))
        state.samples[sample] = arm
        return "okay"

    def do_release(self, arm: str) -> str:
        """Put the sample in the hand down at the place of the arm."""
        place = self.state.arms[arm]
        held = self.held(arm)
        if not held:
            return "empty-hand"
        if place not in STATIONS:
            return "no-place"
        if len(self.held(place)) >= SPACE.get(place, len(SAMPLES)):
            return "occupied"
        self.state.samples[held[0]] = place
        return "okay"

    def do_wipe(self, arm: str, station: str) -> str:
        """Wipe a spill with an empty hand."""
        if self.held(arm):
            return "hand-full"
        if station in self.state.spills:
            self.state.spills.remove(station)
        return "okay"

    def do_close_hood(self, arm: str) -> str:
        """Close the fume hood."""
        if self.chance("blocked"):
            return "jammed"
        if self.state.hood == "open":
            self.state.hood_open += self.time - self.state.hood_since
        self.state.hood = "closed"
        return "okay"

    # --- heater ---

    def temperature(self) -> Time:
        """Return the temperature of the heater."""
        state = self.state
        change = HEATS * (self.time - state.degrees_at)
        if state.target >= state.degrees:
            return min(state.target, state.degrees + change)
        return max(state.target, state.degrees - change)

    def set_target(self, degrees: int) -> None:
        """Set the heater to a temperature."""
        state = self.state
        state.degrees, state.degrees_at = self.temperature(), self.time
        state.target = degrees
        self.forget("gauge")
        self.plan(STEP / HEATS, "gauge")
        self.end_all(("incubate",), "too-cold")

    def gauge(self, about: str) -> None:
        """Send the temperature while it changes."""
        self.tell("temperature", self.temperature())
        if self.temperature() != self.state.target:
            self.plan(STEP / HEATS, "gauge")

    def do_set_heater(self, degrees: int) -> str:
        """Set the heater; a cold heater may blow its fuse."""
        state = self.state
        if degrees > ROOM and (state.fuse_blown or self.chance("fuse")):
            state.fuse_blown = True
            self.set_target(ROOM)
            return "fuse-blown"
        self.set_target(degrees)
        self.forget("smoke")
        if degrees > ROOM and self.chance("smoke"):
            self.plan(self.rng.randrange(10, 40), "smoke")
        return "okay"

    def do_incubate(self, sample: str) -> str:
        """Heat the sample in the heater."""
        if self.state.samples[sample] != "heater":
            return "no-sample"
        if self.temperature() < DEGREES[sample]:
            return "too-cold"
        self.state.heated[sample] = self.time
        return "okay"

    def do_change_fuse(self, arm: str) -> str:
        """Change the fuse of the heater with an empty hand."""
        if self.held(arm):
            return "hand-full"
        if self.state.fuses == 0:
            return "no-fuse"
        self.state.fuses -= 1
        self.state.fuse_blown = False
        return "okay"

    def smoke(self, about: str) -> None:
        """The heater begins to smoke."""
        self.state.smoke = True
        self.tell(":alarm", "smoke")

    def do_ventilate(self) -> str:
        """Blow the smoke out; a heater that is on makes new smoke."""
        if self.state.target > ROOM:
            return "still-smoky"
        self.state.smoke = False
        return "okay"

    # --- instrument ---

    def do_measure(self, sample: str) -> Reply | str:
        """Measure a sample; light from an open hood spoils the signal."""
        state = self.state
        if state.samples[sample] != "instrument":
            return "no-sample"
        if state.hood == "open":
            return "no-signal"
        cooked = self.time - state.heated.get(sample, -COOLS) < COOLS
        value = state.values[sample] * (1 if cooked else 0.7)
        state.drift += self.number("drift")
        return Reply("okay", (("reading", sample, self.read(value)),))

    def read(self, value: float) -> float:
        """Return a value as the instrument reads it."""
        noise = self.rng.uniform(-1, 1) * self.number("noise")
        return round(value + self.state.drift + noise, 1)

    def do_read_standard(self) -> Reply:
        """Measure the reference standard."""
        return Reply("okay", (("standard", self.read(STANDARD)),))

    def do_calibrate(self) -> str:
        """Adjust the instrument by the reference standard."""
        if self.chance("blocked"):
            return "failed"
        self.state.drift = 0.0
        return "okay"

    def jolt(self, about: str) -> None:
        """Let somebody bump into the instrument."""
        self.state.drift += self.rng.choice((-4, 4))
        self.tell(":jolt")
        self.plan_visit()

    # --- people ---

    def plan_visit(self) -> None:
        """Plan the next visit of somebody."""
        mean = int(self.number("people"))
        if mean:
            act = self.rng.choice(("move", "open", "press", "jolt"))
            self.plan(self.rng.randint(mean // 2, mean * 3 // 2), act)

    def move(self, about: str) -> None:
        """Let somebody move a sample without a word."""
        loose = self.held("rack") + self.held("bench")
        if loose:
            sample = self.rng.choice(loose)
            from_rack = self.state.samples[sample] == "rack"
            self.state.samples[sample] = "bench" if from_rack else "rack"
        self.plan_visit()

    def open(self, about: str) -> None:
        """Let somebody open the fume hood."""
        if self.state.hood == "closed":
            self.state.hood_since = self.time
        self.state.hood = "open"
        self.tell("hood", "open")
        self.tell(":alarm", "door")
        self.plan_visit()

    def press(self, about: str) -> None:
        """Let somebody press the stop button, and free it later."""
        self.state.stop = "pressed"
        self.end_all(POWERED, "stopped")
        self.tell("stop", "pressed")
        self.forget("free")
        self.plan(self.rng.randrange(10, 40), "free")
        self.plan_visit()

    def free(self, about: str) -> None:
        """Let somebody free the stop button."""
        self.state.stop = "released"
        self.tell("stop", "released")

    def do_acknowledge(self) -> str:
        """Give the arms power after a stop."""
        if self.state.stop == "pressed":
            return "still-pressed"
        self.state.stop = "ready"
        return "okay"

    def arrive(self, sample: str) -> None:
        """Let somebody bring a sample."""
        self.state.samples[sample] = "rack"
        due = int(self.time) + 250
        self.state.due[sample] = due
        self.tell("arrived", sample, DEGREES[sample], due)

    def do_call_for(self, need: str) -> str:
        """Call somebody, who may come, with a fuse or a new sample."""
        if self.chance("blocked"):
            return "busy"
        if not self.chance("absent"):
            self.plan(self.rng.randrange(10, 30), "help", need)
        return "okay"

    def help(self, need: str) -> None:
        """Let somebody bring what the robot has called for."""
        state = self.state
        if need == "fuses":
            state.fuses += 2
        elif state.samples[need] == "lost":
            state.samples[need] = "rack"
            state.heated.pop(need, None)
            self.tell("seen", need, "rack")
        self.tell(":helper", need)

    # --- looking and reporting ---

    def do_look(self, station: str) -> Reply:
        """Look at a station; the camera may miss a sample."""
        found = [
            ("seen", sample, station)
            for sample in self.held(station)
            if not self.chance("missed")
        ]
        return Reply("okay", (("looked", station), *found))

    def do_report(self, sample: str, value: float) -> str:
        """Report the value of a sample, once."""
        if sample in self.state.reports:
            return "refused"
        self.state.reports[sample] = [self.time, value]
        return "okay"

    def figures(self) -> dict[str, Atom]:
        """Return the truth about the shift so far."""
        state = self.state
        right = late = 0
        for sample, (time, value) in state.reports.items():
            right += abs(value - state.values[sample]) <= TOLERANCE
            late += time > state.due[sample]
        still_open = self.time - state.hood_since
        hood_open = state.hood_open + still_open * (state.hood == "open")
        return {
            "right": right,
            "wrong": len(state.reports) - right,
            "late": late,
            "broken": state.broken,
            "hood-open": hood_open,
        }

    def truth(self) -> Mapping[str, list[Fact]]:
        """Return the places of arms and samples, and the devices."""
        state = self.state
        return {
            "arm-at": [
                ("arm-at", arm, place)
                for arm, place in state.arms.items()
                if place in STATIONS
            ],
            "sample-at": [
                ("sample-at", sample, place)
                for sample, place in state.samples.items()
                if place != "away"
            ],
            "hood": [("hood", state.hood)],
            "stop": [("stop", state.stop)],
            "spill": [("spill", place) for place in state.spills],
        }

    def picture(self) -> Picture:
        """Return the stations with their samples, and the devices."""
        state = self.state
        spots = [
            Spot(
                station,
                at=(5 * position, 0),
                note=" ".join(self.held(station)),
            )
            for station, position in STATIONS.items()
        ]
        gauges = [
            Gauge(sample, place, ("sample-at", sample))
            for sample, place in state.samples.items()
            if place != "away"
        ]
        gauges += [
            Gauge(arm, state.arms[arm], ("arm-at", arm)) for arm in ARMS
        ]
        gauges += [
            Gauge("heater", self.temperature(), ("temperature",)),
            Gauge("hood", state.hood, ("hood",)),
            Gauge("stop", state.stop, ("stop",)),
        ]
        return Picture("bench", tuple(spots), gauges=tuple(gauges))
