"""The parts of the port's contract, each tested on new worlds.

Errors are lines, with the author's file and row if a call shows the position.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import msgspec
from msgspec.structs import replace

from rapc.base.names import hint
from rapc.base.values import Fact, format_atom, format_list
from rapc.compiler.program import Program
from rapc.errors import FactError, PortError, RefusedError
from rapc.runtime.admission import misfitting, refusals
from rapc.runtime.held_world import HeldWorld
from rapc.testing.contract.declarations import declaring
from rapc.testing.contract.driver import Driver
from rapc.testing.contract.skills import try_skills
from rapc.world import NOT_KNOWN, Drawable, Savable, Skilled, Timed, Truth, World
from rapc.worlds.registry import TYPES

REQUESTS = 150
"""The default number of requests of a world test under one seed."""

SEEDS = (0, 1, 2)
"""The seeds of a world test."""

Make = Callable[[int], World]
"""Returns a new world from a seed, equal for equal seeds."""


class Trial(msgspec.Struct, frozen=True):
    """The result of testing one part of the contract."""

    #: The name of the tested part, in a few words.
    part: str
    #: The errors, as lines; empty if the part passed.
    faults: tuple[str, ...] = ()
    #: The reason why the part was not tested; empty if it was.
    left_out: str = ""
    #: The results of each primitive that no request had, if requests are tested.
    unseen: Mapping[str, tuple[str, ...]] = {}


class _Tried(msgspec.Struct, frozen=True):
    """A world under test: its constructor, and a library that declares it."""

    make: Make
    #: A library of the declarations of the offer only.
    offered: Program
    #: A library with the names that the handlers use, or None.
    library: Program | None
    requests: Sequence[Fact]
    #: The number of requests under each seed.
    count: int
    drivers: list[Driver]

    def held(self, seed: int) -> HeldWorld:
        """Return a new world, checked against its offer."""
        return HeldWorld(self.make(seed), self.offered)

    def driver(self, seed: int, library: Program | None = None) -> Driver:
        """Return a driver in a new world; its handlers run with their library."""
        made = Driver(
            self.make(seed),
            library or self.offered,
            seed,
            library is not None,
            self.requests,
        )
        self.drivers.append(made)
        return made

    def unseen(self) -> dict[str, tuple[str, ...]]:
        """Return the offered results that no request has had, by primitive."""
        seen = {one for driver in self.drivers for one in driver.seen}
        offer = self.make(0).kit.offer.primitives
        found = {
            name: tuple([result for result in results if (name, result) not in seen])
            for name, (_, results) in offer.items()
        }
        return {name: results for name, results in found.items() if results}


def try_world(
    make: Make,
    program: Program | None = None,
    requests: Sequence[Fact] = (),
    count: int = REQUESTS,
) -> tuple[Trial, ...]:
    """Test a world against the port, part by part.

    Args:
        make: makes the world.
        program: a library that declares the offer of the world and the names that its
            handlers use; without a library the handlers do not run.
        requests: the first requests; the rest are random, about the facts that the
            world has reported.
        count: the number of requests under each seed.
    """
    offered = Program(declaring(make(0).kit.offer))
    tried = _Tried(make, offered, program, requests, count, [])
    trials: list[Trial] = []
    for part, check in _PARTS.items():
        if any(trial.part == CODE and trial.faults for trial in trials):
            trials.append(Trial(part, left_out="correct the code first"))
        else:
            trials.append(_try(tried, part, check))
    return tuple(
        replace(trial, unseen=tried.unseen())
        if trial.part == ASKING and not trial.left_out
        else trial
        for trial in trials
    )


def _try(tried: _Tried, part: str, check: Callable[[_Tried], Iterator[str]]) -> Trial:
    """Test one part; an exception of the world's own code counts as an error."""
    world = tried.make(0)
    if part in _NEEDS:
        needs, otherwise = _NEEDS[part]
        if not needs(tried, world):
            return Trial(part, left_out=otherwise)
    try:
        return Trial(part, tuple(dict.fromkeys(check(tried))))
    except (PortError, FactError) as error:
        return Trial(part, (error.message,))
    except RefusedError as error:
        return Trial(part, error.reasons)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # a world's code may raise any exception
        try:
            HeldWorld(world).blame(error)
        except PortError as told:
            return Trial(part, (told.message,))


# --- the parts ------------------------------------------------------------------------


