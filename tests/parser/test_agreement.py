"""Our reader and lark's parse of the same grammar find the same data in every text.

A text that lark refuses has findings; one that lark reads has none, but for what the
grammar does not limit: depth, length, what merely looks like a number, and a form that
begins a line within another.
"""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.lark import from_lark
from lark import Token, Tree
from lark.exceptions import UnexpectedInput

from rapc.language.build import parser as reference
from tests.effort import examples, first
from tests.parser.programs import FILES as PROGRAMS
from tests.parser.reading import Plain, plain, reading

CHECKOUT = Path(__file__).parents[2]
UNLIMITED = {"malformed-number", "too-long", "nested-too-deeply"}
"""What is said of texts that the grammar allows."""

KINDS = {"NUMBER": "Numeral", "WORD": "Symbol"}

MARKS = [
    "(",
    ")",
    "(",
    ")",
    " ",
    "\n",
    '"',
    '\\"',
    "\\",
    ";",
    "#|",
    "|#",
    "#",
    "|",
    "'",
]
WORDS = [
    "#'",
    ":",
    "?",
    "?x",
    ":kw",
    "a",
    "B1",
    "12",
    "-3.5",
    "1e5",
    "5.",
    "=",
    "\u00a0",
]
LINES = ["(define-rap", "\n(define-rap", "\n(require", "\ndeclare-x"]
ROUGH = [*MARKS, *WORDS, *LINES, "[", "`", "|#|", "((", "))", "\ufeff", "\u00e9"]
SOUND = [
    "a",
    "B-2",
    "?x",
    "?",
    ":kw",
    "12",
    "-3.5",
    "+0.0",
    "=",
    "#1",
    "gr\u00fcn",
    '"a #| ; b"',
    '""',
    '"two\nlines"',
]
GAPS = [" ", "\n ", "\t", " ; a #| b\n", " #| c |# ", " #| d #| e |# ; |#", "\r\n\f"]
FORM_IN_LIST = re.compile(r"\n\((?:define|declare)-")
FORM_IN_STRING = re.compile(r'"[^"]*\n\((?:define|declare)-')
PIECES = st.one_of(st.sampled_from([*MARKS, *WORDS, *LINES]), st.text(max_size=3))
TEXTS = st.lists(PIECES, max_size=40).map("".join)


def _by_lark(tree: Tree[Token]) -> tuple[Plain, ...]:
    items: list[Plain] = []
    for child in tree.children:
        if isinstance(child, Tree):
            meta = child.meta
            items.append(("List", _by_lark(child), meta.start_pos, meta.end_pos))
        elif not child.type.startswith("BLOCK"):
            assert child.start_pos is not None
            assert child.end_pos is not None
            text = str(child)
            if child.type == "STRING":
                text = text[1:-1]
            elif child.type == "NUMBER":
                text = str(float(text) + 0.0)  # there is no negative zero
            else:
                text = text.lower()
            kind = KINDS.get(child.type, child.type.capitalize())
            kind = "Arrow" if text == "=>" else kind
            items.append((kind, text, child.start_pos, child.end_pos))
    return tuple(items)


def _by_us(items: tuple[Plain, ...]) -> tuple[Plain, ...]:
    made: list[Plain] = []
    for kind, value, start, end in items:
        if kind == "List":
            assert isinstance(value, tuple)
            made.append((kind, _by_us(value), start, end))
        elif kind == "Numeral":
            assert isinstance(value, int | float)
            made.append((kind, str(float(value)), start, end))
        else:
            made.append((kind, value, start, end))
    return tuple(made)


def check(text: str) -> None:
    """Hold our reading of a text against lark's."""
    found = reading(text)
    said = {d.rule for d in found.diagnostics}
    try:
        tree = reference().parse(text, start="data")
    except UnexpectedInput:
        assert said - UNLIMITED or text.startswith("\ufeff")
        return
    if FORM_IN_LIST.search(text):
        said -= {"missing-parenthesis", "surplus-parenthesis"}
    assert said <= UNLIMITED
    if not found.diagnostics and "\\" not in text:
        data = tuple(plain(top.datum) for top in found.forms)
        assert _by_us(data) == _by_lark(tree)
        assert not any(top.damaged for top in found.forms)


def test_there_are_programs() -> None:
    assert len(PROGRAMS) > 10


@pytest.mark.parametrize("share", first(1, range(8)))
def test_files_of_the_repository(share: int) -> None:
    for path in PROGRAMS[share::8]:
        check(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("batch", first(1, range(25)))
def test_ten_thousand_made_texts(batch: int) -> None:
    """Half of them are sound, so their data and places are held against lark's."""
    rng = random.Random(f"texts:{batch}")
    for _ in range(200):
        sound = _sound(rng, 5)
        assert reading(sound).diagnostics == ()
        check(sound)
        check("".join(rng.choice(ROUGH) for _ in range(rng.randrange(40))))


def _sound(rng: random.Random, depth: int) -> str:
    """Data in a row, with space and comments wherever they may stand."""
    made = []
    for _ in range(rng.randrange(2, 7)):
        if depth and rng.random() < 0.4:
            made.append(f"({_sound(rng, depth - 1)})")
        else:
            made.append(rng.choice(SOUND))
        made.append(rng.choice(GAPS))
    return "".join(made)


@examples(1000)
@given(TEXTS)
def test_texts_made_of_pieces(text: str) -> None:
    check(text)


@examples(500)
@given(from_lark(reference(), start="data"))
def test_texts_made_by_the_grammar(text: str) -> None:
    check(text)
