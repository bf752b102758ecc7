"""The options of all commands, and the exit after an invalid command.

Separate from `rapc.cli.common`, so that `rapc --help` imports only these options.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Mapping
from typing import (
    Annotated,
    Any,
    NoReturn,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
)

import click

from rapc.base.visible import visible

C = TypeVar("C", bound=click.Command)
F = TypeVar("F", bound=Callable[..., Any])

USAGE = 2
"""The exit status for an invalid command or input."""


class WholeNumber(click.IntRange):
    """An integer from 1 to `most`."""

    name = "whole number"

    def __init__(self, most: int) -> None:
        super().__init__(1, most)


class Amount(click.FloatRange):
    """A finite number within bounds."""

    name = "number"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> Any:
        """Return the number in a text; infinite numbers are refused."""
        given = super().convert(value, param, ctx)
        if not math.isfinite(given):
            self.fail(f"{value!r} is not a finite number", param, ctx)
        return given


class TypedPath(click.Path):
    """A path as typed; the command itself reports a path that it cannot use."""

    def convert(
        self,
        value: Any,
        param: click.Parameter | None,
        ctx: click.Context | None,
    ) -> Any:
        """Return the path."""
        return value


class CliSettings:
    """The values of the options of all commands; stored in click's root context."""

    color: str = "auto"
    quiet: bool = False
    verbose: bool = False

    def colored(self) -> bool:
        """Return whether to colour standard output."""
        if self.color != "auto":
            return self.color == "always"
        plain = os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb"
        return sys.stdout.isatty() and not plain


def settings() -> CliSettings:
    """Return the settings of the present command."""
    return click.get_current_context().find_root().ensure_object(CliSettings)


HELP: Mapping[str, Any] = {"help_option_names": ["-h", "--help"]}
"""The click settings of all commands."""


def command(examples: str) -> Callable[[Callable[..., None]], click.Command]:
    """Return a decorator that makes a command with the options of all commands.

    `examples` are printed below its help.
    """

    def made(does: Callable[..., None]) -> click.Command:
        make = click.command(epilog=examples, context_settings={**HELP})
        return with_common_options(make(does))

    return made


class Opt(dict[str, Any]):
    """The arguments of `click.option` for an option, without its name and type."""


def options_of(table: type) -> Callable[[F], F]:
    """Return a decorator that adds an option for each field with an `Opt`.

    A field of type `bool` becomes a flag, a tuple an option that may be repeated.
    """

    def add(does: F) -> F:
        hints = get_type_hints(table, include_extras=True)
        for name, hint in reversed(hints.items()):
            if get_origin(hint) is Annotated:
                kind, more = get_args(hint)
                flag, multiple = kind is bool, get_origin(kind) is tuple
                option = "--" + name.replace("_", "-")
                does = click.option(option, is_flag=flag, multiple=multiple, **more)(
                    does
                )
        return does

    return add


def with_common_options(command: C) -> C:
    """Return a command or group with `--color`, `-v` and `-q` after its options."""
    command.params += _common()
    return command


def _common() -> list[click.Parameter]:
    """Return the options `--color`, `-v` and `-q`."""
    colors = click.Choice(["auto", "always", "never"])
    told = "When to use colour; NO_COLOR is respected."
    loud = "Print progress on standard error."
    quiet = "Print only findings and results."
    kept: dict[str, Any] = {"expose_value": False, "callback": _keep}
    return [
        click.Option(["--color"], type=colors, help=told, **kept),
        click.Option(["-v", "--verbose"], is_flag=True, help=loud, **kept),
        click.Option(["-q", "--quiet"], is_flag=True, help=quiet, **kept),
    ]


def _keep(context: click.Context, option: click.Parameter, value: object) -> None:
    kept = context.find_root().ensure_object(CliSettings)
    if value and option.name is not None:
        setattr(kept, option.name, value)


def fail(message: str, *more: str | None) -> NoReturn:
    """End the command with status 2 and an error on standard error.

    Args:
        message: the error, one line.
        more: further lines, if any: more errors, or help.
    """
    say_error(message, *more)
    raise SystemExit(USAGE)


def say_error(message: str, *more: str | None) -> None:
    """Print an error on standard error; see `fail`."""
    click.echo(_to_width(f"error: {visible(message)}"), err=True)
    for line in more:
        if line:
            click.echo(_to_width(f"  {visible(line)}"), err=True)


def _to_width(line: str) -> str:
    """Return a line wrapped between words if standard error is a terminal."""
    if not sys.stderr.isatty():
        return line
    import shutil
    import textwrap

    return textwrap.fill(
        line,
        max(shutil.get_terminal_size().columns, 20),
        subsequent_indent="    ",
        break_long_words=False,
        break_on_hyphens=False,
    )


def show_traceback(error: Exception) -> None:
    """Print the traceback of an error if `RAPC_DEBUG=1` is set."""
    if os.environ.get("RAPC_DEBUG") == "1":
        import traceback

        traceback.print_exception(error)


def say(message: str) -> None:
    """Print progress on standard error, on one line, if `-v` is set."""
    if settings().verbose:
        click.echo(visible(message), err=True)
