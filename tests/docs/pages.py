"""The pages of docs/ as tests read them: sections, tables, blocks, commands."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec

CHECKOUT = Path(__file__).parents[2]

_BLOCK = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.M | re.S)


class Block(msgspec.Struct, frozen=True):
    """A fenced block: its language, the file it stands for, its text."""

    language: str
    name: str
    text: str


def page(name: str) -> str:
    """Return the text of docs/NAME.md."""
    return (CHECKOUT / "docs" / f"{name}.md").read_text(encoding="utf-8")


def section(text: str, heading: str, end: str = "\n#") -> str:
    """Return what stands below a heading, to the next one."""
    return text.partition(f"\n{heading}\n")[2].partition(end)[0]


def blocks(text: str, language: str = "") -> tuple[Block, ...]:
    """Return the blocks of a page, or those of one language, in order."""
    found = [Block(*match.groups("")) for match in _BLOCK.finditer(text)]
    return tuple([one for one in found if language in ("", one.language)])


def first_words(text: str, word: str) -> list[str]:
    """Return the words in back-ticks in the first cells of tables.

    Args:
        text: with the tables.
        word: a pattern of a word from its back-tick on, the word its only group.
    """
    cells = re.findall(r"^\| (`.*?) \| ", text, re.M)
    return [found for cell in cells for found in re.findall(word, cell)]


def rows(text: str, first: str) -> list[list[str]]:
    """Return the cells of the table whose head begins with a word."""
    [table] = re.findall(rf"^\| {first} \|.*?\n(?=\n)", text, re.M | re.S)
    return [row.strip("|").split("|") for row in table.strip().splitlines()[2:]]


def ticked(text: str) -> list[str]:
    """Return what stands in back-ticks."""
    return re.findall(r"`([^`]+)`", text)


def commands(text: str) -> Iterator[tuple[str, list[str]]]:
    """The commands of a `console` block with the lines they are to print."""
    for part in re.split(r"^\$ ", text, flags=re.M)[1:]:
        command, *lines = part.rstrip("\n").split("\n")
        while command.endswith("\\"):
            command = command[:-1] + lines.pop(0).lstrip("> ")
        yield command, lines


def agrees(printed: Sequence[str], told: Sequence[str]) -> bool:
    """Whether lines are as told, a line `...` standing for any number of them."""
    pattern = "".join("(?:.*\n)*?" if t == "..." else re.escape(t) + "\n" for t in told)
    return re.fullmatch(pattern, "".join(line + "\n" for line in printed)) is not None
