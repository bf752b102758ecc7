"""Acts of the user on a run, as values that a replay can repeat.

A replay starts from a saved state and repeats the acts of the user at the same moments.
Therefore every change to a run under the debugger is an `Act`; the act that reloads the
library is in `rapc.debug.reload`. A run is constructed with its settings. Options of
the world and forced results are part of the state of the run.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import msgspec
from msgspec.structs import replace

from rapc.base.names import hint
from rapc.base.values import Atom, Fact, format_list, match_pattern, typed
from rapc.compiler.program import Program
from rapc.errors import ArgumentError
from rapc.library.signatures import Signatures
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving.format import RunRecord, decode_run, encode_run
from rapc.runtime.settings import read_settings
from rapc.runtime.task_request import TaskRequest, as_text
from rapc.spec import Plain
from rapc.world import Adjustable, Refused, Reply, Savable, Skilled, World, innermost
from rapc.worlds.faults import InjectedFault, SubstituteWorld, problem
from rapc.worlds.registry import OWN_SETTINGS, check_options, plain_values, read_options


def taken_up(run: Interpreter, program: Program, record: RunRecord) -> Interpreter:
    """Return a run of a library, restored to a saved state.

    Args:
        run: the run to replace; it stays unchanged.
        program: the library.
        record: the saved state, valid for the library and its settings.

    Raises:
        RefusedError: if the library cannot be run in the world.
        StateError: if the library cannot restore the record.
    """
    found = run.remade(program, record.settings)
    found.restore(encode_run(record))
    return found


class Act(msgspec.Struct, frozen=True, tag_field="do"):
    """An act of the user on a run, between two cycles.

    The tag of a kind of act, and the texts of its fields, are its form in a file
    (`rapc.debug.act_lines`).
    """

    @abstractmethod
    def do(self, run: Interpreter) -> Interpreter | None:
        """Perform the act; return the run that replaces `run`, or None.

        Raises:
            Error: if the act is impossible; the run is then unchanged.
        """

    @abstractmethod
    def __str__(self) -> str:
        """Return a short text for the act."""


class AssertFact(Act, frozen=True, tag="assert"):
    """An act that asserts a fact for the user."""

    fact: Fact

    def do(self, run: Interpreter) -> None:
        """Assert the fact."""
        run.assert_fact(*self.fact)

    def __str__(self) -> str:
        return f"asserted {format_list(self.fact)}"


class EraseFacts(Act, frozen=True, tag="erase"):
    """An act that erases every fact with a given prefix."""

    prefix: Fact

    def do(self, run: Interpreter) -> None:
        """Erase the facts."""
        run.erase(*self.prefix)

    def __str__(self) -> str:
        return f"erased {format_list(self.prefix)}"


class SubmitTask(Act, frozen=True, tag="submit"):
    """An act that submits a task."""

    request: TaskRequest

    def do(self, run: Interpreter) -> None:
        """Submit the task."""
        run.submit(self.request)

    def __str__(self) -> str:
        return f"submitted {as_text(self.request)}"


class CancelTasks(Act, frozen=True, tag="cancel"):
    """An act that cancels the top-level tasks that match a goal."""

    goal: Fact

    def do(self, run: Interpreter) -> None:
        """Cancel the tasks.

        Raises:
            ArgumentError: if no top-level task matches the goal.
        """
        if not run.cancel(self.goal):
            raise ArgumentError(
                f"no top-level task under way matches {format_list(self.goal)}"
            )

    def __str__(self) -> str:
        return f"cancelled {format_list(self.goal)}"


class SendSignal(Act, frozen=True, tag="signal"):
    """An act that sends a signal to the tasks that wait for it."""

    content: Fact

    def do(self, run: Interpreter) -> None:
        """Send the signal."""
        run.signal(*self.content)

    def __str__(self) -> str:
        return f"sent signal {format_list(self.content)}"


class FailTask(Act, frozen=True, tag="fail"):
    """An act that makes a task fail, as if one of its conditions were false."""

    task: int

    def do(self, run: Interpreter) -> None:
        """Fail the task; end its current method first."""
        run.fail_task(self.task)

    def __str__(self) -> str:
        return f"failed task [{self.task}]"


class RetryTask(Act, frozen=True, tag="retry"):
    """An act that makes the method of a task fail; the task then chooses again."""

    task: int

    def do(self, run: Interpreter) -> None:
        """End the method.

        Raises:
            ArgumentError: if the task has no method under way.
        """
        run.retry_task(self.task)

    def __str__(self) -> str:
        return f"failed the method of task [{self.task}]"


class ChangeOption(Act, frozen=True, tag="option"):
    """An act that changes a setting of the run or an option of its world."""

    #: `rapc`, or the name of the world.
    owner: str
    name: str
    value: Plain

    def do(self, run: Interpreter) -> Interpreter | None:
        """Change the option.

        Raises:
            ArgumentError: if the option cannot change in a run, or the world does not
                accept the value.
            SettingError: for an unknown setting or an invalid value.
            WorldError: for a value of the wrong kind.
            PortError: if the world raises an exception.
            StateError: if the run cannot be saved, to apply a setting.
        """
        if self.owner == OWN_SETTINGS:
            named = {**run.settings.named(), self.name: self.value}
            settings = read_settings(named)
            record = replace(decode_run(run.save()), settings=settings)
            return taken_up(run, run.library, record)
        world = run.port
        if not isinstance(world, Adjustable):
            raise ArgumentError(
                f"the world `{world.name}` has no options that can change during a run"
            )
        known = world.adjustable() if self.owner == world.name else {}
        if self.name not in known:
            said = f"`{self.owner}.{self.name}` cannot change during a run"
            raise ArgumentError(said + hint(self.name, known))
        check_options(type(innermost(world)), {self.name: self.value})
        try:
            world.adjust(self.name, self.value)
        except ValueError as said:
            raise ArgumentError(f"the world `{world.name}` refuses: {said}") from said
        return None

    def __str__(self) -> str:
        return f"set {self.owner}.{self.name} to {typed(self.value)}"


def changeable_options(run: Interpreter) -> dict[str, Atom | bool]:
    """Return the options that can change during a run, by `owner.name`.

    Raises:
        PortError: if the world raises an exception or does not return a mapping.
    """
    named = run.settings.named()
    own: dict[str, Atom | bool] = {f"{OWN_SETTINGS}.{n}": v for n, v in named.items()}
    world = run.port
    known = world.adjustable() if isinstance(world, Adjustable) else {}
    return own | {f"{world.name}.{name}": value for name, value in known.items()}


def change_option(run: Interpreter, owner: str, name: str, text: str) -> Act:
    """Return the act that sets an option to a value.

    Args:
        run: the run.
        owner: `rapc`, or the name of the world.
        name: the name of the option.
        text: the value as the user typed it.

    Raises:
        SettingError: for an unknown setting or an invalid value.
        WorldError: for an unknown option of the world or a value of the wrong kind.
        ArgumentError: for an unknown owner.
    """
    world = run.port
    if owner == OWN_SETTINGS:
        return ChangeOption(owner, name, read_settings({name: text}).named()[name])
    if owner != world.name:
        raise ArgumentError(
            f"unknown owner `{owner}`; expected `{OWN_SETTINGS}` or `{world.name}`"
        )
    read = read_options(type(innermost(world)), {name: text})
    return ChangeOption(owner, name, plain_values(read)[name])


class Forced(msgspec.Struct):
    """A pattern of requests, their forced result, and the number of uses left."""

    pattern: Fact
    result: str
    left: int


class _Saved(msgspec.Struct, frozen=True):
    world: bytes
    forced: list[Forced]


class ForcedWorld(SubstituteWorld):
    """A wrapper of a world that ends some requests with a forced result.

    A forced request never reaches the wrapped world. The request takes its usual time
    if the wrapped world can report that time.
    """

    Saved = _Saved
    has = "results"

    def __init__(self, world: World) -> None:
        super().__init__(world)
        #: The pending forced results, oldest first.
        self.forced: list[Forced] = []

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Answer with the forced result, or pass the request to the wrapped world."""
        for one in self.forced:
            if match_pattern(one.pattern, request) is not None:
                one.left -= 1
                self.forced = [other for other in self.forced if other.left > 0]
                return self.answer(request, one.result)
        return super().perform(ticket, request)

    def own(self) -> tuple[list[Forced]]:
        """Return the pending forced results."""
        return (self.forced,)

    def read(self, saved: _Saved) -> Mapping[str, Any]:
        """Return the pending forced results of a saved state, by attribute."""
        return {"forced": saved.forced}


class ForceResult(Act, frozen=True, tag="force"):
    """An act that forces the result of the next requests that match a pattern."""

    #: A pattern over requests as the world receives them: items by sensor name.
    pattern: Fact
    result: str
    times: int = 1

    def do(self, run: Interpreter) -> None:
        """Force the result.

        Raises:
            ArgumentError: for a request or a result that the world does not offer, for
                a world with skills, and for a world that cannot be saved.
        """
        held = run.port
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
                    f"cannot force results in world `{world.name}`: the world has "
                    "skills or cannot be saved"
                )
            held.enclose(world := ForcedWorld(world))
        world.forced.append(Forced(self.pattern, self.result, self.times))

    def __str__(self) -> str:
        often = f" {self.times} times" if self.times > 1 else ""
        return f"forced {format_list(self.pattern)} {self.result}{often}"
