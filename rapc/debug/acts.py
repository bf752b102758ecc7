"""What a user does to a run, as values: done once, and once more at each replay.

A run is made again from a saved state by doing what was done to it at the same moments.
So whatever changes a run under the debugger is one of these, or another text of the
library (`rapc.debug.reload`). Settings are part of what a run is made with; options of
the world and results that are forced are part of its state.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import msgspec
from msgspec.structs import replace

from rapc.base.names import hint
from rapc.base.values import Atom, Fact, Text, format_list, match_pattern, typed
from rapc.compiler.program import Program
from rapc.errors import ArgumentError
from rapc.library.signatures import Signatures
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving.format import RunRecord, decode_run, encode_run
from rapc.runtime.settings import Settings, read_settings
from rapc.runtime.task_request import TaskRequest, as_text
from rapc.world import Adjustable, Refused, Reply, Savable, Skilled, World, innermost
from rapc.worlds.faults import InjectedFault, SubstituteWorld, problem
from rapc.worlds.registry import OWN_SETTINGS, read_options


def taken_up(run: Interpreter, program: Program, record: RunRecord) -> Interpreter:
    """Return a run of a library that stands where a record says.

    Args:
        run: the run that it takes the place of; nothing changes in that.
        program: the library.
        record: the state, as this library and its settings have it.

    Raises:
        RefusedError: if the library cannot be run in the world.
        StateError: if the record is no state of such a run.
    """
    found = run.remade(program, record.settings)
    found.restore(encode_run(record))
    return found


class Act(msgspec.Struct, frozen=True):
    """Something that the user does to a run between two cycles."""

    @abstractmethod
    def do(self, run: Interpreter) -> Interpreter | None:
        """Do it, and return the run that takes the place of `run`, if one does.

        Raises:
            Error: if it cannot be done; then nothing has changed.
        """

    @abstractmethod
    def __str__(self) -> str:
        """The act in a few words."""


class AssertFact(Act, frozen=True):
    """Asserts a fact on behalf of the user."""

    fact: Fact

    def do(self, run: Interpreter) -> None:
        """Assert the fact."""
        run.assert_fact(*self.fact)

    def __str__(self) -> str:
        return f"assert {format_list(self.fact)}"


class EraseFacts(Act, frozen=True):
    """Erases every fact that starts with a prefix."""

    prefix: Fact

    def do(self, run: Interpreter) -> None:
        """Erase the facts."""
        run.erase(*self.prefix)

    def __str__(self) -> str:
        return f"erase {format_list(self.prefix)}"


class SubmitTask(Act, frozen=True):
    """Gives the robot a task."""

    request: TaskRequest

    def do(self, run: Interpreter) -> None:
        """Submit the task."""
        run.submit(self.request)

    def __str__(self) -> str:
        return f"submit {as_text(self.request)}"


class CancelTasks(Act, frozen=True):
    """Cancels the top-level tasks that a goal matches."""

    goal: Fact

    def do(self, run: Interpreter) -> None:
        """Cancel them.

        Raises:
            ArgumentError: if there are none.
        """
        if not run.cancel(self.goal):
            raise ArgumentError(
                f"no top-level task under way is {format_list(self.goal)}"
            )

    def __str__(self) -> str:
        return f"cancel {format_list(self.goal)}"


class SendSignal(Act, frozen=True):
    """Sends a signal to the tasks that wait for it."""

    content: Fact

    def do(self, run: Interpreter) -> None:
        """Send the signal."""
        run.signal(*self.content)

    def __str__(self) -> str:
        return f"signal {format_list(self.content)}"


class FailTask(Act, frozen=True):
    """Lets a task fail, as if a condition of it did not hold."""

    task: int

    def do(self, run: Interpreter) -> None:
        """Fail the task; a method that it is at ends first."""
        run.fail_task(self.task)

    def __str__(self) -> str:
        return f"fail [{self.task}]"


class RetryTask(Act, frozen=True):
    """Lets the method of a task end badly, so that the task chooses again."""

    task: int

    def do(self, run: Interpreter) -> None:
        """End the method.

        Raises:
            ArgumentError: for a task that is at work on none.
        """
        run.retry_task(self.task)

    def __str__(self) -> str:
        return f"retry [{self.task}]"


class ChangeOption(Act, frozen=True):
    """Lets a run go on with another setting, or with another option of its world."""

    #: `rapc`, or the name of the world.
    owner: str
    name: str
    value: Atom | bool

    def do(self, run: Interpreter) -> Interpreter | None:
        """Change the option.

        Raises:
            ArgumentError: if the world does not let it be changed, or not so.
            PortError: if the world breaks.
            StateError: if the run cannot be saved: another setting makes it anew.
        """
        if self.owner == OWN_SETTINGS:
            settings = replace(run.settings, **{_field(self.name): self.value})
            record = replace(decode_run(run.save()), settings=settings)
            return taken_up(run, run.library, record)
        world = run.port
        if not isinstance(world, Adjustable):
            raise ArgumentError(
                f"the world `{world.name}` lets no option be changed while it runs"
            )
        try:
            text = isinstance(self.value, Text)
            world.adjust(self.name, typed(self.value) if text else self.value)
        except ValueError as said:
            raise ArgumentError(f"the world `{world.name}` refuses: {said}") from said
        return None

    def __str__(self) -> str:
        return f"option {self.owner}.{self.name} {typed(self.value)}"


def _field(name: str) -> str:
    """Return the field of the settings that a name stands for."""
    return name.replace("-", "_")


def changeable_options(run: Interpreter) -> dict[str, Atom | bool]:
    """Return what can be changed while a run goes on, `owner.name`, with its value.

    Raises:
        PortError: if the world breaks, or returns no mapping.
    """
    names = Settings.__struct_fields__
    own = {
        f"{OWN_SETTINGS}.{n.replace('_', '-')}": getattr(run.settings, n) for n in names
    }
    world = run.port
    known = world.adjustable() if isinstance(world, Adjustable) else {}
    return own | {f"{world.name}.{name}": value for name, value in known.items()}


def change_option(run: Interpreter, owner: str, name: str, text: str) -> Act:
    """Return the act that gives an option another value.

    Args:
        run: the run.
        owner: `rapc`, or the name of the world.
        name: the name of the option.
        text: the value, as it is typed.

    Raises:
        SettingError: for a setting that is none, or a value that it does not take.
        WorldError: for an option that the world has not, or a value of another kind.
        ArgumentError: for another owner, or an option of a world that stays as it is.
    """
    world = run.port
    if owner == OWN_SETTINGS:
        value = getattr(read_settings({name: text}), _field(name))
        return ChangeOption(owner, name, value)
    if owner != world.name:
        raise ArgumentError(f"`{owner}` is neither `{OWN_SETTINGS}` nor `{world.name}`")
    read = read_options(type(innermost(world)), {name: text})
    if isinstance(world, Adjustable) and name not in (known := world.adjustable()):
        said = f"`{owner}.{name}` counts at the beginning of a run alone"
        raise ArgumentError(said + hint(name, known))
    return ChangeOption(owner, name, read[name])


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
                    f"the world `{world.name}` lets no result be forced: "
                    "it has skills, or cannot be saved"
                )
            held.enclose(world := ForcedWorld(world))
        world.forced.append(Forced(self.pattern, self.result, self.times))

    def __str__(self) -> str:
        often = f" {self.times} times" if self.times > 1 else ""
        return f"force {format_list(self.pattern)} {self.result}{often}"
