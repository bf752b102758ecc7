"""docs/tutorials/debugger.md is true: its files are written and its inputs typed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import rapc
from rapc.debug.history import History
from rapc.repl.commands.table import commands
from rapc.repl.draw import draw
from rapc.repl.shell import Shell
from tests.docs import pages
from tests.docs.pages import agrees

WIDTH = 100
"""How wide the terminal of the page is."""


def test_tutorial_does_as_it_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    shell: Shell | None = None
    typed = 0
    for block in blocks():
        language, text = block.language, block.text
        if language == "rap":
            Path(block.name).write_text(text, encoding="utf-8")
        elif language == "sh":
            shell = begun(text)
        elif language == "rapc":
            assert shell is not None
            for part in re.split(r"^rapc> ", text, flags=re.M)[1:]:
                said, *told = part.rstrip("\n").split("\n")
                drawn = draw(shell.answer(said), WIDTH, color=False)
                printed = drawn.rstrip("\n").split("\n")
                assert agrees(_bare(printed), _bare(told)), f"rapc> {said}\n{drawn}"
                typed += 1
    assert typed == 12
    assert shell is not None
    assert shell.history.run.results()[0].outcome == "succeeded"


def blocks() -> tuple[pages.Block, ...]:
    """Return the blocks of the page."""
    return pages.blocks(pages.page("tutorials/debugger"))


def begun(command: str) -> Shell:
    """Begin the run that a command on the page begins."""
    found = re.fullmatch(
        r"rapc repl (\S+) --world truck --task '(.*)' --seed (\d+)\n", command
    )
    assert found is not None
    path, task, seed = found.groups()
    session = History.open(rapc.load(path), "truck", tasks=[task], seed=int(seed))
    return Shell(session, commands(), [path])


def _bare(lines: list[str]) -> list[str]:
    return [line.strip() for line in lines]
