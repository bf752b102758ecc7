"""Which RAPs call themselves, against plain reachability; and what is read for it."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping

import msgspec
import pytest

from rapc.compiler.compiler import Recursion
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.loader import load, load_text


def _library(calls: Mapping[str, list[str]]) -> Library:
    """A library of RAPs with these calls."""
    text = "".join(
        f"(define-rap ({name}) (method (task-net "
        + " ".join(f"(t{at} ({called}))" for at, called in enumerate(called_by))
        + ")))"
        for name, called_by in calls.items()
    )
    return load_text(text).library


def _reached(calls: Mapping[str, list[str]], name: str) -> set[str]:
    found: set[str] = set()
    left = list(calls[name])
    while left:
        called = left.pop()
        if called in calls and called not in found:
            found.add(called)
            left.extend(calls[called])
    return found


@pytest.mark.parametrize("seed", range(60))
def test_recursive_is_what_reaches_itself(seed: int) -> None:
    rng = random.Random(seed)
    names = [f"r{at}" for at in range(rng.randint(1, 12))]
    density = rng.uniform(0.5, 2)
    calls = {
        name: rng.choices([*names, "elsewhere"], k=int(rng.random() * 2 * density))
        for name in names
    }
    recursion = Recursion(_library(calls))
    rng.shuffle(names)
    for name in names:
        assert recursion.covers(name) is (name in _reached(calls, name))


def test_what_lies_between_two_circles_is_not_recursive() -> None:
    calls = {"a": ["a", "b"], "b": ["c"], "c": ["c"]}
    recursion = Recursion(_library(calls))
    assert [recursion.covers(name) for name in "abc"] == [True, False, True]


def test_a_long_chain_is_searched_without_recursion() -> None:
    count = 5000
    calls = {f"r{at}": [f"r{(at + 1) % count}"] for at in range(count)}
    assert Recursion(_library(calls)).covers("r0")


class Read(dict[str, nodes.DefineRap]):
    """RAPs that tell which of them were looked at."""

    def __init__(self, raps: Mapping[str, nodes.DefineRap]) -> None:
        super().__init__(raps)
        self.read: set[str] = set()

    def __getitem__(self, name: str) -> nodes.DefineRap:
        self.read.add(name)
        return super().__getitem__(name)

    def __iter__(self) -> Iterator[str]:
        raise AssertionError("all RAPs are looked at")


def test_only_what_can_be_reached_is_read() -> None:
    calls = {"a": ["b"], "b": ["a"], "far": ["a", "farther"], "farther": []}
    library = _library(calls)
    raps = Read(library.raps)
    assert Recursion(msgspec.structs.replace(library, raps=raps)).covers("a")
    assert raps.read == {"a", "b"}


def test_eight_raps_of_the_stdlib_and_the_examples_are_recursive() -> None:
    library = load(["rapc/stdlib", "rapc/examples"]).library
    recursion = Recursion(library)
    assert sum(recursion.covers(name) for name in library.raps) == 8
