"""Each command, as its help shows it, on a terminal and in a script."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from rapc.repl.commands.table import commands
from tests.cli.command import rapc
from tests.repl.terminal import Terminal

RUN = ("--task", "(rock-order red 1) :deadline 90", "--seed", "7")
EXAMPLES = [
    example
    for command in commands()
    if command.name != "quit"
    for example in command.examples
]


@pytest.mark.parametrize("columns", [40, 80, 200])
def test_every_command_answers_on_a_terminal(columns: int, tmp_path: Path) -> None:
    terminal = Terminal(columns, tmp_path, *RUN)
    terminal.see("Ctrl-D leaves")
    terminal.ask(":show none", "after a step is shown: none")
    terminal.ask(":to 60", "cycle 60")
    for command in commands():
        if command.name in ("quit", "show", "record", "export-test"):
            continue
        terminal.ask(command.examples[0], command.examples[0])
        screen = terminal.ask(":show none", "after a step is shown: none")
        assert not any("Traceback" in line for line in screen)
        assert all(len(line) <= columns for line in screen)
    assert terminal.leave() == 0


def test_every_example_of_the_help_answers_in_a_script(tmp_path: Path) -> None:
    library = Path("examples/rock-order.rap").resolve()
    inputs = [part for e in EXAMPLES for part in (":goto 60", e, ":unbreak all")]
    done = rapc(
        *("repl", str(library), "--world", "truck", *RUN, "--json"),
        stdin="\n".join([":show none", ":to 60", *inputs]) + "\n",
        cwd=tmp_path,
    )
    records = [json.loads(line) for line in done.stdout.splitlines()]
    answers = {r["input"]: r for r in records}
    assert set(EXAMPLES) <= set(answers)
    refused = {
        text: " ".join(answers[text].get("lines", ()))
        for text in EXAMPLES
        if answers[text]["failed"]
    }
    expected = re.compile(
        r"has ended|there is no|no task has failed|has not failed|no method"
        r"|is at work on no|never came up|cannot (be )?read|did not come up"
        r"|is not declared|no event|is set by"
    )
    strange = {text: why for text, why in refused.items() if not expected.search(why)}
    assert strange == {}
    assert len(refused) < len(EXAMPLES) / 3
