"""`rapc worlds [NAME]`: the worlds installed, or what one of them offers."""

from __future__ import annotations

import shutil

import click

from rapc.base.visible import visible_lines
from rapc.cli.common import common_options, fail
from rapc.console.worlds import describe_world, list_worlds, summary
from rapc.errors import WorldError
from rapc.worlds import registry

EXAMPLES = """\b
Examples:
  rapc worlds
  rapc worlds truck
  rapc worlds my_package.world:MyWorld
"""

_NARROWEST = 20
_WIDEST = 100


@click.command(
    epilog=EXAMPLES, context_settings={"help_option_names": ["-h", "--help"]}
)
@click.argument("name", required=False)
@common_options
def worlds(name: str | None) -> None:
    """List the worlds installed, or say what the world NAME offers.

    NAME is the name of an installed world, or `module:Class`.
    """
    width = max(_NARROWEST, min(shutil.get_terminal_size().columns, _WIDEST))
    if name is None:
        found = {installed: _summary(installed) for installed in registry.available()}
        click.echo(visible_lines(list_worlds(found, width)))
        return
    try:
        world = registry.build_world(registry.find_world(name), 0, {})
    except WorldError as error:
        fail(error.message, error.help)
    click.echo(visible_lines(describe_world(world, width)))


def _summary(name: str) -> str:
    """What an installed world is, or why it cannot be had."""
    try:
        return summary(registry.find_world(name))
    except WorldError as error:
        return error.message
