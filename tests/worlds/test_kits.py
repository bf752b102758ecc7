"""What a kit and an offer are made of, and what code of an author takes."""

from __future__ import annotations

from typing import Any

import pytest

from rapc.runtime.authors import takes
from rapc.world import (
    Kit,
    Offer,
    Option,
)
from tests.worlds.broken_worlds import Good


def test_kit_refuses_wrong_parts() -> None:
    wrong: Any = 3
    made: Any
    for made in (
        lambda: Kit(wrong),
        lambda: Kit(Offer(), wrong),
        lambda: Kit(options=(wrong,)),
        lambda: Kit(options=(Option("a", "colour", 1, "", ""),)),
    ):
        with pytest.raises(TypeError, match=r"of a Kit|one of number, integer"):
            made()


def test_offer_refuses_wrong_parts() -> None:
    wrong: Any
    for wrong, said in (
        (
            {"primitives": {"look": 1}},
            "a tuple of results for `look` in an Offer, not 1",
        ),
        ({"primitives": {"look": (1, "okay")}}, "not .1, 'okay'"),
        ({"primitives": {"look": ("okay",)}}, "not .'okay',"),
        ({"data": {"seen": ("a",)}}, "a number of arguments for `seen`"),
        (
            {"events": {"bell": 0}},
            "expected a colon at the start of the name `bell` in an Offer",
        ),
        ({"skills": {"roll": 0}}, "the name `roll`"),
        ({"sensors": "look"}, "a tuple of names in an Offer, not 'look'"),
        ({"not_atomic": "look"}, "a tuple of names"),
        ({"data": {"seen": 1}, "arguments": {"seen": "a"}}, "arguments of `seen`"),
        ({"data": {"seen": 1}, "arguments": {"seen": ("A b",)}}, "not .'A b',"),
        (
            {"data": {"seen": 1}, "arguments": {"seen": ("a", "b")}},
            "with arguments a, b",
        ),
        (
            {"data": {"seen": 2}, "arguments": {"seen": ("a", "a")}},
            "with arguments a, a",
        ),
        ({"arguments": {"seen": ()}}, "unknown name `seen`"),
    ):
        with pytest.raises(TypeError, match=said):
            Offer(**wrong)


MAKE: Any = Good
GOOD: Any = MAKE(None, {})


@pytest.mark.parametrize(
    ("call", "counts"),
    [
        (lambda: None, {0}),
        (lambda a, b=1: None, {1, 2}),
        (lambda a, *rest: None, {1, 2, 3}),
        (lambda a, *, b: None, set()),
        (Good.now, {1}),
        (GOOD.now, {0}),
        (abs, {1}),
    ],
)
def test_how_many_arguments_code_takes(call: Any, counts: set[int]) -> None:
    assert {n for n in range(4) if takes(call, n)} == counts
