"""`rapc new NAME`: a folder with the project of the first tutorial."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from collections.abc import Mapping
from importlib import resources
from pathlib import Path

import click

from rapc.cli.options import command, fail

EXAMPLES = """\b
Examples:
  rapc new my-robot
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
def new(name: str) -> None:
    """Create the folder NAME with a world, a library and a test.

    The project is the result of the tutorial `tutorials/first-robot`: a robot that
    fetches a cup, its simulated world, tests, a configuration and a file for CI.

    Exit status: 0 if the folder was created, 2 if not.
    """
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
