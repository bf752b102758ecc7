"""Whose fault it is when Python code of a world, or of a host, breaks in a run.

A world's methods, its handlers, and functions, solvers and comparators are code of
their authors. What such code raises is a `PortError` that names the code with file and
line. What a listener raises is the host's own and goes through untouched; anything
else is a fault of rapc. How many arguments the code takes is looked at beforehand.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from inspect import signature
from pathlib import Path
from types import FrameType, FunctionType, MethodType
from typing import NoReturn, TypeGuard

import msgspec

from rapc.base.code_places import code_of, frames, place_of, place_of_error, said_by
from rapc.base.names import plural
from rapc.errors import PortError
from rapc.language.atoms import is_atom
from rapc.world import Drawable, Fact, Picture, Refused, Reply, Savable, Signal, World

Named = Mapping[str, Callable[..., object]]
"""Python code by the name under which a library knows it."""

_GIVEN = {
    "the handler of": ("memory", "request", "result"),
    "the handler of the datum": ("memory", "datum"),
    "the solver of": ("goal", "memory"),
    "the comparator": ("one", "other"),
    "the default function": ("memory", "index"),
}
"""What code is called with, by what it is."""

_VARIADIC = 0x04
"""The flag of a function with `*args`."""

PORT = {
    "facts": 0,
    "now": 0,
    "perform": 2,
    "next_time": 0,
    "advance": 1,
    "messages": 0,
    "ended": 0,
    "cancel": 1,
}
"""How many arguments the methods of a world are called with."""

SKILLED = {"activate": 3, "deactivate": 1}
"""Those of a world with skills."""


# --- beforehand -----------------------------------------------------------------------


def wrong_arities(what: str, code: Named, given: int) -> Iterator[str]:
    """Yield a line for each callable that does not take the `given` arguments.

    Args:
        what: says what the callables are: `the solver`.
        code: the callables by name.
        given: how many arguments each is called with.
    """
    for name, call in code.items():
        if not callable(call):
            yield f"{what} `{name}` is no function"
        elif not takes(call, given):
            count = plural(given, "argument")
            named = f" ({', '.join(_GIVEN[what])})" if what in _GIVEN else ""
            yield f"{what} `{name}`{place_of(call)} is called with {count}{named}"


def takes(call: Callable[..., object], given: int) -> bool:
    """Whether `call` may be called with the `given` number of arguments.

    True where Python cannot say, as for some of its own functions.
    """
    if isinstance(call, MethodType):
        return takes(call.__func__, given + 1)
    if not isinstance(call, FunctionType):
        try:
            signature(call).bind(*range(given))
        except TypeError:
            return False
        except ValueError:
            return True
        return True
    code = call.__code__
    required = code.co_argcount - len(call.__defaults__ or ())
    named = code.co_kwonlyargcount - len(call.__kwdefaults__ or ())
    most = given if code.co_flags & _VARIADIC else code.co_argcount
    return required <= given <= most and not named


# --- when it breaks -------------------------------------------------------------------


def blame(error: BaseException, world: World, code: Mapping[str, Named]) -> NoReturn:
    """Raise what `error` is to a host: a `PortError` if an author's code raised it.

    Args:
        error: what came out of a run.
        world: the world of the run.
        code: the other code that was registered, by what it is (`the solver`).

    Raises:
        PortError: if an author's code raised `error`, though it be `SystemExit`.
        BaseException: `error` itself if not.
    """
    if isinstance(error, KeyboardInterrupt | PortError):
        raise error
    passed = [(frame, row) for frame, row in frames(error) if _package(frame) != "rapc"]
    named = {
        found: f"{what} `{name}`"
        for what, table in code.items()
        for name, call in table.items()
        if (found := code_of(call)) is not None
    }
    whose = f"the world `{world.name}`"
    for at, (frame, _) in enumerate(passed):
        if frame.f_code in named or _is_of_world(frame):
            whose = named.get(frame.f_code, whose)
            own = [f for f in passed[at:] if _package(f[0]) == _package(frame)]
            inner, row = own[-1]
            place = f"{Path(inner.f_code.co_filename).name}:{row}"
            raise PortError(f"{whose} failed at {place}: {said_by(error)}") from error
    raise error


def _package(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__")).partition(".")[0]


def _is_of_world(frame: FrameType) -> bool:
    """Whether a frame is that of a method of a world."""
    first = frame.f_locals.get(next(iter(frame.f_code.co_varnames), ""))
    if isinstance(first, tuple) and first:  # of a method with `*args` alone
        first = first[0]
    return isinstance(first, World)


# --- answers of another type ----------------------------------------------------------


def breach(world: World, call: str, said: str) -> PortError:
    """Return what to raise for a `world` that does not keep to the port.

    Args:
        world: the world of the run.
        call: the method of the world that showed it.
        said: says what the world did: `sent nothing`.
    """
    return PortError(f"the world `{world.name}` {said}; see {_method(world, call)}")


@contextmanager
def laid_at(world: World, call: str) -> Iterator[None]:
    """Raise what the block raises as a failure of the method `call` of `world`.

    It is for blocks in which no code of others runs.

    Raises:
        PortError: for whatever the block raises, Ctrl-C left out.
    """
    try:
        yield
    except (KeyboardInterrupt, PortError):
        raise
    except BaseException as error:  # whatever the world's code may raise
        place = place_of_error(error).strip(" ()")
        where = f" at {place}" if place else f" in {_method(world, call)}"
        said = f"the world `{world.name}` failed{where}: {said_by(error)}"
        raise PortError(said) from error


def _method(world: World, call: str) -> str:
    """Return the method of a world, and where its author wrote it."""
    behind = getattr(world, "__wrapped__", world)
    return f"`{call}`{place_of(getattr(behind, call))}"


def wrong_type(world: World, call: str, what: str, value: object) -> PortError:
    """Return what to raise for a `value` of the wrong type from an author's code.

    Args:
        world: the world of the run.
        call: the method of the world that returned it.
        what: says what the value should have been: `the reply to (look)`.
        value: the value.
    """
    shown = ascii(value)
    shown = shown if len(shown) <= _MOST_SHOWN else f"{shown[:_MOST_SHOWN]}..."
    said = f"{what} of the world `{world.name}` is `{shown}`"
    wanted = _WANTED[what if what in _WANTED else call]
    return PortError(f"{said}, not {wanted}; see {_method(world, call)}")


def is_fact(value: object) -> bool:
    """Whether `value` is a fact: a tuple of atoms, the first of them a name."""
    if type(value) is not tuple or not value or type(value[0]) is not str:
        return False
    return all(map(is_atom, value))


def first_facts(world: World) -> list[Fact]:
    """Return what a robot knows at first in `world`.

    Raises:
        PortError: for what is no list of facts, and if `facts` breaks or has no end.
    """
    found: list[Fact] = []
    with laid_at(world, "facts"):
        facts = world.facts()
        if not isinstance(facts, Iterable):
            raise wrong_type(world, "facts", "what the robot knows at first", facts)
        for fact in facts:
            if not is_fact(fact):
                raise wrong_type(world, "facts", "a first fact", fact)
            if len(found) == MOST_FACTS:
                said = f"has more than {MOST_FACTS} first facts"
                raise breach(world, "facts", said)
            found.append(fact)
    return found


def picture_of(world: World) -> Picture:
    """Return the picture of a world that is `Drawable`, with tuples in it.

    Raises:
        PortError: if `picture` breaks, or returns what cannot be drawn.
    """
    assert isinstance(world, Drawable)
    with laid_at(world, "picture"):
        picture = world.picture()
        if not isinstance(picture, Picture):
            raise wrong_type(world, "picture", "the picture", picture)
        try:
            return msgspec.convert(msgspec.to_builtins(picture), Picture)
        except (TypeError, ValueError, RecursionError) as error:
            said = f"returns a picture that cannot be drawn: {error}"
            raise breach(world, "picture", said) from error


def saved_state(world: World) -> bytes:
    """Return the state of a world that is `Savable`.

    Raises:
        PortError: if `save` breaks, or returns no bytes.
    """
    assert isinstance(world, Savable)
    with laid_at(world, "save"):
        state = world.save()
    if not isinstance(state, bytes):
        raise wrong_type(world, "save", "the saved state", state)
    return state


def is_reply(value: object) -> TypeGuard[Reply]:
    """Whether `value` is a reply with a result and data that are facts."""
    if type(value) is not Reply or type(value.result) is not str:
        return False
    return isinstance(value.data, tuple | list) and all(map(is_fact, value.data))


def is_refusal(value: object) -> TypeGuard[Refused]:
    """Whether `value` is a refusal that names requests by their tickets."""
    if type(value) is not Refused or not isinstance(value.conflicts, tuple | list):
        return False
    return all(type(ticket) is int for ticket in value.conflicts)


def is_signal(value: Signal) -> bool:
    """Whether a signal is a fact with the tickets under which it arose."""
    whole = is_fact(value.content) and isinstance(value.tickets, tuple | list)
    return whole and all(type(ticket) is int for ticket in value.tickets)


def is_time(value: object) -> bool:
    """Whether `value` is a time: a number from 0 to `LATEST`."""
    return type(value) in (int, float) and 0 <= value <= LATEST  # type: ignore[operator]


MOST_FACTS = 1_000_000
"""How many first facts a world may have."""

LATEST = 10**15
"""The latest time of a clock: up to it a `float` still has eighths of a time unit."""

_A_FACT = (
    "a tuple of a name and its arguments: symbols as programs write them, numbers, "
    "`Text` for any other text"
)
_A_REPLY = f"a `Reply` whose data are each {_A_FACT}"
_WANTED = {
    "now": "a number from 0 to 10^15",
    "save": "bytes",
    "picture": "a `Picture`",
    "usual_time": "a number from 0 to 10^15",
    "next_time": "a number from 0 to 10^15, `None` or `NOT_KNOWN`",
    "ended": "a text or `None`",
    "perform": f"{_A_REPLY}, `None` or `Refused`",
    "activate": "`None` or a `Refused` that has tickets",
    "facts": "a list of facts",
    "a first fact": _A_FACT,
    "messages": "a list of messages",
    "a message": f"a `Datum` or `Signal` that holds {_A_FACT}, or a `Finished`",
    "the end of a request": _A_REPLY,
}
"""What should have come, by the method of the world or, first, by what it is called."""

_MOST_SHOWN = 60