def _offer(tried: _Tried) -> Iterator[str]:
    """Test that options, offer and handlers fit together."""
    kit = tried.make(0).kit
    names = [option.name for option in kit.options]
    for name in dict.fromkeys(n for n in names if names.count(n) > 1):
        yield f"duplicate option `{name}`"
    for option in kit.options:
        if type(option.default) not in TYPES[option.kind]:
            what = f"the default of the option `{option.name}`"
            yield f"{what}, {option.default!a}, is not of kind {option.kind}"
    for name, (count, results) in kit.offer.primitives.items():
        if count < 0 or "okay" not in results or len(set(results)) < len(results):
            yield f"the results of `{name}` must be different and include `okay`"
    for what, listed, known in (
        ("the handler of", kit.handlers.results, kit.offer.primitives),
        ("the handler of the datum", kit.handlers.data, kit.offer.data),
        ("the sensor", kit.offer.sensors, kit.offer.primitives),
        ("not atomic", kit.offer.not_atomic, kit.offer.primitives),
    ):
        for name in listed:
            if name not in known:
                meant = hint(name, known)
                yield f"{what} `{name}`: unknown name{meant}"


def _code(tried: _Tried) -> Iterator[str]:
    """Test the signatures of the code, and the library against the world."""
    world = tried.held(0)
    yield from misfitting(tried.library or tried.offered, world)
    if tried.library is not None:
        yield from refusals(tried.library, world)


def _start(tried: _Tried) -> Iterator[str]:
    """Test that a new world has its clock at 0, no message, and valid facts."""
    world = tried.held(0)
    if world.now() != 0:
        yield f"the clock starts at {format_atom(world.now())}, not at 0"
    ended = world.ended()
    if ended is not None:
        yield f"{world.breach('ended', f'ended the run before its start: {ended!a}')}"
    world.facts()


def _requests(tried: _Tried) -> Iterator[str]:
    """Test that replies are declared, time advances, and runs are repeatable."""
    for seed in SEEDS:
        one, other = tried.driver(seed), tried.driver(seed)
        one.drive(tried.count)
        other.drive(tried.count)
        pairs = zip(one.history, other.history, strict=False)
        for first, second in pairs:
            if first != second:
                yield (
                    f"two runs with seed {seed} differ: first {_short(first)}, "
                    f"then {_short(second)}; take all randomness from `rng`"
                )
                return


def _short(happened: tuple[object, ...]) -> str:
    text = " ".join(map(str, happened))
    return text if len(text) <= 120 else text[:120] + "..."


def _time(tried: _Tried) -> Iterator[str]:
    """Test that time advances as requested, and announced messages come."""
    for seed in SEEDS:
        world = tried.held(seed)
        world.messages()
        for _ in range(20):
            now, due = world.now(), world.next_time()
            target = now + 10 if due in (None, NOT_KNOWN) else due
            assert target is not None
            world.advance(target)
            sent = world.messages()
            if world.ended() is not None:
                break
            if world.now() < target and due != NOT_KNOWN:
                said = f"did not advance the clock to {format_atom(target)}"
                raise world.breach("advance", said)
            if due not in (None, NOT_KNOWN) and not sent:
                said = f"announced time {format_atom(target)}, but sent no message then"
                raise world.breach("next_time", said)
        before = world.now()
        world.advance(0)
        if world.now() < before:
            yield f"{world.breach('advance', 'sets the clock back')}"
        world.cancel(10**6)


