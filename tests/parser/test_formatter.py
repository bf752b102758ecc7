"""The canonical layout: the same meaning, all comments, and nothing left to change."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest
from hypothesis import given
from hypothesis.strategies import randoms

from rapc.base.source import SourceFile
from rapc.ir.layout import WIDTH
from rapc.ir.printer import one_line, trees
from rapc.parser.formatter import formatted
from rapc.parser.parse import parse
from rapc.parser.unit import SourceUnit
from tests.effort import examples, first

from .programs import programs

ROOT = Path(__file__).parents[2]
FILES = sorted(
    path
    for folder in ("stdlib", "examples", "tests")
    for path in (ROOT / folder).rglob("*.rap")
)


def _text(text: str) -> str:
    made = formatted(SourceFile("a.rap", text))
    assert made.diagnostics == ()
    return made.text


def _meaning(unit: SourceUnit) -> list[str]:
    nodes = [*unit.forms, *unit.tests]
    return [one_line(tree) for node in nodes for tree in trees(node)]


def _comments(unit: SourceUnit) -> list[str]:
    return [comment.text.rstrip() for comment in unit.comments]


def hold(text: str) -> None:
    """Hold a text to all that the layout promises."""
    made = _text(text)
    assert _text(made) == made
    before, after = (parse(SourceFile("a.rap", each)) for each in (text, made))
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


@pytest.mark.parametrize("share", first(1, range(16)))
def test_every_file_of_the_repository_holds_what_the_layout_promises(
    share: int,
) -> None:
    tried = 0
    for file in FILES[share::16]:
        text = file.read_text(encoding="utf-8")
        if not formatted(SourceFile(str(file), text)).diagnostics:
            hold(text)
            tried += 1
    assert tried > 6


def test_libraries_and_examples_are_laid_out_in_short_lines() -> None:
    """What is laid out as it stands is not laid out twice for its lines."""
    changed, long = [], []
    for file in FILES:
        if file.relative_to(ROOT).parts[0] != "tests":
            text = file.read_text(encoding="utf-8")
            if _text(text) != text:
                changed.append(file)
            long += [row for row in text.split("\n") if len(row) > WIDTH]
    assert changed == []
    assert [row for row in long if ";" not in row and '"' not in row] == []


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("", ""),
        ("; only this", "; only this\n"),
        (
            '\n\n\n(require  "a")\n\n\n\n(require\n"b")',
            '(require "a")\n\n(require "b")\n',
        ),
        (
            "(DEFINE-RAP (Go ?Where) ; there\n (method ( primitive (drive ?where))))",
            "(define-rap (go ?where)  ; there\n"
            "  (method\n    (primitive (drive ?where))))\n",
        ),
        (
            "(define-rap (a) (succeed (b) ; why\n) (method m))\n(define-rap (b))",
            "(define-rap (a)\n  (succeed (b))  ; why\n  (method m))\n\n"
            "(define-rap (b))\n",
        ),
        (
            "(define-rap (a)\n; first\n(succeed (b))\n\n; last\n)",
            "(define-rap (a)\n  ; first\n  (succeed (b))\n\n  ; last\n  )\n",
        ),
        (
            "(define-rap (a) #| one\n  two |# (succeed (b)))",
            "(define-rap (a)  #| one\n  two |#\n  (succeed (b)))\n",
        ),
        (
            '(declare-event :e () "two\n   lines")',
            '(declare-event :e () "two\n   lines")\n',
        ),
        (
            "(define-test t (facts (a 1.50 -0)) (expect (memory (a 01))))",
            "(define-test t\n  (facts (a 1.50 -0))\n  (expect\n    (memory (a 01))))\n",
        ),
    ],
)
def test_layout(text: str, wanted: str) -> None:
    assert _text(text) == wanted
    hold(text)


@pytest.mark.parametrize(
    "text",
    ["(define-rap (a)", "(a))", '(a "b', "#| a", "(a \x00)", "(define-rap (1e5))"],
)
def test_what_cannot_be_read_is_left_as_it_is(text: str) -> None:
    made = formatted(SourceFile("a.rap", text))
    assert made.diagnostics
    assert made.text == text


def test_the_deepest_nesting_is_laid_out() -> None:
    hold("(a " * 99 + ")" * 99)


@examples(60)
@given(programs())
def test_generated_programs_hold_what_the_layout_promises(text: str) -> None:
    hold(text)


@examples(60)
@given(programs(), randoms(use_true_random=False))
def test_comments_anywhere_stay(text: str, chance: Random) -> None:
    pieces = re.split(r'("(?:[^"\\]|\\.)*"|[\s()])', text)
    notes = (
        "; one\n",
        "#| two |#",
        "\n\n",
        "\n;;; three\n",
        "  ",
        "#| four\n five |#\n",
    )
    hold(
        "".join(
            piece + (chance.choice(notes) if chance.random() < 0.1 else "")
            for piece in pieces
            if piece
        )
    )
