"""Kinds of values: which values are of which kind, and what is said of others."""

from __future__ import annotations

import pytest

from rapc.base.values import Atom, Text
from rapc.library.library import Library
from rapc.library.loader import load_text
from rapc.library.saved import SavedLibrary, encode
from rapc.library.signatures import Signatures

TEXT = """
(declare-kind place)
(declare-kind room :is place (kitchen hall))
(declare-kind cell :is room (c1))
(declare-kind door (front 3 "Side"))
(declare-kind level :is number)
(declare-kind word :is text)
(declare-memory-property open ((?door door) ?is) unknown)
(declare-primitive go (?how (?room room)) (okay))
(define-rap (visit (?room room) ?why))
"""


@pytest.fixture(params=["source", "saved"])
def signatures(request: pytest.FixtureRequest) -> Signatures:
    """What the text declares, from its source and from a saved library."""
    library: Library = load_text(TEXT).library
    if request.param == "saved":
        library = SavedLibrary(encode(library, "kinds"), "kinds").library
    return Signatures.of(library)


@pytest.mark.parametrize(
    ("kind", "values", "others"),
    [
        ("number", (3, 2.5), ("three", Text("3"))),
        ("text", (Text("a"),), ("a", 3)),
        ("item", ("box",), (3, Text("box"))),
        ("symbol", ("box", ":box"), (3, Text("box"))),
        ("place", ("anywhere", "kitchen"), (3, Text("a"))),
        ("room", ("kitchen", "c1"), ("attic", "front")),
        ("cell", ("c1",), ("kitchen",)),
        ("door", ("front", 3, Text("Side")), ("side", 4)),
        ("level", (4,), ("full",)),
        ("word", (Text("a"),), ("a",)),
        ("nobody-declares-it", (3, "a", Text("a")), ()),
    ],
)
def test_which_values_are_of_a_kind(
    signatures: Signatures,
    kind: str,
    values: tuple[Atom, ...],
    others: tuple[Atom, ...],
) -> None:
    assert all(signatures.kinds.holds(kind, value) for value in (*values, "unknown"))
    assert not any(signatures.kinds.holds(kind, value) for value in others)


def test_values_from_outside_are_held_against_kinds(signatures: Signatures) -> None:
    said = (
        "`back` is not a value of kind door, as declared for "
        "`?door` in `(open ?door ?is)`"
    )
    assert signatures.wrong_kind("asserted", "open", ("back", "true")) == said
    assert signatures.wrong_kind("asserted", "open", ("front",)) is None
    assert signatures.wrong_kind("erased", "open", ("back",)) == said
    assert signatures.wrong_kind("erased", "open", ()) is None
    assert signatures.wrong_kind("goal", "visit", ("hall", 3)) is None
    assert signatures.wrong_kind("asserted", "no-such-thing", (3,)) is None
    assert signatures.wrong_kind("primitive", "go", (3, "hall")) is None
    said = (
        "`attic` is not a value of kind room, as declared "
        "for `?room` in `(visit ?room ?why)`"
    )
    assert signatures.wrong_kind("goal", "visit", ("attic", 3)) == said


def test_kinds_are_apart_if_no_value_was_meant_for_both(signatures: Signatures) -> None:
    kinds = signatures.kinds
    for one, other in (("room", "door"), ("number", "item"), ("place", "level")):
        assert kinds.apart(one, other)
        assert kinds.apart(other, one)
    for one, other in (("room", "place"), ("cell", "place"), ("room", "item")):
        assert not kinds.apart(one, other)
        assert not kinds.apart(other, one)
    assert not kinds.apart("level", "number")
    assert not kinds.apart("item", "symbol")
    assert not kinds.apart("room", "nobody-declares-it")
