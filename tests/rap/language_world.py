"""What tests of the language need from a world package: callables and handlers.

Tests name it `(world "tests.rap.language_world:LanguageWorld")`. The world itself is
never run: what happens is in each test's script.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from random import Random

from rapc.base.source import SourceFile
from rapc.base.values import Atom, Fact
from rapc.ir.nodes import DefineRap, Method
from rapc.parser.parse import parse
from rapc.world import HandlerMemory, Handlers, Kit
from rapc.worlds.scripted import ScriptedWorld


class LanguageWorld(ScriptedWorld):
    """Functions, a default function, problem solvers and handlers of sensor data."""

    name = "language-world"
    kit = Kit()

    def __init__(self, rng: Random, options: Mapping[str, Atom | bool]) -> None:
        super().__init__((), kit=_kit())


# --- functions -----------------------------------------------------------------------


def usual_place(memory: HandlerMemory, index: Fact) -> Atom:
    """Where a thing is if nobody has said so: in the room that is its home."""
    return memory.value("home", index[1]) or "unknown"


def distance(memory: HandlerMemory, here: Atom, there: Atom) -> Atom:
    """How far two things on a rail are apart, if both positions are known."""
    first, second = memory.value("position", here), memory.value("position", there)
    if isinstance(first, int | float) and isinstance(second, int | float):
        return abs(first - second)
    return "unknown"


def heavier(memory: HandlerMemory, this: Atom, that: Atom) -> bool:
    """Whether memory has it that one thing weighs more than another."""
    first, second = memory.value("weight", this), memory.value("weight", that)
    if isinstance(first, int | float) and isinstance(second, int | float):
        return first > second
    return False


# --- problem solvers -----------------------------------------------------------------


def break_open(goal: Fact, memory: HandlerMemory) -> Sequence[Method]:
    """A way that no library of ours has: to break the thing open."""
    return _methods("(method crowbar (context true) (primitive (say crack)))")


def same_again(goal: Fact, memory: HandlerMemory) -> Sequence[Method]:
    """The very method that the RAP has: nothing is won."""
    return _methods("(method key (context (have key)) (primitive (say click)))")


def no_idea(goal: Fact, memory: HandlerMemory) -> Sequence[Method]:
    """No method at all."""
    return ()


def _methods(text: str) -> Sequence[Method]:
    forms = parse(SourceFile("solver", f"(define-rap (any) {text})")).forms
    return [m for rap in forms if isinstance(rap, DefineRap) for m in rap.methods]


# --- handlers ------------------------------------------------------------------------


def _seen(memory: HandlerMemory, datum: Fact) -> None:
    _, item, kind, place = datum
    memory.introduce(str(item), str(kind), place)


def _moved_on(memory: HandlerMemory, datum: Fact) -> None:
    memory.expire()


def _kit() -> Kit:
    """Return what the tests find: the solvers are for solvers.test.rap."""
    return Kit(
        handlers=Handlers(data={"seen": _seen, "moved-on": _moved_on}),
        functions={
            "usual-place": usual_place,
            "distance": distance,
            "heavier": heavier,
        },
        solvers={
            "open-anyhow": break_open,
            "open-again": same_again,
            "fetch-or-plan": no_idea,
        },
    )
