"""docs/memory.md: the world with items is checked, run and held to the port as told."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from ..cli.command import rapc
from .test_tutorial import agrees, commands

PAGE = (Path(__file__).parents[2] / "docs" / "memory.md").read_text(encoding="utf-8")
_FILE = re.compile(r"^```\w+ (boxes\.\w+)\n(.*?)^```$", re.M | re.S)
_CONSOLE = re.compile(r"^```console\n(.*?)^```$", re.M | re.S)


def test_the_world_with_items_does_as_it_is_told(tmp_path: Path) -> None:
    files = dict(_FILE.findall(PAGE))
    assert sorted(files) == ["boxes.py", "boxes.rap"]
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert rapc("check", "boxes.rap", cwd=tmp_path).returncode == 0
    [console] = _CONSOLE.findall(PAGE)
    for command, told in commands(console):
        done = rapc(*shlex.split(command)[1:], cwd=tmp_path)
        assert done.returncode == 0, done.stdout
        assert agrees(done.stdout.splitlines(), told), done.stdout
