"""Each command, as its help shows it, on a terminal and in a script."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from rapc.debug.answer import Command
from rapc.repl.commands.table import commands
from tests.cli.command import rapc
from tests.effort import first
from tests.repl.terminal import Terminal

RUN = ("--task", "(rock-order red 1) :deadline 90", "--seed", "7")
EXPORTS = [e for one in commands() for e in one.examples if one.name == "export-test"]
OTHERS = [
    example
    for command in commands()
    if command.name not in ("quit", "export-test")
    for example in command.examples
]


ON_TERMINAL = [
    one
    for one in commands()
    if one.name not in ("quit", "show", "record", "bug", "export-test")
]
ONE_OF_A_GROUP = list({one.group: one for one in ON_TERMINAL}.values())


@pytest.mark.parametrize(
    "case",
    first(1, [(80, ONE_OF_A_GROUP), *((n, ON_TERMINAL) for n in (40, 80, 200))], 3),
    ids=["80, one of each group", "40", "80", "200"],
)
def test_every_command_answers_on_a_terminal(
    case: tuple[int, list[Command]], tmp_path: Path
) -> None:
    columns, typed = case
    terminal = Terminal(columns, tmp_path, *RUN)
    terminal.see("Ctrl-D quits")
    terminal.ask(":show none", "shown after each step: none")
    terminal.ask(":to 60", "cycle 60")
    for command in typed:
        terminal.ask(command.examples[0], command.examples[0])
        screen = terminal.ask(":show none", "shown after each step: none")
        assert not any("Traceback" in line for line in screen)
        assert all(len(line) <= columns for line in screen)
    assert terminal.leave() == 0


@pytest.mark.parametrize("examples", first(1, [OTHERS, EXPORTS]), ids=len)
def test_every_example_of_the_help_answers_in_a_script(
    examples: list[str], tmp_path: Path
) -> None:
    library = Path("examples/rock-order.rap").resolve()
    inputs = [part for e in examples for part in (":goto 24", e, ":unbreak all")]
    done = rapc(
        *("repl", str(library), "--world", "truck", *RUN, "--json"),
        stdin="\n".join([":show none", ":to 24", *inputs]) + "\n",
        cwd=tmp_path,
    )
    records = [json.loads(line) for line in done.stdout.splitlines()]
    answers = {r["input"]: r for r in records}
    assert set(examples) <= set(answers)
    refused = {
        text: " ".join(answers[text].get("lines", ()))
        for text in examples
        if answers[text]["failed"]
    }
    expected = re.compile(
        r"has ended|unknown|no failed task|has not failed|no method"
        r"|was never selected|cannot (be )?read|was not selected"
        r"|unknown predicate|unknown event|is set by|does not exist|no plan:"
    )
    strange = {text: why for text, why in refused.items() if not expected.search(why)}
    assert strange == {}
    assert len(refused) < len(examples) / 3
