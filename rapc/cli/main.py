"""The `rapc` command: its sub-commands, imported at first use, and its errors.

The user never sees a traceback: a usage error is one line with status 2, and so is a
fault in rapc itself, unless `RAPC_DEBUG=1` is set.
"""

from __future__ import annotations

import errno
import io
import os
import re
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TextIO

import click

from rapc.base.code_places import frames, said_by
from rapc.base.gc_paused import gc_spared
from rapc.base.interrupts import INTERRUPTED
from rapc.base.names import hint
from rapc.base.visible import visible
from rapc.cli.options import HELP, USAGE, show_traceback, with_common_options
from rapc.errors import Error, RefusedError, reason

COMMANDS = {
    "new": "Create a project with a world, a library and a test.",
    "check": "Check RAP libraries.",
    "fmt": "Format RAP files.",
    "compile": "Compile a RAP library to one file.",
    "rule": "Explain a rule of the checker.",
    "run": "Run tasks of a library against a world.",
    "repl": "Debug a run interactively.",
    "journal": "Describe, verify, cut and convert journals of runs.",
    "view": "Write a page that shows a run.",
    "plan": "Find a plan for a goal.",
    "bug": "Write a run to one file, to be repeated elsewhere.",
    "compare": "Compare two runs, or two libraries over seeds.",
    "experiment": "Run a batch of seeded runs and summarise the results.",
    "test": "Run the tests of RAP libraries.",
    "graph": "Print a graph of a library.",
    "worlds": "List worlds or describe one.",
    "lsp": "Serve an editor (Language Server Protocol).",
}
"""The commands with their line in the help; `rapc.cli.NAME` defines each."""

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
"""The errors of the system for output that cannot be written."""

EXAMPLES = """\b
Examples:
  rapc check my-library/
  rapc run my-library/ --world truck --task '(deliver rock-1 factory-1)'
  rapc rule unbound-variable

\b
The manual is in the folder docs:
  tutorials/first-robot   to begin
  how-to/index            guides by task
  reference/cli           all commands and options
"""


class Commands(click.Group):
    """A group that imports a command only when it is used."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Return a command by its name, imported."""
        if name not in COMMANDS:
            return None
        module = f"rapc.cli.{name}"
        if module not in sys.modules:
            with gc_spared():
                import_module(module)
        command = getattr(sys.modules[module], name)
        assert isinstance(command, click.Command)
        return command

    def format_commands(
        self, ctx: click.Context, formatter: click.HelpFormatter
    ) -> None:
        """Write the list of commands without importing any of them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@with_common_options
@click.group(cls=Commands, epilog=EXAMPLES, context_settings={**HELP})
@click.version_option(package_name="rapc", message="rapc %(version)s")
def cli() -> None:
    """Check, run, test and debug Reactive Action Packages (RAPs)."""


def main(args: Sequence[str] | None = None) -> None:
    """Run the command line; ends the process with the command's exit status."""
    _escape_unprintable()
    try:
        status = cli.main(
            None if args is None else list(args),
            prog_name="rapc",
            standalone_mode=False,
        )
        sys.stdout.flush()
    except click.exceptions.NoArgsIsHelpError as error:
        _tell(error.format_message())
        sys.exit(USAGE)
    except click.ClickException as error:
        _tell(f"error: {visible(_message(error))}")
        sys.exit(USAGE)
    except (click.Abort, KeyboardInterrupt):
        sys.exit(INTERRUPTED)
    except SystemExit as error:
        _refuse_foreign(error)
        raise
    except Error as error:
        _say(error)
        sys.exit(USAGE)
    except BrokenPipeError:
        _drop(sys.stdout)
        sys.exit(1)
    except OSError as error:
        if error.errno not in _FULL:
            _internal_fault(error)
        else:
            _drop(sys.stdout)
            _tell(f"error: cannot write the output: {reason(error)}")
        sys.exit(USAGE)
    except Exception as error:
        if sys.stdout.closed:
            _tell("error: the world's code closed standard output")
        else:
            _internal_fault(error)
        sys.exit(USAGE)
    sys.exit(status if isinstance(status, int) else 0)


def _refuse_foreign(error: SystemExit) -> None:
    """End with status 2 if foreign code, for example a world, ended the process."""
    *_, (frame, row) = frames(error)
    if str(frame.f_globals.get("__name__")).partition(".")[0] in ("rapc", "click"):
        return
    place = f"{Path(frame.f_code.co_filename).name}:{row}"
    _tell(f"error: {place} ended the process: {said_by(error)}")
    sys.exit(USAGE)


def _escape_unprintable() -> None:
    """Make output escape characters that its encoding cannot represent.

    A stream that the caller has closed is replaced by the null device: otherwise the
    first file that is opened would receive the number of the stream, and its output.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
        elif stream is None:
            nowhere = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # kept
            setattr(sys, name, nowhere)


def _message(error: click.ClickException) -> str:
    """Return a usage error as a line with at most a single suggestion."""
    if isinstance(error, click.exceptions.NoSuchCommand):
        name = error.command_name
        return f"unknown command `{name}`{hint(name, COMMANDS)}"
    if isinstance(error, click.NoSuchOption):
        name = error.option_name
        return f"unknown option `{name}`{hint(name, error.possibilities or ())}"
    text = " ".join(error.format_message().split()).removesuffix(".")
    if found := re.fullmatch(r"Missing (?:argument|option) (.+)", text):
        return f"missing {found[1]}".replace("'", "")
    if found := re.fullmatch(r"Invalid value for '(.+?)': (.+)", text):
        quoted = re.sub(r"'([^']*)'", r"`\1`", found[2])
        return f"{found[1]}: {quoted}".replace("' / '", " / ")
    if found := re.fullmatch(r"Got unexpected extra arguments? \((.+)\)", text):
        return f"unexpected argument `{found[1]}`"
    return text[:1].lower() + text[1:]


def _say(error: Error) -> None:
    """Print a user's error, with its help."""
    show_traceback(error)
    lines = (error.message, error.help)
    first, *more = error.reasons if isinstance(error, RefusedError) else lines
    _tell(f"error: {visible(first)}")
    for line in filter(None, more):
        _tell(f"  {visible(line)}")


def _tell(line: str) -> None:
    """Print a line on standard error; ignore a stream that cannot be written."""
    try:
        click.echo(line, err=True)
    except OSError:
        _drop(sys.stderr)
    except ValueError:  # the stream is closed
        return


def _drop(stream: TextIO) -> None:
    """Redirect a broken stream to the null device, so that its last flush works."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _internal_fault(error: Exception) -> None:
    show_traceback(error)
    what = " ".join(f"{type(error).__name__}: {error}".split())
    _tell(
        f"error: internal error in rapc ({what[:200]}); please report it to its "
        "developers with the command, the input and what RAPC_DEBUG=1 shows"
    )
