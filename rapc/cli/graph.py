"""`rapc graph PATH`: print graphs of a library, for drawing programs."""

from __future__ import annotations

import inspect
from typing import Any

import click

from rapc.analysis import graphs
from rapc.analysis.driver import check_library
from rapc.analysis.graphs import library_graph
from rapc.analysis.selection import errors
from rapc.base.graph import Graph
from rapc.base.names import did_you_mean
from rapc.base.values import number, readable
from rapc.cli.common import load_checked, print_findings, read_paths
from rapc.cli.options import USAGE, Amount, TypedPath, command, fail
from rapc.cli.run_options import prepared, read_spec, run_options
from rapc.compiler.program import Program
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.spec import RunSpec
from rapc.worlds.skills.world import SkillWorld

EXAMPLES = """\b
Examples:
  rapc graph my-library/ | dot -Tsvg > calls.svg
  rapc graph my-library/ --rap deliver --format mermaid
  rapc graph my-library/ --effects deliver --format text
  rapc graph my-library/ --monitors --format json
  rapc graph my-library/ --operators --format mermaid
  rapc graph my-library/ --dependents battery --format text
  rapc graph my-library/ --all --format graphml > library.graphml
  rapc graph my-library/ --skills 20 --world my_robot:World --task '(tour)'
"""


@command(EXAMPLES)
@click.argument("path", metavar="PATH", type=TypedPath())
@click.option("--rap", metavar="RAP", help="Show the task-nets of RAP.")
@click.option("--effects", metavar="RAP", help="Show all possible effects of RAP.")
@click.option(
    "--monitors",
    is_flag=True,
    help="Show monitors and the facts and events that wake them.",
)
@click.option(
    "--claims", is_flag=True, help="Show things with the RAPs that claim or use them."
)
@click.option(
    "--operators", is_flag=True, help="Show the facts that operators need and change."
)
@click.option(
    "--all", "everything", is_flag=True, help="Show all names and their relations."
)
@click.option(
    "--recursive", is_flag=True, help="Show RAPs that call each other in a cycle."
)
@click.option(
    "--dominators",
    metavar="RAP",
    help="Show the definitions on every path from RAP to others.",
)
@click.option(
    "--dependents", metavar="NAME", help="Show all definitions that depend on NAME."
)
@click.option(
    "--format",
    "output_format",
    type=click.Choice(["dot", "mermaid", "json", "text", "graphml"]),
    default="dot",
    show_default=True,
    help="Format of the graph.",
)
@click.option(
    "--skills",
    "moment",
    type=Amount(min=0),
    metavar="TIME",
    help="Show the active skills of a run in --world at TIME.",
)
@click.option("--world", "world_name", metavar="WORLD", help="World for --skills.")
@run_options
def graph(  # noqa: PLR0912  # a branch for each view
    path: str,
    rap: str | None,
    effects: str | None,
    monitors: bool,
    claims: bool,
    operators: bool,
    everything: bool,
    recursive: bool,
    dominators: str | None,
    dependents: str | None,
    output_format: str,
    moment: float | None,
    world_name: str | None,
    **more: Any,
) -> None:
    """Print a graph of a library: the RAPs and primitives that each RAP calls.

    Exit status: 0; 2 for a library that has errors or cannot be read.
    """
    from rapc.console import graphs as writers

    views = (rap, effects, dominators, dependents, moment)
    flags = (monitors, claims, operators, everything, recursive)
    if sum(view is not None for view in views) + sum(flags) > 1:
        fail("cannot combine options that select a graph")
    if moment is not None and world_name is not None:
        spec = read_spec(world_name, **more)
        drawn, style = _network(path, world_name, moment, spec), writers.NETWORK
    elif moment is not None or world_name is not None or any(more.values()):
        fail("--skills requires --world; options of a run require --skills")
    else:
        library, style = _library(path), writers.LIBRARY
        if rap is not None:
            drawn = graphs.task_nets(_named(library, rap))
        elif effects is not None:
            from rapc.analysis.effects_graph import effects_of

            drawn = effects_of(library, _named(library, effects).name)
        elif monitors:
            drawn = graphs.monitors(library)
        elif claims:
            drawn = graphs.things(library)
        elif operators:
            from rapc.planning.graph import operators as operators_of

            drawn = operators_of(Program(library, path))
        elif everything:
            drawn = graphs.everything(library)
        elif recursive:
            drawn = graphs.recursive(library)
        elif dominators is not None:
            drawn = graphs.dominators(library, _named(library, dominators).name)
        elif dependents is not None:
            drawn = _dependents(library, dependents)
        else:
            drawn = graphs.calls(library)
    click.echo(writers.WRITERS[output_format](drawn, style), nl=False)


def _network(path: str, world_name: str, moment: float, spec: RunSpec) -> Graph:
    """Return the network of skills at a time of a run; else end the command."""
    run = prepared(load_checked(path), spec, world_name)
    world = inspect.unwrap(run.world)  # type: ignore[arg-type]  # an object, too
    if not isinstance(world, SkillWorld):
        fail(f"the world `{world.name}` has no network of skills")
    found: list[Graph] = []
    time = number(moment)
    run.start()
    run.call_at(time, lambda: found.append(world.network()))
    reason = run.run(until=time)
    if not found:
        fail(f"the run ended at time {readable(run.now)} ({reason})")
    return found[0]


def _library(path: str) -> Library:
    """Return the library at a path; errors in it end the command."""
    loaded = read_paths([path])
    report = check_library(loaded, errors())
    if report.findings:
        print_findings(report, "full", err=True)
        raise SystemExit(USAGE)
    return loaded.library


def _dependents(library: Library, name: str) -> Graph:
    try:
        return graphs.dependents(library, name)
    except KeyError:
        names = [data["name"] for _, data in library_graph(library).nodes(data=True)]
        fail(f"unknown name `{name}`", did_you_mean(name, names))


def _named(library: Library, name: str) -> nodes.DefineRap:
    rap = library.raps.get(name.lower())
    if rap is None:
        meant = did_you_mean(name.lower(), library.raps)
        fail(f"unknown RAP `{name}`", meant)
    return rap
