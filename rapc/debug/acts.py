"""What a user does to a run, as values: done once, and once more at each replay.

A run is made again from a saved state by doing what was done to it at the same moments.
So whatever a session changes in a run is one of these. An act may change what the run
is made with, its library and settings.
"""

from __future__ import annotations

from abc import abstractmethod

import msgspec

from rapc.base.values import Fact, format_list
from rapc.compiler.program import Program
from rapc.errors import ArgumentError
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.saving.format import RunRecord, encode_run
from rapc.runtime.settings import Settings
from rapc.runtime.state.states import INTERFERENCE
from rapc.runtime.state.task import Task
from rapc.runtime.task_request import TaskRequest, as_text
from rapc.runtime.tasks.finish import end_method, fail


def made_with(run: Interpreter, program: Program, settings: Settings) -> Interpreter:
    """Return a run of a library with settings, in the world of another run.

    It is `run` itself if that is made so. Another one stands nowhere before a state is
    restored in it; it has the listeners of `run`.

    Raises:
        RefusedError: if the library cannot be run in the world.
    """
    if run.machine.library is program and run.settings == settings:
        return run
    return run.remade(program, settings)


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
        machine, task = run.machine, live_task(run, self.task)
        if task.run is not None:
            end_method(machine, task.run, INTERFERENCE, None, "cancelled")
        machine.agenda.discard(task)
        fail(machine, task, INTERFERENCE)

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
        task = live_task(run, self.task)
        if task.run is None:
            raise ArgumentError(f"task [{self.task}] is at work on no method")
        end_method(run.machine, task.run, INTERFERENCE, None, "cancelled")

    def __str__(self) -> str:
        return f"retry [{self.task}]"


def live_task(run: Interpreter, number: int) -> Task:
    """Return a live task of a run by its number.

    Raises:
        ArgumentError: if there is none.
    """
    for task in run.machine.state.live_tasks():
        if task.number == number:
            return task
    top = run.machine.state.numbers
    if 0 < number <= top:
        raise ArgumentError(f"task [{number}] has ended: ask at an earlier moment")
    raise ArgumentError(f"there is no task [{number}]")
