"""Options that describe a run, shared by `run`, `repl` and `graph`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, TypeVar

import click

from rapc.base.values import Atom, number
from rapc.cli.options import WholeNumber, fail
from rapc.compiler.program import Program
from rapc.errors import FactError, RefusedError, SettingError, TextError
from rapc.library.library import Library
from rapc.library.signatures import Signatures
from rapc.parser.parse import parse_fact
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.planner import Planner
from rapc.runtime.settings import read_settings
from rapc.runtime.task_request import read_task_request
from rapc.spec import RunSpec
from rapc.world import Time, World
from rapc.worlds import registry
from rapc.worlds.registry import find_world

F = TypeVar("F", bound=Callable[..., Any])
T = TypeVar("T")
R = TypeVar("R")
Build = Callable[[type[World], int, Mapping[str, Atom | bool]], World]

fault_option = click.option(
    "--fault",
    "faults",
    multiple=True,
    metavar="'(REQUEST) RESULT [p=..] [from=..] [until=..]'",
    help="Make matching requests fail (repeatable).",
)
"""The option for the faults of a run."""


def run_options(command: F) -> F:
    """Add the options that describe the start of a run."""
    options = (
        click.option(
            "--task",
            "tasks",
            multiple=True,
            metavar="'(RAP ARGS) [OPTIONS]'",
            help="Run this task (repeatable).",
        ),
        click.option(
            "--agenda",
            metavar="NAME",
            help="Run the tasks of this agenda before those of --task.",
        ),
        click.option(
            "--seed",
            type=int,
            default=0,
            show_default=True,
            help="Seed of the random streams.",
        ),
        click.option(
            "--fact",
            "facts",
            multiple=True,
            metavar="'(FACT)'",
            help="Initial fact in memory (repeatable).",
        ),
        click.option(
            "--set",
            "values",
            multiple=True,
            metavar="OWNER.NAME=VALUE",
            help="Set an option of the world or a `rapc` setting (repeatable).",
        ),
        fault_option,
    )
    for option in reversed(options):
        command = option(command)
    return command


until_option = click.option(
    "--until", type=float, metavar="TIME", help="Stop the run at TIME."
)
"""The option for the time limit of a run."""


_MOST_PROCESSES = 1000

processes_option = click.option(
    "--jobs",
    "processes",
    type=WholeNumber(_MOST_PROCESSES),
    metavar="N",
    help="Number of processes [default: number of cores].",
)
"""The option for the number of processes of many runs."""


def end_time(until: float | None) -> Time | None:
    """Return the value of `--until` as a time; an error ends the command."""
    if until is None:
        return None
    try:
        end = number(until)
    except ValueError:
        fail("--until must be finite")
    return end if end >= 0 else fail("--until must not be negative")


def read_spec(  # the options of `run_options`, and of `run`
    world_name: str | None,
    *,
    tasks: Sequence[str] = (),
    agenda: str | None = None,
    seed: int = 0,
    facts: Sequence[str] = (),
    values: Sequence[str] = (),
    faults: Sequence[str] = (),
    until: Time | None = None,
) -> RunSpec:
    """Return the spec from the options of `run_options`; an error ends the command.

    Args:
        world_name: the name of a world, or `module:Class`; None for a world that offers
            the declarations of the library and answers no request.
        tasks: the values of `--task`.
        agenda: the name of the agenda.
        seed: the seed.
        facts: the initial facts.
        values: `owner.name=value`.
        faults: the faults of the world.
        until: the time at which the run is stopped.
    """
    readers: tuple[tuple[str, Sequence[str], Callable[[str], object]], ...] = (
        ("--task", tasks, read_task_request),
        ("--fact", facts, parse_fact),
    )
    for option, texts, read in readers:
        for text in texts:
            read_option(option, read, text)
    if faults:
        from rapc.testing.faults import read_fault

        for text in faults:
            read_option("--fault", read_fault, text)
    world = _world_class(world_name)
    named = dict(read_option("--set", registry.split_setting, text) for text in values)
    if world_name is None and any(not key.startswith("rapc.") for key in named):
        fail("--set: options of a world require --world")
    options, own = read_option("--set", partial(registry.read_values, world), named)
    settings = read_option("--set", read_settings, own)
    return RunSpec(
        world=world.name,
        world_class=world_name if world_name and ":" in world_name else "",
        options=options,
        settings=settings.named(own),
        seed=seed,
        agenda=agenda,
        tasks=tuple(tasks),
        facts=tuple(facts),
        faults=tuple(faults),
        until=until,
    )


def _world_class(name: str | None) -> type[World]:
    if name is not None:
        return find_world(name)
    from rapc.worlds.scripted import ScriptedWorld

    return ScriptedWorld


def prepared(
    library: Program,
    spec: RunSpec,
    world_name: str | None = None,
    enclose: Callable[[World], World] = lambda world: world,
    build: Build = registry.build_world,
    planner: Planner | None = None,
) -> Interpreter:
    """Return a run of a library that can start; else end the command.

    Args:
        library: the library.
        spec: the description of the run.
        world_name: the name of the world of the spec, as for `read_spec`.
        enclose: returns the world in a wrapper, if necessary.
        build: makes the world.
        planner: finds methods for RAPs with `(plan)`; None for that of rapc.
    """
    world: World
    if world_name is None:
        from rapc.worlds.scripted import ScriptedWorld

        world = ScriptedWorld([], declared=library.library)
    else:
        found = find_world(world_name)
        options = registry.check_options(found, spec.options)
        world = build(found, spec.seed, options)
    from rapc.host import find_plan

    world = enclose(_with_faults(world, library.library, spec))
    try:
        planner = find_plan if planner is None else planner
        return Interpreter.prepared(library, world, spec, planner=planner)
    except RefusedError as refused:
        fail(*refused.reasons, *registry.meant(refused))
    except FactError as error:
        fail(f"--fact: {error}")


def read_option(name: str, read: Callable[[T], R], given: T) -> R:
    """Return the result of `read` for an option; an error ends the command."""
    try:
        return read(given)
    except (TextError, SettingError, FactError) as error:
        fail(f"{name}: {error}")


def _with_faults(world: World, library: Library, spec: RunSpec) -> World:
    """Return a world with the faults of a spec; an invalid fault ends the command."""
    if not spec.faults:
        return world
    from rapc.testing.faults import read_fault, told_for_skills
    from rapc.worlds.faults import FaultyWorld, problem

    faults = [read_fault(text) for text in spec.faults]
    offered = Signatures.offered(world.kit.offer)
    told = told_for_skills(library)
    for fault in faults:
        wrong = problem(fault, offered, told)
        if wrong is not None:
            fail(f"--fault: {wrong}")
    return FaultyWorld(world, faults, spec.seed)
