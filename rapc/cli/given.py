"""What a run is begun with, from the command line: for the commands that begin one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import click

from rapc.base.values import Fact, format_list
from rapc.cli.options import fail
from rapc.compiler.program import Program
from rapc.errors import (
    FactError,
    RefusedError,
    SavedError,
    SettingError,
    TextError,
    WorldError,
)
from rapc.library.library import Library
from rapc.library.signatures import Signatures
from rapc.parser.parse import parse_fact
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings, read_settings
from rapc.runtime.task_request import (
    TaskRequest,
    as_text,
    of_agenda,
    read_task_request,
)
from rapc.testing.faults import read_fault, told_for_skills
from rapc.world import World
from rapc.worlds import registry
from rapc.worlds.faults import FaultyWorld, InjectedFault, problem

F = TypeVar("F", bound=Callable[..., Any])


class GivenRun(NamedTuple):
    """A run that has not begun, and what it is to begin with."""

    interpreter: Interpreter
    world: World
    #: The options of the world that were given.
    options: Mapping[str, Any]
    requests: tuple[TaskRequest, ...]
    facts: tuple[Fact, ...]
    #: The tasks and faults as texts, for the trace.
    tasks: tuple[str, ...]
    faults: tuple[str, ...]

    def begin(self) -> None:
        """Begin the run: facts first, then tasks."""
        facts = [format_list(fact) for fact in self.facts]
        self.interpreter.start(self.options, self.tasks, self.faults, facts)
        for fact in self.facts:
            self.interpreter.assert_fact(*fact)
        for request in self.requests:
            self.interpreter.submit(request)


def run_options(command: F) -> F:
    """Add the options that say what a run begins with."""
    options = (
        click.option(
            "--task",
            "tasks",
            multiple=True,
            metavar="'(RAP ARGS) [OPTIONS]'",
            help="Task to run; :priority N, :deadline T, :at T, :background true may "
            "follow.",
        ),
        click.option(
            "--agenda",
            metavar="NAME",
            help="Agenda of the library: its tasks come before those of --task.",
        ),
        click.option(
            "--seed", type=int, default=0, show_default=True, help="Seed of the run."
        ),
        click.option(
            "--fact",
            "facts",
            multiple=True,
            metavar="'(FACT)'",
            help="Fact in memory at first.",
        ),
        click.option(
            "--set",
            "values",
            multiple=True,
            metavar="OWNER.NAME=VALUE",
            help="Option of the world, or rapc.NAME for a setting of the interpreter.",
        ),
        click.option(
            "--fault",
            "faults",
            multiple=True,
            metavar="'(REQUEST) RESULT [p=..] [from=..] [until=..]'",
            help="Let requests fail so; may be given several times.",
        ),
    )
    for option in reversed(options):
        command = option(command)
    return command


def prepare(
    library: Program,
    world_name: str,
    tasks: Sequence[str],
    agenda: str | None,
    seed: int,
    facts: Sequence[str],
    values: Sequence[str],
    faults: Sequence[str],
) -> GivenRun:
    """Return a run of a library in a world that can begin; else end the command.

    Args:
        library: what is run.
        world_name: the name of a world, or `module:Class`.
        tasks: the options `--task`.
        agenda: the option `--agenda`.
        seed: the option `--seed`.
        facts: the options `--fact`.
        values: the options `--set`.
        faults: the options `--fault`.
    """
    first = _of_agenda(library, agenda)
    requests = (*first, *map(_submission, tasks))
    known = tuple(map(_fact, facts))
    failing = [_fault(text) for text in faults]
    interpreter, options, world = _build(library, world_name, seed, values, failing)
    _refuse(interpreter, requests, known)
    texts = (*map(as_text, first), *tasks)
    return GivenRun(interpreter, world, options, requests, known, texts, tuple(faults))


def _of_agenda(library: Program, name: str | None) -> tuple[TaskRequest, ...]:
    if name is None:
        return ()
    try:
        return of_agenda(library.library, name)
    except RefusedError as refused:
        fail(*[f"--agenda: {reason}" for reason in refused.reasons])


def _submission(text: str) -> TaskRequest:
    try:
        return read_task_request(text)
    except TextError as error:
        fail(f"--task: {error}")


def _fact(text: str) -> Fact:
    try:
        return parse_fact(text)
    except TextError as error:
        fail(f"--fact: {error}")


def _fault(text: str) -> InjectedFault:
    try:
        return read_fault(text)
    except TextError as error:
        fail(f"--fault: {error}")


def _with_faults(
    world: World, library: Library, faults: Sequence[InjectedFault], seed: int
) -> World:
    """A world with faults, if any; ends the command for one that cannot be."""
    offered = Signatures.offered(world.kit.offer)
    for fault in faults:
        wrong = problem(fault, offered, told_for_skills(library))
        if wrong is not None:
            fail(f"--fault: {wrong}")
    return FaultyWorld(world, faults, seed) if faults else world


def _build(
    library: Program,
    world_name: str,
    seed: int,
    values: Sequence[str],
    faults: Sequence[InjectedFault],
) -> tuple[Interpreter, Mapping[str, Any], World]:
    """The interpreter for a library in a world; ends the command if it cannot be."""
    own: dict[str, str] = {}
    texts: dict[str, str] = {}
    try:
        world_class = registry.find_world(world_name)
        for setting in values:
            owner, name, value = registry.split_setting(setting)
            if owner not in ("rapc", world_class.name):
                fail(f"--set: `{owner}` is neither `rapc` nor `{world_class.name}`")
            (own if owner == "rapc" else texts)[name] = value
        options = registry.read_options(world_class, texts)
        world = registry.build_world(world_class, seed, options)
        world = _with_faults(world, library.library, faults, seed)
    except WorldError as error:
        fail(error.message, error.help)
    try:
        return Interpreter(library, world, seed, _settings(own)), options, world
    except RefusedError as refused:
        others = registry.having(refused.lacking) if refused.lacking else ()
        meant = [f"the world `{name}` has them all" for name in others]
        fail(*refused.reasons, *meant)


def _settings(texts: Mapping[str, str]) -> Settings:
    try:
        return read_settings(texts)
    except SettingError as error:
        fail(f"--set: {error}")


def _refuse(
    interpreter: Interpreter, submissions: Sequence[TaskRequest], facts: Sequence[Fact]
) -> None:
    """Refuse tasks and facts that cannot be, before anything is run or written."""
    try:
        interpreter.check(submissions)
        for fact in facts:
            interpreter.check_fact(*fact)
    except RefusedError as refused:
        fail(*refused.reasons)
    except FactError as error:
        fail(f"--fact: {error}")
    except SavedError as error:
        fail(str(error))
