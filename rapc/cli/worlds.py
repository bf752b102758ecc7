"""`rapc worlds [NAME]`: the worlds installed, or what one of them offers."""

from __future__ import annotations

import shutil

import click

EXAMPLES = """\b
Examples:
  rapc worlds
  rapc worlds truck
  rapc worlds my_package.world:MyWorld
"""


@click.command(
    epilog=EXAMPLES, context_settings={"help_option_names": ["-h", "--help"]}
)
@click.argument("name", required=False)
def worlds(name: str | None) -> None:
    """List the worlds installed, or say what the world NAME offers."""
    from rapc.worlds import describe, registry

    width = min(shutil.get_terminal_size().columns, 100)
    try:
        if name is not None:
            world = registry.build_world(registry.find_world(name), 0, {})
            click.echo(describe.describe_world(world, width))
            return
        found = {n: registry.find_world(n) for n in registry.available()}
    except registry.WorldError as error:
        raise click.UsageError(
            error.message + (f": {error.help}" if error.help else "")
        ) from error
    summaries = {n: describe.summary(world) for n, world in found.items()}
    click.echo(describe.list_worlds(summaries, width))
