"""What a run is begun with, from the command line: for the commands that begin one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import click

from rapc.base.later import later
from rapc.base.values import Fact, format_list
from rapc.cli.options import fail
from rapc.compiler.program import Program
from rapc.errors import FactError, RefusedError, SettingError, TextError
from rapc.library.library import Library
from rapc.library.signatures import Signatures
from rapc.parser.parse import parse_fact
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import read_settings
from rapc.runtime.task_request import TaskRequest, as_text, of_agenda, read_task_request
from rapc.world import World
from rapc.worlds import registry

if TYPE_CHECKING:
    from rapc.testing import faults as fault_texts
    from rapc.worlds import faults as worlds_faults
    from rapc.worlds.faults import InjectedFault
else:
    fault_texts = later("rapc.testing.faults")
    worlds_faults = later("rapc.worlds.faults")

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")
R = TypeVar("R")


class RunOptions(NamedTuple):
    """What the options say that `run_options` adds, each under its name there."""

    tasks: Sequence[str] = ()
    agenda: str | None = None
    seed: int = 0
    facts: Sequence[str] = ()
    values: Sequence[str] = ()
    faults: Sequence[str] = ()


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


def prepare(library: Program, world_name: str, given: RunOptions) -> GivenRun:
    """Return a run of a library in a world that can begin; else end the command.

    Args:
        library: what is run.
        world_name: the name of a world, or `module:Class`.
        given: what the run is to begin with.
    """
    first = _of_agenda(library, given.agenda)
    tasks = [read_option("--task", read_task_request, text) for text in given.tasks]
    requests = (*first, *tasks)
    facts = tuple([read_option("--fact", parse_fact, text) for text in given.facts])
    faults = [
        read_option("--fault", fault_texts.read_fault, text) for text in given.faults
    ]
    interpreter, options, world = _build(library, world_name, given, faults)
    _refuse(interpreter, requests, facts)
    texts = (*map(as_text, first), *given.tasks)
    return GivenRun(
        interpreter, world, options, requests, facts, texts, tuple(given.faults)
    )


def _of_agenda(library: Program, name: str | None) -> tuple[TaskRequest, ...]:
    if name is None:
        return ()
    try:
        return of_agenda(library.library, name)
    except RefusedError as refused:
        fail(*[f"--agenda: {reason}" for reason in refused.reasons])


def read_option(name: str, read: Callable[[T], R], given: T) -> R:
    """Return what `read` makes of an option; a fault in it ends the command."""
    try:
        return read(given)
    except (TextError, SettingError, FactError) as error:
        fail(f"{name}: {error}")


def _with_faults(
    world: World, library: Library, faults: Sequence[InjectedFault], seed: int
) -> World:
    """A world with faults, if any; ends the command for one that cannot be."""
    if not faults:
        return world
    offered = Signatures.offered(world.kit.offer)
    told = fault_texts.told_for_skills(library)
    for fault in faults:
        wrong = worlds_faults.problem(fault, offered, told)
        if wrong is not None:
            fail(f"--fault: {wrong}")
    return worlds_faults.FaultyWorld(world, faults, seed)


def _build(
    library: Program,
    world_name: str,
    given: RunOptions,
    faults: Sequence[InjectedFault],
) -> tuple[Interpreter, Mapping[str, Any], World]:
    """The interpreter for a library in a world; ends the command if it cannot be."""
    own: dict[str, str] = {}
    texts: dict[str, str] = {}
    world_class = registry.find_world(world_name)
    for setting in given.values:
        owner, name, value = registry.split_setting(setting)
        if owner not in ("rapc", world_class.name):
            fail(f"--set: `{owner}` is neither `rapc` nor `{world_class.name}`")
        (own if owner == "rapc" else texts)[name] = value
    options = registry.read_options(world_class, texts)
    world = registry.build_world(world_class, given.seed, options)
    world = _with_faults(world, library.library, faults, given.seed)
    try:
        settings = read_option("--set", read_settings, own)
        return Interpreter(library, world, given.seed, settings), options, world
    except RefusedError as refused:
        others = registry.having(refused.lacking) if refused.lacking else ()
        meant = [f"the world `{name}` has them all" for name in others]
        fail(*refused.reasons, *meant)


def _refuse(
    interpreter: Interpreter, requests: Sequence[TaskRequest], facts: Sequence[Fact]
) -> None:
    """Refuse tasks and facts that cannot be, before anything is run or written."""
    interpreter.check(requests)
    for fact in facts:
        read_option("--fact", lambda parts: interpreter.check_fact(*parts), fact)
