"""`rapc compile`: write a library to one file, and explain its queries."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import click

from rapc.analysis.driver import CheckReport
from rapc.base.files import read_compiled
from rapc.base.gc_paused import gc_paused
from rapc.base.outputs import COMPILED_LIBRARY
from rapc.cli.common import (
    load_checked,
    refuse_faulty,
    refuse_output,
    write_output,
)
from rapc.cli.options import TypedPath, command, fail, say
from rapc.compiler.explain import describe, explain
from rapc.compiler.program import Program
from rapc.errors import SavedError
from rapc.library.saved import Suite, encode
from rapc.testing import discover

EXAMPLES = """\b
Examples:
  rapc compile my-library/ -o my-library.rapc
  rapc run my-library.rapc --world truck --task '(patrol)'
  rapc compile rocks.rap --explain rock-order
"""


@command(EXAMPLES)
@click.argument("path", type=TypedPath())
@click.option(
    "-o", "--output", metavar="FILE", help="Write the compiled library to FILE."
)
@click.option(
    "--explain",
    "explained",
    multiple=True,
    metavar="RAP",
    help="Explain how the clauses of a RAP are evaluated (repeatable).",
)
def compile(path: str, output: str | None, explained: tuple[str, ...]) -> None:
    """Compile the library at PATH, with its tests, to one file.

    `rapc run` and `rapc test` accept the compiled library in place of the sources, and
    read the compiled library many times faster.

    Exit status: 0 if the file was written, 2 if not.
    """
    if output is None and not explained:
        raise click.UsageError("missing -o FILE or --explain RAP")
    if output == "-":
        raise click.UsageError(
            "-o requires a file; use /dev/stdout for standard output"
        )
    if output is not None and read_compiled(path) is not None:
        fail(f"`{path}` is already a compiled library")
    library = load_checked(path)
    for name in explained:
        _explain(library, name)
    if output is not None:
        data = _encoded(library, path, output)
        write_output(output, data)
        say(f"wrote {output}: {len(data)} bytes")


def _explain(library: Program, name: str) -> None:
    try:
        askings = explain(library, name)
    except (ValueError, SavedError) as error:
        fail(str(error))
    for line in describe(askings):
        click.echo(line)


def _encoded(library: Program, path: str, output: str) -> bytes:
    """Return the compiled library and tests; refuse to overwrite a source file."""
    with gc_paused():
        suites = list(_suites(path))
        used = (library.library, *[suite.library for suite in suites])
        files = [file for one in used for file in one.files]
        told = "is a source file of the library"
        refuse_output("-o", output, COMPILED_LIBRARY, (files, told))
        return encode(library.library, library.name, suites)


def _suites(path: str) -> Iterator[Suite]:
    """Yield the tests at a path; errors in the tests end the command."""
    if path == "-":  # the source is already read
        return
    found = discover.find([path])
    reports = [*found.reports]
    for case in found.cases:
        if case.faults:
            reports.append(CheckReport(case.faults, case.library.library.files))
    refuse_faulty(*reports)
    for _, cases in groupby(found.cases, lambda case: id(case.library)):
        together = list(cases)
        program = together[0].library
        tests = [case.test for case in together]
        yield Suite(tests, program.library, program.name)
