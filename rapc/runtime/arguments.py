"""Validate the arguments that a host passes to a run."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

import msgspec

from rapc.base.former import kit_help
from rapc.compiler.program import Program
from rapc.errors import ArgumentError, SettingError, WorldError
from rapc.language.atoms import kind, need_fact
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import TaskRequest
from rapc.spec import RunSpec
from rapc.world import Kit, World


def need_call(value: object, what: str) -> None:
    """Raise ArgumentError unless `value`, named `what`, can be called."""
    if not callable(value):
        raise ArgumentError(f"{what} is {kind(value)}, not callable")


def need_time(value: object, what: str) -> None:
    """Raise ArgumentError unless `value`, named `what`, is a number."""
    if type(value) not in (int, float) or value != value:  # nan  # noqa: PLR0124
        raise ArgumentError(f"{what} is {kind(value)}, not a time")


def need_count(value: object, what: str) -> None:
    """Raise ArgumentError unless `value`, named `what`, is a whole number."""
    if type(value) is not int:
        raise ArgumentError(f"{what} is {kind(value)}, not a whole number")


def need_task(task: object) -> None:
    """Raise ArgumentError unless `task` is a request that a run can hold."""
    if not isinstance(task, TaskRequest):
        raise ArgumentError(f"a task is {kind(task)}", 'as text: "(rap args)"')
    need_fact(task.goal, "the task")
    need_count(task.priority, "the priority of a task")
    for what, time in (("deadline", task.deadline), ("time", task.at)):
        if time is not None:
            need_time(time, f"the {what} of a task")
            if not 0 <= time < inf:
                raise ArgumentError(f"the {what} of a task is {time}, not a time")
    if type(task.background) is not bool:
        raise ArgumentError(f"`background` of a task is {kind(task.background)}")


def need_part(value: object, part: type, what: str, source: str) -> None:
    """Raise ArgumentError unless `value` is a `part` of a run, returned by `source`."""
    if not isinstance(value, part):
        raise ArgumentError(
            f"{what} is {kind(value)}", f"it takes a part of `{source}`"
        )


def need_seed(value: object) -> None:
    """Raise ArgumentError unless `value` is a whole number: the seed of a run."""
    need_count(value, "`seed`")


def need_table(value: object, what: str) -> None:
    """Raise ArgumentError unless `value`, named `what`, has values by name."""
    if value is not None and not isinstance(value, Mapping):
        raise ArgumentError(f"{what} is {kind(value)}", "it takes a dict by name")
    for name in value or ():
        if not isinstance(name, str):
            raise ArgumentError(f"a name in {what} is {kind(name)}, not a text")


def need_program(value: object, what: str) -> None:
    """Raise ArgumentError unless `value`, named `what`, can be executed."""
    if not isinstance(value, Program):
        raise ArgumentError(f"{what} is {kind(value)}", "it takes `library.program`")


def need_world(value: object) -> None:
    """Validate a world: an instance with a name and a `Kit`.

    Raises:
        ArgumentError: for an object that is no world.
        WorldError: for a world with a missing part.
    """
    if not isinstance(value, World):
        wanted = "it takes one that was made: `rapc.open_world(name)`"
        raise ArgumentError(f"`world` is {kind(value)}, not a world", wanted)
    for part, of in (("name", str), ("kit", Kit)):
        if not isinstance(getattr(value, part, None), of):
            said = f"the world of class `{type(value).__qualname__}` does not define"
            raise WorldError(f"{said} {part}", kit_help(value))


def need_spec(value: object) -> None:
    """Raise ArgumentError unless `value` is a `RunSpec` with fields of its types."""
    if not isinstance(value, RunSpec):
        raise ArgumentError(f"`spec` is {kind(value)}, not `rapc.RunSpec`")
    try:
        msgspec.convert(msgspec.to_builtins(value), RunSpec)
    except (msgspec.ValidationError, TypeError) as error:
        raise ArgumentError(f"`spec` is invalid: {error}") from None


def need_settings(settings: object) -> None:
    """Validate settings that a program has made, not the command line.

    Raises:
        ArgumentError: if `settings` have another type.
        SettingError: for a setting with an invalid value.
    """
    if not isinstance(settings, Settings):
        raise ArgumentError(f"`settings` is {kind(settings)}, not `rapc.Settings`")
    try:
        msgspec.convert(msgspec.structs.asdict(settings), Settings)
    except msgspec.ValidationError as error:
        raise SettingError(
            f"a setting has a value that it does not take: {error}"
        ) from None
