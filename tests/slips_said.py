"""Programs that say in comments which slips of the pen are to be found in them.

A line `; if OLD were NEW: rule, rule` speaks of the nearest line above it that is no
such line: with NEW in the place of OLD the rules named report there. `rule 2 below` and
`rule 3 above` speak of lines further down or up, and `nothing` as NEW stands for no
text. So each such line tells of two programs that differ by little: the one that stands
in the file, a near miss, and the one with the slip, which triggers the rule.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

_SLIP = re.compile(r"^\s*; if (?P<old>.+?) were (?P<new>.+): (?P<rules>[a-z0-9, -]+)$")
_RULE = re.compile(r"(?P<rule>[a-z-]+)(?: (?P<far>[0-9]+) (?P<way>above|below))?")


class Slip(NamedTuple):
    """One slip of the pen, and what is to be found of it."""

    #: The row of the comment that tells of it, from 1.
    row: int
    #: The program with the slip.
    text: str
    #: The row and the rule of each finding that the slip adds.
    findings: tuple[tuple[int, str], ...]


def slips(text: str) -> Iterator[Slip]:
    """Yield the slips of which a program tells, in the order of the text.

    Raises:
        ValueError: if such a comment lacks a part, or its text is not in its line once.
    """
    lines = text.split("\n")
    about = 0
    for row, line in enumerate(lines, start=1):
        if not line.lstrip().startswith("; if "):
            about = row
            continue
        said = _SLIP.match(line)
        old, new = (said["old"], said["new"]) if said else ("", "")
        if said is None or lines[about - 1].count(old) != 1:
            raise ValueError(f"line {row} tells of no slip of the line above: {line}")
        slipped = lines[about - 1].replace(old, "" if new == "nothing" else new)
        changed = [*lines[: about - 1], slipped, *lines[about:]]
        findings = tuple(_findings(about, said["rules"]))
        yield Slip(row, without("\n".join(changed)), findings)


def without(text: str) -> str:
    """Return a program with an empty line for each comment that tells of a slip."""
    return "\n".join(map(_alone, text.split("\n")))


def _alone(line: str) -> str:
    """Return a line of a program, or an empty one where it tells of a slip."""
    return "" if line.lstrip().startswith("; if ") else line


def _findings(about: int, rules: str) -> Iterator[tuple[int, str]]:
    """Yield the row and the rule of each finding that a comment names."""
    for named in rules.split(","):
        found = _RULE.fullmatch(named.strip())
        if found is None:
            raise ValueError(f"line {about} has a slip with no rule: {named.strip()}")
        far = int(found["far"] or 0)
        yield about + (far if found["way"] == "below" else -far), found["rule"]
