"""Shared parts of the commands on libraries: reading, and printing findings.

The compiler and the printers of findings are imported at first use: `rapc check` of a
library without findings needs neither.

Exit statuses of all commands: 0 for success, 1 for findings or failures, 2 for an
invalid command or input. Findings and results go to standard output, other text to
standard error.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from threading import Event as Signal
from typing import TYPE_CHECKING, Any, TextIO

import click

from rapc.analysis.driver import CheckReport
from rapc.base.files import path_of
from rapc.base.interrupts import terminations_as_interrupts
from rapc.base.outputs import SVG, Output, check_output
from rapc.base.visible import visible
from rapc.base.writing import write_whole
from rapc.cli.options import USAGE, fail, say, say_error, settings
from rapc.errors import LoadError, WriteError, reason
from rapc.library.loader import Loaded, load
from rapc.parser.rewriting import write_back

if TYPE_CHECKING:
    from rapc.compiler.program import Program
    from rapc.view.control import Control
    from rapc.view.live import Live

_STYLES: Mapping[str, Mapping[str, Any]] = {
    "passed": {"fg": "green"},
    "failed": {"fg": "red", "bold": True},
    "error": {"fg": "red", "bold": True},
    "title": {"bold": True},
    "head": {"underline": True},
    "mark": {"fg": "red"},
    "trace": {"dim": True},
}
"""The styles of lines on standard output, by kind."""

PIPED_WIDTH = 120
"""The width of output that does not go to a terminal, in columns."""


def width_of(stream: TextIO) -> int:
    """Return the number of columns for text on a stream."""
    if not stream.isatty():
        return PIPED_WIDTH
    import shutil

    return shutil.get_terminal_size().columns


def print_line(kind: str, text: str) -> None:
    """Print a line on standard output in the style of its kind."""
    styled = click.style(visible(text), **_STYLES.get(kind, {}))
    click.echo(styled, color=settings().colored())


def read_paths(paths: Iterable[str]) -> Loaded:
    """Load files and folders, and print progress. Raises LoadError."""
    loaded = load(paths)
    for name in loaded.files:
        say(f"read {name}")
    return loaded


def load_checked(path: str) -> Program:
    """Return a library for a command that runs it, from sources or saved.

    Findings of severity error are printed and end the command with status 2; other
    findings do not end the command.
    """
    from rapc.host import CheckError
    from rapc.host import load as load_program

    try:
        library = load_program(path)
    except CheckError as error:
        print_findings(error.report, "full")
        raise SystemExit(USAGE) from None
    for name in library.files:
        say(f"read {name}")
    return library.program


def refuse_output(
    option: str,
    file: str,
    output: Output,
    *inputs: tuple[Iterable[str | Path | None], str],
) -> None:
    """End the command if an option may not write its file.

    Args:
        option: the option.
        file: the file.
        output: the kind of file that it writes.
        inputs: as for `rapc.base.outputs.check_output`.
    """
    try:
        check_output(file, output, *inputs)
    except WriteError as error:
        fail(f"{option}: {error.message}", error.help)


def refuse_faulty(*reports: CheckReport) -> None:
    """Print the findings of reports; findings end the command with status 2."""
    for report in reports:
        print_findings(report, "full")
    if any(report.findings for report in reports):
        raise SystemExit(USAGE)


def write_output(file: str, data: bytes) -> None:
    """Write the file of an option; a failure ends the command."""
    try:
        write_whole(file, data)
    except WriteError as error:
        fail(error.message)


def write_picture(file: str, picture: str) -> None:
    """Write the SVG picture of `--picture`, and print its file."""
    if not file.lower().endswith(".svg"):
        fail(f"--picture: expected FILE.svg, not `{file}`")
    refuse_output("--picture", file, SVG)
    write_output(file, picture.encode())
    click.echo(f"wrote {visible(file)}")


def serve(
    page: str,
    port: int = 0,
    control: Control | None = None,
    trace: TextIO | None = None,
) -> Live:
    """Serve the page of a run that goes on, and print its address.

    A port that cannot be used ends the command. The arguments are those of `Live`.
    """
    from rapc.view.live import Live

    try:
        live = Live(page, port, control, trace)
    except OSError as error:
        fail(f"cannot serve the page: {reason(error)}")
    click.echo(f"view: {live.address}", err=True)
    return live


def wait_for_readers(live: Live, said: str = "the run has ended") -> None:
    """Print a text, and serve the page of a run that does not go on until Ctrl-C."""
    try:
        with terminations_as_interrupts():
            click.echo(f"{said}; Ctrl-C stops the server", err=True)
            Signal().wait()
    except KeyboardInterrupt:
        live.close()


def rewrite(name: str, read: str, text: str) -> bool:
    """Replace the text of a RAP file; if that fails, print the reason.

    Args:
        name: the name of the file.
        read: the text when it was read; a file that has changed meanwhile is not
            written.
        text: its new text.

    Returns:
        Whether the file was written.
    """
    try:
        write_back(path_of(name), read, text)
    except (LoadError, WriteError) as error:
        say_error(error.message)
        return False
    return True


FORMATS = (
    *("full", "concise", "grouped", "json", "json-lines", "sarif", "github", "junit"),
)
"""The formats of findings."""

FOR_PEOPLE = ("full", "concise", "grouped")
"""The formats that are followed by a summary."""

STATISTICS = ("full", "json")
"""The formats of statistics."""


def print_findings(
    report: CheckReport,
    output_format: str,
    statistics: bool = False,
    *,
    err: bool = False,
) -> None:
    """Print a report's findings on standard output, or on standard error.

    Args:
        report: the report.
        output_format: one of `FORMATS`.
        statistics: whether to print counts by rule instead.
        err: whether to print on standard error.
    """
    if not report.findings and output_format in (*FOR_PEOPLE, "github", "json-lines"):
        return
    from rapc.console import findings

    stream = sys.stderr if err else sys.stdout
    if output_format == "full" and not statistics:
        lines = findings.full(report, width_of(stream))
        findings.write_lines(lines, stream, color=settings().colored())
        return
    click.echo(findings_text(report, output_format, statistics), nl=False, err=err)


def findings_text(report: CheckReport, output_format: str, statistics: bool) -> str:
    """Return a report's findings as plain text; see `print_findings`."""
    from rapc.console import findings, formats

    if statistics:
        return formats.statistics(report, output_format)
    if output_format == "full":
        lines = [line.plain for line in findings.full(report, PIPED_WIDTH)]
        return "".join(f"{line}\n" for line in lines)
    return formats.WRITERS[output_format](report)


def diff(name: str, before: str, after: str) -> str:
    """Return the difference of two texts as a unified diff."""
    import difflib

    old, new = (text.splitlines(keepends=True) for text in (before, after))
    shown = visible(name)
    return "".join(
        line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n"
        for line in difflib.unified_diff(old, new, shown, shown)
    )
