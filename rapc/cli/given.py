"""What a run is begun with, from the command line: for the commands that begin one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import click

from rapc.base.later import later
from rapc.base.values import Atom
from rapc.cli.options import fail
from rapc.compiler.program import Program
from rapc.errors import FactError, RefusedError, SettingError, TextError
from rapc.library.library import Library
from rapc.library.signatures import Signatures
from rapc.parser.parse import parse_fact
from rapc.runtime.prepare import Given, PreparedRun, prepare
from rapc.runtime.settings import read_settings
from rapc.runtime.task_request import TaskRequest, of_agenda, read_task_request
from rapc.world import World
from rapc.worlds import registry
from rapc.worlds.registry import find_world

if TYPE_CHECKING:
    from rapc.testing import faults as fault_texts
    from rapc.worlds import faults as worlds_faults
    from rapc.worlds import scripted
    from rapc.worlds.faults import InjectedFault
else:
    fault_texts = later("rapc.testing.faults")
    scripted = later("rapc.worlds.scripted")
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


def prepared(
    library: Program, world_name: str | None, asked: RunOptions
) -> PreparedRun:
    """Return a run of a library in a world that can begin; else end the command.

    Args:
        library: what is run.
        world_name: the name of a world, or `module:Class`; None for a world that offers
            what the library declares and answers no request.
        asked: what the run is to begin with.
    """
    first = _of_agenda(library, asked.agenda)
    tasks = [read_option("--task", read_task_request, text) for text in asked.tasks]
    facts = [read_option("--fact", parse_fact, text) for text in asked.facts]
    faults = [
        read_option("--fault", fault_texts.read_fault, text) for text in asked.faults
    ]
    world_class: type[World]
    world_class = (
        scripted.ScriptedWorld if world_name is None else find_world(world_name)
    )
    own, theirs = _by_owner(world_class, asked.values)
    if world_name is None:
        if theirs:
            fail("--set: without a world there are no options of a world")
        options: dict[str, Atom | bool] = {}
        world: World = scripted.ScriptedWorld([], declared=library.library)
    else:
        options = registry.read_options(world_class, theirs)
        world = registry.build_world(world_class, asked.seed, options)
    world = _with_faults(world, library.library, faults, asked.seed)
    given = Given(
        seed=asked.seed,
        settings=read_option("--set", read_settings, own),
        tasks=[*first, *tasks],
        facts=facts,
        world=world_name or "",
        options=options,
        faults=asked.faults,
    )
    return _prepared(library, world, given)


def _prepared(library: Program, world: World, given: Given) -> PreparedRun:
    """Prepare a run; what cannot be run ends the command."""
    try:
        return prepare(library, world, given)
    except RefusedError as refused:
        others = registry.having(refused.lacking) if refused.lacking else ()
        meant = [f"the world `{name}` has them all" for name in others]
        fail(*refused.reasons, *meant)
    except FactError as error:
        fail(f"--fact: {error}")


def _by_owner(
    world: type[World], values: Sequence[str]
) -> tuple[dict[str, str], dict[str, str]]:
    """Return the settings of the interpreter, and the options of the world, as texts.

    A value of neither ends the command.
    """
    own: dict[str, str] = {}
    theirs: dict[str, str] = {}
    for given in values:
        owner, name, value = registry.split_setting(given)
        if owner not in ("rapc", world.name):
            fail(f"--set: `{owner}` is neither `rapc` nor `{world.name}`")
        (own if owner == "rapc" else theirs)[name] = value
    return own, theirs


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
