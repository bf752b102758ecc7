"""`rapc fmt PATH...`: RAP files in their canonical layout."""

from __future__ import annotations

from collections.abc import Sequence

import click

from rapc.analysis import registry
from rapc.analysis.driver import CheckReport, Finding
from rapc.base.files import names_at, path_of, read_standard_input, read_text
from rapc.base.names import plural
from rapc.base.source import SourceFile
from rapc.base.visible import visible
from rapc.base.writing import remove_parts
from rapc.cli.common import diff, print_findings, rewrite
from rapc.cli.options import USAGE, TypedPath, command, say, settings
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
@click.argument("paths", metavar="PATH...", type=TypedPath(), nargs=-1, required=True)
@click.option(
    "--check", is_flag=True, help="Write no file; exit with 1 if one would change."
)
@click.option(
    "--diff", "differ", is_flag=True, help="Like --check; also show the changes."
)
def fmt(paths: Sequence[str], check: bool, differ: bool) -> None:
    """Format RAP files, and all RAP files below folders, in place.

    Test files are formatted, too; required files outside the paths are not. The text
    on standard input (-) goes to standard output. Comments keep their places, and the
    meaning of the text is unchanged.

    Exit status: 0; 1 with --check or --diff if a file would change; 2 if a file cannot
    be read, parsed or written. A file that cannot be formatted is unchanged.
    """
    changed, same, faulty, left = 0, 0, 0, 0
    names = _names(paths)
    if not (check or differ):
        remove_parts(path_of(name) for name in names if name != STANDARD_INPUT)
    for source in map(_source, names):
        made = formatted(source)
        if made.diagnostics:
            _report(source, made)
            faulty += 1
        elif source.name == STANDARD_INPUT and not (check or differ):
            click.echo(made.text, nl=False)
            same += 1
        elif made.text == source.text:
            same += 1
        elif _change(source, made.text, check, differ):
            changed += 1
        else:
            left += 1
    if not settings().quiet and list(paths) != ["-"]:
        click.echo(_summary(changed, same, faulty, left, check or differ), err=differ)
    if faulty or left:
        raise SystemExit(USAGE)
    if changed and (check or differ):
        raise SystemExit(1)


def _names(paths: Sequence[str]) -> list[str]:
    """Return the names of the files at some paths, each once."""
    found: list[str] = []
    for path in paths:
        found += [STANDARD_INPUT] if path == "-" else names_at(path, tests=True)
    return list(dict.fromkeys(found))


def _source(name: str) -> SourceFile:
    is_input = name == STANDARD_INPUT
    return SourceFile(
        name, read_standard_input() if is_input else read_text(path_of(name))
    )


def _report(source: SourceFile, made: Formatted) -> None:
    """Print the errors that prevent formatting of a file."""
    rules = registry.rules()
    findings = tuple(Finding(rules[d.rule], d) for d in made.diagnostics)
    print_findings(CheckReport(findings, {source.name: source}), "full")


def _change(source: SourceFile, text: str, check: bool, differ: bool) -> bool:
    """Write a file's new text, or print the change; return False if that fails."""
    if differ:
        click.echo(diff(source.name, source.text, text), nl=False)
    elif check:
        click.echo(f"would reformat {visible(source.name)}")
    elif rewrite(source.name, source.text, text):
        say(f"reformatted {source.name}")
    else:
        return False
    return True


def _summary(changed: int, same: int, faulty: int, left: int, asked: bool) -> str:
    done = "would be reformatted" if asked else "reformatted"
    parts = [f"{plural(changed, 'file')} {done}"] if changed else []
    if same:
        parts.append(f"{plural(same, 'file')} unchanged")
    if faulty:
        parts.append(f"{plural(faulty, 'file')} cannot be formatted")
    if left:
        parts.append(f"{plural(left, 'file')} cannot be written")
    return ", ".join(parts) or "no RAP files found"
