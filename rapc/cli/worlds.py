"""`rapc worlds [NAME]`: list worlds, describe one, or test its contract."""

from __future__ import annotations

import shutil

import click

from rapc.base.pictures import plain
from rapc.base.values import format_list
from rapc.base.visible import visible_lines
from rapc.cli.common import load_checked, write_picture
from rapc.cli.options import WholeNumber, command, fail
from rapc.console.worlds import describe_world, list_worlds, report, summary_of
from rapc.errors import WorldError
from rapc.ir.layout import laid_out
from rapc.runtime.held_world import HeldWorld
from rapc.testing.contract.declarations import declarations
from rapc.testing.contract.trials import REQUESTS, try_world
from rapc.world import Drawable, World
from rapc.worlds import registry
from rapc.worlds.skills.world import SkillWorld

EXAMPLES = """\b
Examples:
  rapc worlds
  rapc worlds truck
  rapc worlds my_package.world:MyWorld
  rapc worlds truck --declare > truck-words.rap
  rapc worlds hallway --picture hallway.svg
  rapc worlds lamps --test lamps.rap
  rapc worlds 'exec:node lamps.js' --test lamps.rap
  rapc worlds lamps --test lamps.rap --requests 5000
"""

_MOST_REQUESTS = 1_000_000
_NARROWEST = 20
_WIDEST = 100


@command(EXAMPLES)
@click.argument("name", required=False)
@click.option(
    "--declare",
    is_flag=True,
    help="Print the offer of the world as declarations.",
)
@click.option(
    "--test",
    "library",
    is_flag=False,
    flag_value="",
    metavar="[LIBRARY]",
    help="Test the world; with LIBRARY, also test its handlers.",
)
@click.option(
    "--picture",
    metavar="FILE.svg",
    help="Write a picture of the world before any run to FILE.",
)
@click.option(
    "--requests",
    type=WholeNumber(_MOST_REQUESTS),
    metavar="N",
    help=f"Requests with each seed (with --test) [default: {REQUESTS}].",
)
def worlds(
    name: str | None,
    declare: bool,
    library: str | None,
    picture: str | None,
    requests: int | None,
) -> None:
    """List the installed worlds, or describe the world NAME.

    NAME is the name of an installed world, `module:Class`, or the address of a world in
    another process: `exec:COMMAND`, `unix:/path`, `tcp:127.0.0.1:PORT`.

    Exit status: 0; 1 if a check of --test failed; 2 if the world cannot be loaded.
    """
    width = max(_NARROWEST, min(shutil.get_terminal_size().columns, _WIDEST))
    if name is None and library:
        name, library = library, ""
    if name is None and (declare or library is not None or picture is not None):
        raise click.UsageError("missing NAME of a world")
    if declare and library is not None:
        raise click.UsageError("cannot combine --declare and --test")
    if requests is not None and library is None:
        raise click.UsageError("--requests requires --test")
    if name is None:
        listed = {installed: _summary(installed) for installed in registry.available()}
        click.echo(visible_lines(list_worlds(listed, width)))
        return
    found = registry.find_world(name)
    world = registry.build_world(found, 0, {})
    if picture is not None:
        _draw(world, picture)
    elif declare:
        skills = world.runtime.catalogue if isinstance(world, SkillWorld) else None
        words = declarations(world.kit.offer, skills)
        click.echo("\n".join(map(laid_out, words)))
    elif library is not None:
        raise SystemExit(_test(found, library, requests or REQUESTS, width))
    else:
        click.echo(visible_lines(describe_world(world, width)))


def _draw(world: World, file: str) -> None:
    """Write the picture of a new world."""
    from rapc.view.scene import Beliefs, scene_of
    from rapc.view.svg import svg

    held = HeldWorld(world)
    if not isinstance(held, Drawable):
        fail(f"cannot draw world `{world.name}`: it has no `picture` method")
    facts = {format_list(fact): held.now() for fact in held.facts()}
    scene = scene_of(plain(held.picture()), Beliefs(facts, held.now(), compared=False))
    assert scene is not None
    write_picture(file, svg(scene, world.name))


def _test(found: type[World], library: str, requests: int, width: int) -> int:
    """Test a world against the port, print the report, return the exit status."""
    program = load_checked(library) if library else None

    def made(seed: int) -> World:
        return registry.build_world(found, seed, {})

    trials = try_world(made, program, count=requests)
    click.echo(visible_lines(report(found.name, trials, requests, width)))
    return int(any(trial.faults for trial in trials))


def _summary(name: str) -> str:
    """Return the summary of an installed world, or why it is unavailable."""
    try:
        return summary_of(registry.find_world(name))
    except WorldError as error:
        return error.message
