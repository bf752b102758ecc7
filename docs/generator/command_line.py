"""The reference of the command line."""

from __future__ import annotations

import inspect

import click

from generator.markdown import block, table
from rapc.cli.main import COMMANDS, cli
from rapc.cli.options import HELP


def _context(name: str) -> click.Context:
    top = click.Context(cli, info_name="rapc")
    if name == "rapc":
        return top
    found = cli.get_command(top, name)
    assert found is not None, name
    return click.Context(found, info_name=name, parent=top, **HELP)


def _options(name: str) -> dict[str, str]:
    """Return the options of a command with their help."""
    context = _context(name)
    options = [
        option
        for option in context.command.get_params(context)
        if isinstance(option, click.Option)
    ]
    records = [option.get_help_record(context) for option in options]
    return {f"`{record[0]}`": record[1] for record in records if record}


def common_options() -> str:
    """Return the table of the options that all commands have."""
    shared = [_options(name) for name in COMMANDS]
    return table(
        ("option", "meaning"),
        [row for row in shared[0].items() if all(row in one.items() for one in shared)],
    )


def command(name: str) -> str:
    """Return usage, help, options and examples of a command."""
    context = _context(name)
    help_ = inspect.cleandoc(context.command.help or "").replace("\b\n", "")
    epilog = (context.command.epilog or "").replace("\b", "").replace("Examples:", "")
    examples = inspect.cleandoc(epilog)
    common = {
        row
        for row in _options(name).items()
        if all(row in _options(other).items() for other in COMMANDS)
    }
    rows = [row for row in _options(name).items() if row not in common]
    usage = " ".join(context.get_usage().removeprefix("Usage:").split())
    parts = [
        block("text", usage),
        "\n".join(line.strip() for line in help_.splitlines()) + "\n",
        table(("option", "meaning"), rows) if rows else "",
        block("sh", examples) if examples else "",
    ]
    return "\n".join(filter(None, parts))
