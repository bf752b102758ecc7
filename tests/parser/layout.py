"""What the canonical layout of a text promises."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.base.source import SourceFile
from rapc.ir.printer import one_line, trees
from rapc.parser.formatter import formatted
from rapc.parser.unit import SourceUnit

from .reading import FILE, parsed


def laid_out_text(text: str) -> str:
    """A text that can be read, laid out."""
    made = formatted(SourceFile(FILE, text))
    assert made.diagnostics == ()
    return made.text


def _meaning(unit: SourceUnit) -> list[str]:
    nodes = [*unit.forms, *unit.tests]
    return [one_line(tree) for node in nodes for tree in trees(node)]


def _comments(unit: SourceUnit) -> list[str]:
    return [comment.text.rstrip() for comment in unit.comments]


def hold_layout(text: str) -> None:
    """Hold a text to all that the layout promises, if it can be laid out."""
    laid_out = formatted(SourceFile(FILE, text))
    if laid_out.diagnostics:
        assert laid_out.text == text
        return
    made = laid_out.text
    assert laid_out_text(made) == made
    before, after = parsed(text), parsed(made)
    assert [d.rule for d in after.diagnostics] == [d.rule for d in before.diagnostics]
    if not before.diagnostics:
        assert _meaning(after) == _meaning(before)
    assert _comments(after) == _comments(before)
    assert made == "" or (made.endswith("\n") and not made.endswith("\n\n"))
    assert not any(line.endswith(" ") for line in _outside_strings(made))


def _outside_strings(text: str) -> Iterator[str]:
    """Lines that end outside a string."""
    inside = False
    for line in text.split("\n"):
        inside ^= line.count('"') % 2 == 1
        if not inside:
            yield line
