"""Each table of a page names everything that there is, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import click
import msgspec
import pytest

from rapc import events
from rapc.cli.main import COMMANDS, cli
from rapc.debug.breakpoints import KINDS
from rapc.experiments.definition import Experiment, Reference, Series
from rapc.experiments.measures import LABELS
from rapc.language.heads import TEST_CLAUSES, heads, rules_by_head
from rapc.library.loader import load
from rapc.repl.commands.table import commands
from rapc.runtime.settings import Settings
from rapc.testing.coverage import COLUMNS

from .pages import CHECKOUT, first_words, page, rows, section, ticked

CLI, TESTING, EXPERIMENTS = (
    page("reference/cli"),
    page("reference/tests"),
    page("how-to/experiments"),
)
COMMON = set(first_words(CLI.partition("\n## ")[0], r"`(-[a-z-]+)"))
_KEY = r"`([a-z-]+)`"


def _options(name: str) -> set[str]:
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    context = click.Context(command, help_option_names=["-h", "--help"])
    options = [p for p in command.get_params(context) if isinstance(p, click.Option)]
    return {name for option in options for name in option.opts}


def _keys(kind: type[msgspec.Struct]) -> set[str]:
    return {field.encode_name for field in msgspec.structs.fields(kind)}


def _of_commands() -> Iterator[tuple[str, object, object]]:
    headings = re.findall(r"^## (rapc (\w+).*)$", CLI, re.M)
    yield "commands", [name for _, name in headings], list(COMMANDS)
    for heading, name in headings:
        told = first_words(section(CLI, f"## {heading}", "\n## "), r"`(-[a-z-]+)")
        yield f"options of {name}", {*told} | COMMON, _options(name)
    defaults = dict(re.findall(r"^\| `rapc\.([a-z-]+)` \| (\w+) \| ", CLI, re.M))
    settings = msgspec.structs.asdict(Settings())
    known = {n.replace("_", "-"): str(v).lower() for n, v in settings.items()}
    yield "settings", defaults, known


def _of_traces() -> Iterator[tuple[str, object, object]]:
    common = _keys(events.Event)
    found = re.findall(r"^\| `([a-z-]+)` \| (`.*?`) \| ", page("reference/trace"), re.M)
    known = {name: {*events.keys(k)} - common for name, k in events.kinds().items()}
    yield "keys of all events", common, {"n", "cycle", "time"}
    yield "events", {event: {*re.findall(_KEY, keys)} for event, keys in found}, known
    yield "events once each", len(found), len(known)


def _of_tests() -> Iterator[tuple[str, object, object]]:
    for heading, known in (
        ("## What is given", TEST_CLAUSES),
        ("### The script", rules_by_head("_once_row_option")),
        ("### At a time", heads("_action")),
        ("## What is expected", rules_by_head("expectation")),
    ):
        told = first_words(section(TESTING, heading), r"`[(]?([:a-z-]+)")
        yield heading.strip("# "), {*told}, {*known}
    told = re.findall(r"`([a-z ]+)`", TESTING.partition("## Coverage\n")[2])
    yield "columns of coverage", {*COLUMNS.values()} & {*told}, {*COLUMNS.values()}


def _of_experiments() -> Iterator[tuple[str, object, object]]:
    text = section(EXPERIMENTS, "## The file", "\n## ")
    of_file, _, of_part = text.partition("A part is a series")
    told = first_words(of_file, _KEY)
    yield "keys of an experiment", sorted([*told, "name"]), sorted(_keys(Experiment))
    yield "keys of a part", sorted(first_words(of_part, _KEY)), sorted(_keys(Series))
    told = ticked(of_part.partition("A `reference` has")[2].partition("\n\n")[0])
    yield "keys of a reference", _keys(Reference) & {*told}, _keys(Reference)
    told = first_words(section(EXPERIMENTS, "## What is measured", "\n## "), _KEY)
    yield "measures", told, list(LABELS)


def _of_the_debugger() -> Iterator[tuple[str, object, object]]:
    text = page("reference/repl")
    told = re.findall(r"`:([a-z][a-z-]*)", text)
    yield "commands of the debugger", {*told}, {one.name for one in commands()}
    stopping = text.partition("## Stopping")[2].partition("`:watch")[0]
    yield "breakpoints", {*first_words(stopping, r"`([a-z]+)")}, {*KINDS}


def _of_libraries() -> Iterator[tuple[str, object, object]]:
    """The RAPs of each library by their files."""
    for name, first, column in (
        ("truck", "layer", 2),
        ("hallway", "layer", 2),
        ("truck-beyond", "file", 1),
    ):
        told: dict[str, str] = {}
        file = ""
        for row in rows(page(f"libraries/{name}"), first):
            file = "".join(ticked(row[column - 1])) or file
            told |= dict.fromkeys(ticked(row[column]), file)
        raps = load([CHECKOUT / "stdlib" / name]).library.raps
        places = {rap: Path(form.span.file) for rap, form in raps.items()}
        own = {rap: p.name for rap, p in places.items() if p.parent.name == name}
        yield f"RAPs of {name}", told, own


TABLES = [
    pytest.param(told, known, id=name)
    for tables in (
        *(_of_commands, _of_traces, _of_tests, _of_experiments, _of_the_debugger),
        *(_of_libraries,),
    )
    for name, told, known in tables()
]


@pytest.mark.parametrize(("told", "known"), TABLES)
def test_a_table_names_all_there_is_and_nothing_else(
    told: object, known: object
) -> None:
    assert known
    assert told == known


@pytest.mark.parametrize("name", COMMANDS)
def test_common_options_are_told_once(name: str) -> None:
    heading = re.findall(rf"^(## rapc {name}.*)$", CLI, re.M)[0]
    told = first_words(section(CLI, heading, "\n## "), r"`(-[a-z-]+)")
    assert not COMMON & {*told}
