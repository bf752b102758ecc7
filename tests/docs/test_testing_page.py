"""docs/reference/tests.md: its example runs as printed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ..cli.command import rapc
from .pages import page

PAGE = page("reference/tests")


@pytest.fixture
def example(tmp_path: Path) -> Path:
    """A folder with the files of the page."""
    for block in re.findall(r"^```rap\n(.*?)^```$", PAGE, re.M | re.S):
        name = block.partition("\n")[0].removeprefix(";;; ")
        (tmp_path / name).write_text(block, encoding="utf-8")
    return tmp_path


def test_the_example_is_clean(example: Path) -> None:
    assert rapc("check", "arms.rap", cwd=example).returncode == 0


def test_the_example_prints_what_the_page_says(example: Path) -> None:
    [console] = re.findall(r"^```console\n\$ (.*?)^```$", PAGE, re.M | re.S)
    command, _, printed = console.partition("\n")
    done = rapc(*command.split()[1:], cwd=example)
    at = 0
    for part in printed.split("...\n"):
        assert part in done.stdout[at:]
        at = done.stdout.index(part, at) + len(part)
    assert done.returncode == 1
