"""Results that are forced: the next requests that a pattern matches end as is said.

The world that a run has is put behind one that answers for it. What is forced still is
part of the state of the run, so that it is taken back with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from rapc.base.values import Fact, format_list, match_pattern
from rapc.debug.acts import Act
from rapc.errors import ArgumentError
from rapc.library.signatures import Signatures
from rapc.runtime.interpreter import Interpreter
from rapc.world import Refused, Reply, Savable, Skilled, World
from rapc.worlds.faults import InjectedFault, SubstituteWorld, problem


class Forced(msgspec.Struct):
    """Requests whose result is forced, and how many of them."""

    pattern: Fact
    result: str
    left: int


class _Saved(msgspec.Struct, frozen=True):
    world: bytes
    forced: list[Forced]


class ForcedWorld(SubstituteWorld):
    """A world some of whose next requests end as the user wants.

    A request that is forced never reaches the world behind. It takes as long as such a
    request usually does, where that world can say.
    """

    Saved = _Saved
    has = "results"

    def __init__(self, world: World) -> None:
        super().__init__(world)
        #: What is still forced, in the order in which it was asked for.
        self.forced: list[Forced] = []

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Answer as is forced, or hand the request on."""
        for one in self.forced:
            if match_pattern(one.pattern, request) is not None:
                one.left -= 1
                self.forced = [other for other in self.forced if other.left > 0]
                return self.answer(request, one.result)
        return super().perform(ticket, request)

    def own(self) -> tuple[list[Forced]]:
        """Return what is still forced."""
        return (self.forced,)

    def read(self, saved: _Saved) -> Mapping[str, Any]:
        """Return what is still forced."""
        return {"forced": saved.forced}


class ForceResult(Act, frozen=True):
    """Lets the next requests that a pattern matches end with a result."""

    #: A pattern over the requests as the world gets them, items by sensor name.
    pattern: Fact
    result: str
    times: int = 1

    def do(self, run: Interpreter) -> None:
        """Force the result.

        Raises:
            ArgumentError: for a request or a result that the world does not offer, and
                for a world of skills or one that cannot be saved.
        """
        held = run.machine.world
        world: World = held.behind
        wrong = problem(
            InjectedFault(self.pattern, self.result),
            Signatures.offered(world.kit.offer),
        )
        if wrong is not None:
            raise ArgumentError(wrong)
        if not isinstance(world, ForcedWorld):
            if isinstance(world, Skilled) or not isinstance(world, Savable):
                raise ArgumentError(
                    f"the world `{world.name}` lets no result be forced: "
                    "it has skills, or cannot be saved"
                )
            held.enclose(world := ForcedWorld(world))
        world.forced.append(Forced(self.pattern, self.result, self.times))

    def __str__(self) -> str:
        often = f" {self.times} times" if self.times > 1 else ""
        return f"force {format_list(self.pattern)} {self.result}{often}"
