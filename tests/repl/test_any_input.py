"""Whatever is typed gets an answer, and what fits behind it can be asked for."""

from __future__ import annotations

import random

import pytest

from rapc.debug.arguments import is_balanced
from rapc.language.highlight import indentation, tokens
from rapc.repl.commands.table import commands
from rapc.repl.complete import candidates
from rapc.repl.draw import draw
from tests.repl.shells import truck_shell

_PIECES = (
    *(f":{command.name}" for command in commands() if command.name != "record"),
    *(
        "(",
        ")",
        "((",
        "))",
        '"',
        "'",
        ";",
        "#|",
        "|#",
        "\\",
        "\n",
        "\t",
        "\0",
        "é",
        "→",
    ),
    *("0", "1", "12", "-3", "4.5", "1e400", "[7]", "[", "nan", "inf", "99999999999"),
    *("?x", "?", ":priority", ":at", "at", "end", "all", "back", "if", "after", "log"),
    *("define-rap", "define-query", "declare-memory-proposition", "and", "not", "=>"),
    *("truck-location", "location", "place", "rock-order", "red", "item-1", "count"),
    *("task", "rap", "fact", "true", "time", "task-failed", "goal=x", "=", "in"),
    *("(place ?x ?y)", "(rock-order red 1)", "(assert (truck-fuel 3))", "()", "(())"),
)


@pytest.mark.parametrize("seed", range(4))
def test_any_input_has_an_answer(seed: int) -> None:
    chance = random.Random(seed)
    shell = truck_shell()
    shell.answer(":step 20")
    for _ in range(250):
        size = chance.randrange(1, 7)
        text = " ".join(chance.choice(_PIECES) for _ in range(size))
        if text.startswith((":run", ":goto 9", ":to 9", ":step 9")):
            continue
        answer = shell.answer(text)
        assert draw(answer, chance.choice((20, 40, 100)), color=seed == 1) is not None
        for line in draw(answer, 60, color=False).splitlines():
            assert line.isprintable(), (text, line)
        if shell.history.over:
            shell.answer(":goto 20")


@pytest.mark.parametrize("seed", range(2))
def test_anything_may_be_completed_and_coloured(seed: int) -> None:
    chance = random.Random(seed)
    shell = truck_shell()
    for _ in range(150):
        size = chance.randrange(1, 6)
        text = chance.choice(("", " ")).join(
            chance.choice(_PIECES) for _ in range(size)
        )
        for one in candidates(shell, text):
            assert one.replaces <= len(text)
        assert "".join(said for _, said in tokens(text)) == text
        assert indentation(text) >= 0
        is_balanced(text)


def test_deeply_nested_value_is_refused() -> None:
    shell = truck_shell()
    for text in ("(" * 3000 + ")" * 3000, "(and " * 300 + "t" + ")" * 300, "(" * 3000):
        answer = shell.answer(text)
        assert answer.failed
        candidates(shell, text)
