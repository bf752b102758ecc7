"""What the commands share that work on libraries: reading, and printing findings.

Compiling is in `rapc.cli.checked`, for those that need it. What prints findings is
imported when there are some: `rapc check` of a sound library has no use for it.

Exit statuses of all commands: 0 for well, 1 for found or failed, 2 for what could not
be tried. Findings and results go to standard output, everything else to standard error.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Iterable

import click

from rapc.analysis.driver import CheckReport
from rapc.cli.options import USAGE, common_options, fail, say, settings
from rapc.errors import LoadError
from rapc.library.loader import Loaded, load

__all__ = (
    "USAGE",
    "common_options",
    "fail",
    "print_findings",
    "read_paths",
    "same_file",
    "say",
    "settings",
)

PIPED_WIDTH = 120
"""How wide output is that goes to no terminal."""


def read_paths(paths: Iterable[str]) -> Loaded:
    """Load files and folders; what cannot be read ends the command with status 2."""
    try:
        loaded = load(paths)
    except LoadError as error:
        fail(str(error))
    for name in loaded.files:
        say(f"read {name}")
    return loaded


def same_file(one: str, other: str) -> bool:
    """Whether two names are those of one file; one that cannot be seen is none."""
    try:
        return os.path.samefile(one, other)
    except (OSError, ValueError):
        return False


def print_findings(report: CheckReport, output_format: str) -> None:
    """Print a report's findings on standard output: `full`, `concise` or `json`."""
    if not report.findings and output_format != "json":
        return
    from rapc.console import findings as render  # noqa: PLC0415  # brings rich along

    if output_format == "json":
        click.echo(render.json_text(report))
    elif output_format == "concise":
        for line in render.concise(report):
            click.echo(line)
    else:
        width = PIPED_WIDTH
        if sys.stdout.isatty():
            width = shutil.get_terminal_size().columns
        lines = render.full(report, width)
        render.write(lines, sys.stdout, color=settings().colored())
