"""docs/explanation/memory.md: the world with items passes check, run and contract."""

from __future__ import annotations

import shlex
from pathlib import Path

from ..cli.command import rapc
from .pages import agrees, blocks, commands, page

PAGE = page("explanation/memory")


def test_the_world_with_items_does_as_it_is_told(tmp_path: Path) -> None:
    named = [block for block in blocks(PAGE) if block.name.startswith("boxes.")]
    files = {block.name: block.text for block in named}
    assert sorted(files) == ["boxes.py", "boxes.rap"]
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert rapc("check", "boxes.rap", cwd=tmp_path).returncode == 0
    [console] = blocks(PAGE, "console")
    for command, told in commands(console.text):
        done = rapc(*shlex.split(command)[1:], cwd=tmp_path)
        assert done.returncode == 0, done.stdout
        assert agrees(done.stdout.splitlines(), told), done.stdout
