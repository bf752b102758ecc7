"""Completion by scope and kind."""

from __future__ import annotations

import pytest

from rapc.analysis.completion import completion
from rapc.library.library import Library
from rapc.library.loader import load_text
from rapc.library.signatures import Signatures

HOUSE = """\
(declare-kind room (hall den))
(declare-kind cup)
(declare-memory-property robot-at ((?where room)) unknown "The room of the robot.")
(declare-memory-proposition held ((?what cup)))
(declare-sensor-datum seen ((?where room)))
(declare-primitive drive ((?to room)) (okay stuck) :uses (wheels)
  "Drive to a room.")
(declare-primitive grasp ((?what cup)) (okay dropped))
(declare-event :bump ())
(declare-skill :track ((?what cup)))
(define-query (here (?where room)) (robot-at ?where))
(define-rap (go (?to room)) (method straight (primitive (drive ?to))))
(define-rap (take (?what cup)) (method (primitive (grasp ?what))))
(define-agenda day (task (go hall)))
"""

FORM = """\
(define-rap (fetch (?what cup) ?from)
  (method first
    (context (and (robot-at ?room) (held ?old)))
    (task-net
      (t1 (go ?room) (for t2))
      (t2 (take ?what))))
  (method second
    (context (here ?den))
    (primitive (grasp ?what))))
"""


def at(text: str) -> tuple[Library, str, int]:
    """Return the library, the text without the mark `|`, and the position of it."""
    offset = text.index("|")
    whole = text.replace("|", "")
    return load_text(HOUSE).library, whole, offset


def offered(text: str) -> list[str]:
    library, whole, offset = at(text)
    found = completion(library, Signatures.of(library), whole, offset)
    return [one.text for one in found.candidates]


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ("(go ?room)", "(go |)", ["?room", "hall", "den", "?old", "?from", "?what"]),
        ("(take ?what)", "(take |)", ["?old", "?what", "?room", "?from"]),
        ("(grasp ?what)", "(grasp |)", ["?what", "?den", "?from"]),
        ("(for t2)", "(for |)", ["t1", "t2"]),
        ("(for t2)", "(until-end t|)", ["t1", "t2"]),
        ("(t1 (go", "(| (go", []),
        ("(take ?what)", "(ta|)", ["take"]),
        ("(here ?den)", "(method-tried |)", ["first", "second"]),
        ("(here ?den)", "(last-result dro|)", ["dropped"]),
        ("(here ?den)", "(he|)", ["held", "here"]),
        ("(grasp ?what)", "(|", ["drive", "grasp", "disable", "enable", "wait-for"]),
        ("(grasp ?what)", "(enable (|))", [":track"]),
        ("(for t2)", "(wait-for (:|))", [":bump"]),
        ("cup) ?from", "r|) ?from", ["room"]),
    ],
)
def test_names_of_the_scope_are_offered(old: str, new: str, wanted: list[str]) -> None:
    text = FORM.replace(old, new)
    assert text != FORM
    assert offered(HOUSE + text)[: len(wanted) or None] == wanted


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("(define-method go (context (method-tried |", ["straight"]),
        ("(define-rap (go |", ["=>"]),
        ("(define-query (near (?x |", ["number", "text", "item", "symbol", "room"]),
        ("(define-test t (agenda |", ["day"]),
        ("(define-test t (script ((drive ?x) |", ["okay", "stuck"]),
        ("(define-test t (expect (method go |", ["straight"]),
        ("(define-test t (expect (fails (go hall) st|", ["stuck"]),
        ("(define-memory-rule (go ?x) :finish (match-result (|", ["okay", "stuck"]),
        ("(declare-primitive p (?x) (okay bad) :on (|", ["okay", "bad"]),
        ("(declare-primitive p (?x) (okay bad) :tells (|", ["seen"]),
        ("(define-rap (x) (method (claims |", ["wheels"]),
        ("(declare-primitive |", []),
    ],
)
def test_names_of_the_library_are_offered(text: str, wanted: list[str]) -> None:
    assert offered(HOUSE + text)[: len(wanted) or None] == wanted


def test_candidates_have_arguments_and_documentation() -> None:
    library, text, offset = at(HOUSE + "(define-rap (x) (method (primitive (dr|")
    (found,) = completion(library, Signatures.of(library), text, offset).candidates
    assert (found.detail, found.doc) == ("(drive ?to)", "Drive to a room.")
    assert found.space == "primitive"


def test_start_is_that_of_the_word_in_the_file() -> None:
    library, text, offset = at(HOUSE + "(define-rap (x) (method (primitive (dr|")
    assert completion(library, Signatures.of(library), text, offset).start == offset - 2
