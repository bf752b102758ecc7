"""What fits at a place in an unfinished text: words, kinds of names, parentheses."""

from __future__ import annotations

import sys
from types import FrameType
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rapc.language.complete import Fits, fits
from rapc.language.grammar import TERMINALS
from tests.parser.programs import texts

RAP = "(define-rap (go ?x) "
NET = f"{RAP}(method (task-net (t1 (go here) "
WANTED = [
    ("(", ["define-rap", "require", "declare-event"], [], ""),
    ("(define-r", ["define-rap"], [], ""),
    ("(DEFINE-R", ["define-rap"], [], ""),
    (f"{RAP}(", ["succeed", "method", "duration"], [], ""),
    (f"{RAP}(suc", ["succeed"], [], ""),
    (f"{RAP}(succeed (", ["and", "believe", "="], ["PREDICATE"], ""),
    (f"{RAP}(succeed (p ", [], ["SYMBOL", "VARIABLE", "NUMBER"], "()"),
    (f"{RAP}(succeed (p ?", [], ["VARIABLE"], ""),
    (f"{RAP}(succeed (> (", ["+", "size-of", "value"], ["FUNCTION"], ""),
    (f"{RAP}(method ", [], ["METHOD", "INTEGER"], "("),
    (f"{RAP}(method (", ["context", "task-net", "primitive"], [], ""),
    (f"{RAP}(method (primitive (", ["enable", "wait-for"], ["PRIMITIVE"], ""),
    (f"{RAP}(method (primitive (enable (", [], ["SKILL"], ""),
    (f"{RAP}(method (task-net (", [], ["TAG"], ""),
    (f"{RAP}(method (task-net (t1 (", [], ["RAP"], ""),
    (f"{NET}(", ["for", "window", "until-end", "wait-for", "true"], [], "("),
    (f"{NET}(for ", [], ["TAG"], ""),
    (f"{NET}(window ", ["now", "absolute"], ["TAG"], ""),
    (f"{NET}(wait-for (:bump) :", [":proceed", ":succeed", ":fail"], [], ""),
    (f"{RAP}(method (context ", ["otherwise", "true"], [], "("),
    (f"{RAP}(method (", ["claims", "constraints", "skills"], [], ""),
    (f"{RAP}(method (primitive (p)) (", ["claims", "context"], [], ""),
    (f"{RAP}(method (claims ", [], ["THING"], "()"),
    ("(define-query (near (?x ", [], ["KIND"], ""),
    ("(define-method ", [], ["RAP"], ""),
    ("(define-method go (", ["context", "task-net", "primitive"], [], ""),
    ("(declare-kind door ", [":is"], ["STRING"], "()"),
    ("(define-agenda day (", ["require", "task"], [], ""),
    ("(define-agenda day (task (go) :", [":at", ":background", ":deadline"], [], ""),
    ("(declare-primitive go () (okay) :", [":on", ":tells", ":uses"], [], ""),
    ("(declare-primitive go () (okay) :on (okay (", ["may", "not"], ["PREDICATE"], ""),
    ("(declare-sensor-datum seen () :", [":on"], [], ""),
    ("(declare-skill :track () :", [":events", ":uses"], [], ""),
    ("(define-test t (", ["agenda", "answers", "options", "seed"], [], ""),
    ("(define-test-defaults (agenda ", [], ["AGENDA"], ""),
    ("(declare-indistinct-class rock ", [], ["COMPARATOR", "STRING"], ")"),
    ("(declare-primitive say (?x ", [], ["PARAMETER"], "()"),
    ("(declare-primitive say () (okay) ", [":atomic"], ["STRING"], ")"),
    ("(define-test t (world ", [], ["WORLD", "STRING"], ""),
    ("(define-test t (task (go) :", [":background", ":deadline", ":priority"], [], ""),
    ("(define-test t (expect (", ["succeeds", "never", "trace"], [], ""),
    ("#| (define-rap |# ; and\n(define-rap (", [], ["RAP"], ""),
    ("(wrong\n(define-rap (", [], ["RAP"], ""),
]
"""A text up to a place; words, kinds of names and parentheses that fit there."""


@pytest.mark.parametrize(("text", "words", "kinds", "marks"), WANTED)
def test_what_fits(text: str, words: list[str], kinds: list[str], marks: str) -> None:
    found = fits(text)
    assert set(words) <= set(found.words)
    assert set(kinds) <= found.kinds
    assert (found.opens, found.closes) == ("(" in marks, ")" in marks)
    assert text[found.start :].lower() == found.prefix
    assert all(word.startswith(found.prefix) for word in found.words)


def test_only_what_fits_is_offered() -> None:
    found = fits(f"{NET}(for ")
    assert found == Fits(len(f"{NET}(for "), "", (), frozenset({"TAG"}))
    assert "method" not in fits(f"{RAP}(succeed (").words


@pytest.mark.parametrize("text", ["; (", '(p "a (', "#| (", "(define-rapp ", "(p ("])
def test_nothing_is_known_of_comments_strings_and_wrong_texts(text: str) -> None:
    found = fits(text)
    assert (found.words, found.kinds, found.opens, found.closes) == (
        (),
        frozenset(),
        False,
        False,
    )


def test_small_texts_have_rules_of_their_own() -> None:
    assert "PREDICATE" in fits("(", start="proposition").kinds
    assert "believe" in fits("(", start="formula").words
    assert "RAP" in fits("(", start="goal").kinds


@settings(max_examples=200)
@given(st.data())
def test_what_stands_there_is_among_what_fits(data: st.DataObject) -> None:
    """Every token of a sound text is offered, or is of a kind that is."""
    text = data.draw(st.sampled_from([t for k, t in texts().items() if "better" in k]))
    at = data.draw(st.integers(0, len(text) - 1))
    found = fits(text[:at])
    assert found.kinds <= set(TERMINALS)
    following = text[at]
    if found.prefix or not (found.words or found.kinds or found.opens or found.closes):
        return
    if following == "(":
        assert found.opens
    if following == ")":
        assert found.closes


def test_an_answer_takes_few_calls_for_each_part_of_the_form() -> None:
    """The last form alone is read, and nothing kept of it but what may follow."""
    part = "(have cup) "
    long, short = (
        f"(define-rap (go) (succeed (or {part * count}(" for count in (200, 100)
    )
    fits(long)
    assert _calls(long) - _calls(short) < 100 * 4 * PER_TOKEN


def _calls(text: str) -> int:
    """The functions of Python called until it is known what fits behind a text."""
    count = 0

    def called(frame: FrameType, event: str, arg: Any) -> None:
        nonlocal count
        count += event == "call"

    sys.setprofile(called)
    try:
        fits(text)
    finally:
        sys.setprofile(None)
    return count


PER_TOKEN = 20
"""Calls for each symbol and parenthesis; 28 if its place in the text were gathered."""