def _saving(tried: _Tried) -> Iterator[str]:
    """Test that a world continues from a saved state without a difference."""
    for seed in SEEDS:
        driver, copy = tried.driver(seed), tried.held(seed)
        world = driver.world
        assert isinstance(world, Savable)
        assert isinstance(copy, Savable)
        driver.drive(tried.count // 2)
        state = world.save()
        if world.save() != state:
            said = "returns a different state when called again"
            yield f"{driver.world.breach('save', said)}"
            return
        copy.restore(state)
        if copy.save() != state:
            said = "does not restore the whole state"
            yield f"{driver.world.breach('restore', said)}"
            return
        yield from _apart(driver, copy, tried.count // 2)
        try:
            copy.restore(b"no state")
        except ValueError:
            continue
        said = "accepts a state that is not its own; raise ValueError"
        yield f"{driver.world.breach('restore', said)}"


def _apart(driver: Driver, copy: HeldWorld, requests: int) -> Iterator[str]:
    """Yield the differences between a world and its restored copy."""
    world = driver.world
    for ticket in range(10**6, 10**6 + requests):
        request = driver.request()
        if request is None or world.ended() is not None:
            return
        answers = [one.perform(ticket, request) for one in (world, copy)]
        for one in (world, copy):
            due = one.next_time()
            if answers[0] is None and due not in (None, NOT_KNOWN):
                one.advance(due or 0)
        seen = [
            (one.now(), one.next_time(), list(one.messages())) for one in (world, copy)
        ]
        if answers[0] != answers[1] or seen[0] != seen[1]:
            said = "continues differently from the saved world"
            yield f"{world.breach('restore', said)}"
            return


def _picture(tried: _Tried) -> Iterator[str]:
    """Test that a picture is consistent, and drawing it has no side effects."""
    one, other = tried.driver(0), tried.driver(0)
    world = one.world
    assert isinstance(world, Drawable)
    for _ in range(10):
        picture = world.picture()
        names = [spot.name for spot in picture.spots]
        if len(set(names)) < len(names):
            yield "two spots of the picture have the same name"
        for name in {picture.here, *(end for road in picture.roads for end in road)}:
            if name not in names:
                yield f"the picture has no spot `{name}`"
        one.drive(5)
        other.drive(5)
    if one.history != other.history:
        yield f"{one.world.breach('picture', 'changes the world')}"


def _truth(tried: _Tried) -> Iterator[str]:
    """Test that the true facts are of declared names, without side effects."""
    one, other = tried.driver(0), tried.driver(0)
    world = one.world
    assert isinstance(world, Truth)
    signatures = None if tried.library is None else tried.library.signatures
    for _ in range(10):
        for name, facts in world.truth().items():
            if signatures is None:
                continue
            if name not in signatures.relations:
                yield f"the truth has facts of `{name}`, an undeclared name"
                return
            for fact in facts:
                fault = signatures.wrong_kind("asserted", name, fact[1:])
                if fault is not None:
                    yield f"the truth has {format_list(fact)}: {fault}"
                    return
        one.drive(5)
        other.drive(5)
    if one.history != other.history:
        yield f"{one.world.breach('truth', 'changes the world')}"


def _usual_times(tried: _Tried) -> Iterator[str]:
    """Request the usual time of each request: the call must change nothing."""
    driver = tried.driver(0)
    world = driver.world
    assert isinstance(world, Timed)
    for _ in range(tried.count):
        request = driver.request()
        now = driver.world.now()
        if request is not None:
            world.usual_time(request)
        if driver.world.now() != now:
            yield f"{driver.world.breach('usual_time', 'advances the clock')}"
            return


def _skills(tried: _Tried) -> Iterator[str]:
    """Test that skills are switched on or refused, and are silent when off."""
    for seed in SEEDS:
        copy = tried.held(seed)
        if not isinstance(copy, Skilled):
            yield f"the world `{copy.name}` offers skills but has no `activate`"
            return
        yield from try_skills(tried.driver(seed), copy)


def _handlers(tried: _Tried) -> Iterator[str]:
    """Test that handlers assert declared facts, and obey `:on` and `:tells`."""
    for seed in SEEDS:
        assert tried.library is not None
        tried.driver(seed, tried.library).drive(tried.count)
    yield from ()


ASKING = "requests and messages"
CODE = "signatures of the code"
SAVING = "save and restore"
PICTURE = "picture"
TRUTH = "truth"
SKILLS = "skills"
TIMES = "usual times"
HANDLERS = "handlers"

_PARTS: Mapping[str, Callable[[_Tried], Iterator[str]]] = {
    "offer": _offer,
    CODE: _code,
    "start": _start,
    ASKING: _requests,
    "time": _time,
    SAVING: _saving,
    PICTURE: _picture,
    TRUTH: _truth,
    TIMES: _usual_times,
    SKILLS: _skills,
    HANDLERS: _handlers,
}

_NEEDS: Mapping[str, tuple[Callable[[_Tried, World], bool], str]] = {
    SAVING: (lambda _, world: isinstance(world, Savable), "no `save` and `restore`"),
    PICTURE: (lambda _, world: isinstance(world, Drawable), "no `picture`"),
    TRUTH: (lambda _, world: isinstance(world, Truth), "no `truth`"),
    TIMES: (
        lambda _, world: isinstance(world, Timed),
        "no `usual_time`",
    ),
    SKILLS: (lambda _, world: bool(world.kit.offer.skills), "no skills in the offer"),
    HANDLERS: (
        lambda tried, _: tried.library is not None,
        "no library: `--test LIBRARY`",
    ),
}
"""The requirements of some parts, and the reasons for leaving a part out."""
