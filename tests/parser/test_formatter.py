"""The canonical layout: the same meaning, all comments, and nothing left to change."""

from __future__ import annotations

import re
from random import Random

import pytest
from hypothesis import given
from hypothesis.strategies import randoms

from rapc.base.diagnostics import edited
from rapc.base.source import SourceFile
from rapc.ir import layout
from rapc.ir.layout import WIDTH, Noted
from rapc.parser.formatter import Formatter, formatted
from tests.effort import examples

from .layout import hold_layout, laid_out_text
from .programs import CHECKOUT, FILES, programs


def test_libraries_and_examples_are_laid_out_in_short_lines() -> None:
    """What is laid out as it stands is not laid out twice for its lines."""
    changed, long = [], []
    for file in FILES:
        if file.relative_to(CHECKOUT).parts[0] != "tests":
            text = file.read_text(encoding="utf-8")
            if laid_out_text(text) != text:
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
    assert laid_out_text(text) == wanted
    hold_layout(text)


@pytest.mark.parametrize(
    "text",
    ["(define-rap (a)", "(a))", '(a "b', "#| a", "(a \x00)", "(define-rap (1e5))"],
)
def test_what_cannot_be_read_is_left_as_it_is(text: str) -> None:
    made = formatted(SourceFile("a.rap", text))
    assert made.diagnostics
    assert made.text == text


def test_the_deepest_nesting_is_laid_out() -> None:
    hold_layout("(a " * 99 + ")" * 99)


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
    hold_layout(
        "".join(
            piece + (chance.choice(notes) if chance.random() < 0.1 else "")
            for piece in pieces
            if piece
        )
    )


def test_edited_form_alone_is_laid_out_again(monkeypatch: pytest.MonkeyPatch) -> None:
    forms = [
        f"(define-rap (go-{n}) (method (primitive (drive {n}))))" for n in range(9)
    ]
    formatter = Formatter()
    formatter.formatted(SourceFile("f", "\n".join(forms)))
    forms[4] = forms[4].replace("drive", "fly")
    source = SourceFile("f", "\n".join(forms))
    wanted = formatted(source).text
    made: list[Noted] = []

    def lines(tree: Noted, width: int) -> str:
        made.append(tree)
        return layout.lines(tree, width)

    monkeypatch.setattr("rapc.parser.formatter.lines", lines)
    assert formatter.formatted(source).text == wanted
    names = {tree[1] for tree in made if isinstance(tree, tuple)}
    assert names == {("go-0",), ("go-4",)}  # the first form has no `(` before it


STRETCHES = """\
(define-rap (one)  (method (primitive (drive 1))))
; note
(define-rap (two) (method (primitive (drive 2)))

(define-rap (three)   (method (primitive (drive 3))))
"""


def test_edits_of_a_stretch_leave_other_and_broken_forms() -> None:
    source = SourceFile("f", STRETCHES)
    every = Formatter().edits(source, 0, len(STRETCHES))
    at = STRETCHES.index("(define-rap (three)")
    assert [edit.span.start for edit in every] == [0, at]
    assert Formatter().edits(source, at, at) == every[1:]
    assert edited(STRETCHES, every).startswith("(define-rap (one)\n  (method\n")


def test_edits_stop_at_an_unclosed_string() -> None:
    text = '(declare-event :a () "text\n(b  c)\n")\n(define-query (d)   (e))\n'
    assert Formatter().edits(SourceFile("f", text), 0, len(text)) == ()
    assert "(b  c)" in formatted(SourceFile("f", text)).text
