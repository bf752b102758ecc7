"""Our reader and lark's parse of the same grammar find the same data in made texts."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.lark import from_lark

from rapc.language.build import parser as reference
from tests.effort import examples, first
from tests.parser.by_lark import hold_data
from tests.parser.reading import reading

CHECKOUT = Path(__file__).parents[2]
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
PIECES = st.one_of(st.sampled_from([*MARKS, *WORDS, *LINES]), st.text(max_size=3))
TEXTS = st.lists(PIECES, max_size=40).map("".join)


@pytest.mark.parametrize("batch", first(1, range(25)))
def test_ten_thousand_made_texts(batch: int) -> None:
    """Half of them are sound, so their data and places are held against lark's."""
    rng = random.Random(f"texts:{batch}")
    for _ in range(200):
        sound = _sound(rng, 5)
        assert reading(sound).diagnostics == ()
        hold_data(sound)
        hold_data("".join(rng.choice(ROUGH) for _ in range(rng.randrange(40))))


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
    hold_data(text)


@examples(500)
@given(from_lark(reference(), start="data"))
def test_texts_made_by_the_grammar(text: str) -> None:
    hold_data(text)
