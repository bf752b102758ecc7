"""`rapc fmt PATH...`: RAP files in their canonical layout."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import click

from rapc.analysis import suite
from rapc.analysis.driver import CheckReport, Finding
from rapc.base.files import (
    names_at,
    path_of,
    read_standard_input,
    read_text,
    write_back,
)
from rapc.base.names import plural
from rapc.base.source import SourceFile
from rapc.cli.common import diff, print_findings
from rapc.cli.options import USAGE, command, say, settings
from rapc.library.loader import STANDARD_INPUT
from rapc.parser.formatter import Formatted, formatted

EXAMPLES = """\b
Examples:
  rapc fmt my-library/
  rapc fmt --check my-library/
  rapc fmt --diff deliver.rap
  rapc fmt - < deliver.rap
"""


@command(EXAMPLES)
@click.argument("paths", metavar="PATH...", nargs=-1, required=True)
@click.option("--check", is_flag=True, help="Change nothing; exit with 1 if it would.")
@click.option("--diff", "differ", is_flag=True, help="The same, and show the changes.")
def fmt(paths: Sequence[str], check: bool, differ: bool) -> None:
    """Bring RAP files, and all below folders, into their canonical layout, in place.

    Tests are among them; files that these require are not. A text on standard input
    (-) goes to standard output. Comments stay where they are, and what the text means
    stays as it is.

    Exit status: 0; 1 with --check or --diff if something would change; 2 for what
    cannot be read, a file with a slip in its parentheses, say: it is left as it is.
    """
    changed, same, faulty = 0, 0, 0
    for source in _sources(paths):
        made = formatted(source)
        if made.diagnostics:
            _report(source, made)
            faulty += 1
        elif source.name == STANDARD_INPUT and not (check or differ):
            click.echo(made.text, nl=False)
            same += 1
        elif made.text == source.text:
            same += 1
        else:
            changed += 1
            _change(source, made.text, check, differ)
    if not settings().quiet and list(paths) != ["-"]:
        click.echo(_summary(changed, same, faulty, check or differ), err=differ)
    if faulty:
        raise SystemExit(USAGE)
    if changed and (check or differ):
        raise SystemExit(1)


def _sources(paths: Sequence[str]) -> Iterator[SourceFile]:
    """Yield the files at some paths, each once."""
    seen: set[str] = set()
    for path in paths:
        if path == "-":
            yield SourceFile(STANDARD_INPUT, read_standard_input())
            continue
        for name in names_at(path, tests=True):
            if name not in seen:
                seen.add(name)
                yield SourceFile(name, read_text(path_of(name)))


def _report(source: SourceFile, made: Formatted) -> None:
    """Print what keeps a file from being laid out."""
    rules = suite.rules()
    findings = tuple(Finding(rules[d.rule], d) for d in made.diagnostics)
    print_findings(CheckReport(findings, {source.name: source}), "full")


def _change(source: SourceFile, text: str, check: bool, differ: bool) -> None:
    """Write a file's new text, or say how it would change."""
    if differ:
        click.echo(diff(source.name, source.text, text), nl=False)
    elif check:
        click.echo(f"would change {source.name}")
    else:
        write_back(path_of(source.name), text)
        say(f"changed {source.name}")


def _summary(changed: int, same: int, faulty: int, asked: bool) -> str:
    would = "would change" if asked else "changed"
    parts = [f"{would} {plural(changed, 'file')}"] if changed else []
    if same:
        parts.append(f"{plural(same, 'file')} {'is' if same == 1 else 'are'} well")
    if faulty:
        parts.append(f"{plural(faulty, 'file')} cannot be laid out")
    return ", ".join(parts) or "there are no RAP files"
