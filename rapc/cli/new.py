"""`rapc new NAME`: a folder with the project of the first tutorial."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import tempfile
from collections.abc import Mapping
from importlib import resources
from pathlib import Path

import click

from rapc.cli.options import TypedPath, command, fail

EXAMPLES = """\b
Examples:
  rapc new my-robot
  rapc new logistics.rap --pddl domain.pddl
"""

FILES: Mapping[str, str] = {
    "home.py": "home.py",
    "home.rap": "home.rap",
    "fetch.rap": "fetch.rap",
    "fetch.test.rap": "fetch.test.rap",
    "rapc.toml": "rapc.toml",
    "ci.yml": ".github/workflows/rapc.yml",
}
"""The paths of the files in the new folder, by their names in `project/`."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


@command(EXAMPLES)
@click.argument("name")
@click.option(
    "--pddl",
    "domain",
    type=TypedPath(),
    metavar="DOMAIN",
    help="Convert this PDDL domain to the RAP file NAME.",
)
@click.option(
    "--problem",
    type=TypedPath(),
    metavar="PROBLEM",
    help="With --pddl: also convert the objects of a problem.",
)
def new(name: str, domain: str | None, problem: str | None) -> None:
    """Create the folder NAME with a world, a library and a test.

    The project is the result of the tutorial `tutorials/first-robot`: a robot that
    fetches a cup, its simulated world, tests, a configuration and a file for CI.

    With --pddl, create the file NAME: a library with a kind for each type of the
    domain, a proposition for each predicate, and a RAP with `effects`, but without
    methods, for each action. With --problem, the kinds have the objects as values, and
    the command prints the `rapc plan` for its goal.

    Exit status: 0 if the folder or the file was created, 2 if not.
    """
    if domain is not None:
        _convert(name, domain, problem)
        return
    if problem is not None:
        fail("--problem requires --pddl")
    if _NAME.fullmatch(name) is None:
        fail(f"invalid name `{name}`: expected letters, digits, `-`, `_` and `.`")
    folder = Path(name)
    if os.path.lexists(folder):
        fail(f"`{name}` already exists")
    try:
        _create(folder)
    except OSError as error:
        fail(f"cannot create `{name}`: {error.strerror}")
    click.echo(f"created {name}: continue with `cd {name}` and `rapc test .`")


def _convert(name: str, domain: str, problem: str | None) -> None:
    """Write the library of a PDDL domain to a new file."""
    from rapc.base.files import path_named, read_text
    from rapc.base.source import SourceFile
    from rapc.base.visible import visible
    from rapc.cli.common import write_output
    from rapc.cli.keep import refuse_kept
    from rapc.errors import LoadError, TextError
    from rapc.planning.from_pddl import converted

    refuse_kept(name, "NAME")
    names = [one for one in (domain, problem) if one is not None]
    try:
        files = [SourceFile(one, read_text(path_named(one))) for one in names]
        found = converted(*files)
    except (LoadError, TextError) as error:
        fail(error.message)
    write_output(name, found.library.encode())
    for one in found.left_out:
        click.echo(visible(f"note: left out: {one}"), err=True)
    click.echo(visible(f"created {name}"))
    if found.goal is not None:
        facts = [word for fact in found.facts for word in ("--fact", fact)]
        command = shlex.join(["rapc", "plan", found.goal, name, *facts])
        click.echo(visible(f"plan for the goal: {command}"))


def _create(folder: Path) -> None:
    """Write the files to a temporary folder and rename the folder."""
    source = resources.files("rapc.cli") / "project"
    with tempfile.TemporaryDirectory(dir=folder.parent) as scratch:
        made = Path(scratch) / folder.name
        for file, path in FILES.items():
            target = made / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes((source / f"{file}.txt").read_bytes())
        shutil.move(made, folder)
