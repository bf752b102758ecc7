"""docs/cli.md names every command, option and setting that there is, and no other."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

from rapc.cli.main import COMMANDS, cli
from rapc.runtime.settings import Settings

CHECKOUT = Path(__file__).parents[2]
PAGE = (CHECKOUT / "docs" / "cli.md").read_text(encoding="utf-8")
SECTIONS = dict(
    re.findall(r"^## rapc (\w+)[^\n]*\n(.*?)(?=^## |\Z)", PAGE, re.M | re.S)
)
COMMON = PAGE.partition("\n## ")[0]


def _told(text: str) -> set[str]:
    """The options in the first column of the tables of a text."""
    cells = re.findall(r"^\| (`-.*?) \| ", text, re.M)
    return {option for cell in cells for option in re.findall(r"`(-[a-z-]+)", cell)}


def _options(command: click.Command) -> set[str]:
    context = click.Context(
        command, info_name="rapc", help_option_names=["-h", "--help"]
    )
    options = [p for p in command.get_params(context) if isinstance(p, click.Option)]
    return {name for option in options for name in option.opts}


def test_page_has_a_section_for_each_command() -> None:
    assert list(SECTIONS) == list(COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_page_tells_the_options_of_a_command(name: str) -> None:
    command = cli.get_command(click.Context(cli), name)
    assert command is not None
    assert _told(SECTIONS[name]) == _options(command) - _told(COMMON)
    assert _told(COMMON) <= _options(command)


def test_page_tells_the_settings_with_their_defaults() -> None:
    rows = re.findall(r"^\| `rapc\.([a-z-]+)` \| (\w+) \| ", PAGE, re.M)
    names = Settings.__struct_fields__
    defaults = {n.replace("_", "-"): str(getattr(Settings(), n)).lower() for n in names}
    assert dict(rows) == defaults
