"""`rapc graph PATH`: what a library looks like, for programs that draw."""

from __future__ import annotations

import click

from rapc.analysis import graphs
from rapc.analysis.driver import CheckReport, check_library
from rapc.analysis.graphs import Graph
from rapc.base.diagnostics import Severity
from rapc.base.names import nearest
from rapc.cli.common import (
    USAGE,
    common_options,
    fail,
    print_findings,
    read_paths,
)
from rapc.library.library import Library

EXAMPLES = """\b
Examples:
  rapc graph my-library/ | dot -Tsvg > calls.svg
  rapc graph my-library/ --rap deliver --format mermaid
  rapc graph my-library/ --monitors --format json
"""


@click.command(
    epilog=EXAMPLES, context_settings={"help_option_names": ["-h", "--help"]}
)
@click.argument("path", metavar="PATH")
@click.option("--rap", metavar="RAP", help="The task-nets of a RAP instead.")
@click.option("--monitors", is_flag=True, help="Monitors, and what wakes them.")
@click.option("--claims", is_flag=True, help="What is claimed and used, and by whom.")
@click.option(
    "--format",
    "output_format",
    type=click.Choice(["dot", "mermaid", "json"]),
    default="dot",
    show_default=True,
    help="For Graphviz, for Mermaid, or for programs.",
)
@common_options
def graph(
    path: str, rap: str | None, monitors: bool, claims: bool, output_format: str
) -> None:
    """Print a graph of a library: which RAP asks for which RAPs and primitives.

    Exit status: 0; 2 for a library with errors, and for what cannot be read.
    """
    if (rap is not None) + monitors + claims > 1:
        fail("--rap, --monitors and --claims exclude each other")
    library = _library(path)
    if rap is not None:
        drawn = _task_nets(library, rap)
    elif monitors:
        drawn = graphs.monitors(library)
    elif claims:
        drawn = graphs.things(library)
    else:
        drawn = graphs.calls(library)
    from rapc.console.graphs import WRITERS  # noqa: PLC0415  # when all is well

    click.echo(WRITERS[output_format](drawn), nl=False)


def _library(path: str) -> Library:
    """Return the library at a path; errors in it end the command."""
    report = check_library(read_paths([path]))
    errors = tuple(f for f in report.findings if f.severity is Severity.ERROR)
    if errors:
        print_findings(CheckReport(errors, report.library), "full", err=True)
        raise SystemExit(USAGE)
    return report.library


def _task_nets(library: Library, name: str) -> Graph:
    rap = library.raps.get(name.lower())
    if rap is None:
        near = nearest(name.lower(), library.raps)
        fail(f"no RAP is called `{name}`", f"did you mean `{near}`?" if near else None)
    return graphs.task_nets(rap)
