"""Forged compiled libraries: whatever is in them, they run or are refused."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rapc.compiler.program import Program
from rapc.errors import RefusedError, SavedError
from rapc.library.saved import SavedLibrary, seal
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import read_task_request
from rapc.testing import run as testing
from rapc.testing.run import Case, run_case
from tests.effort import examples

from .saved_libraries import KITCHEN, YesWorld, compiled, program

PAYLOAD = compiled(KITCHEN).split(b"\n", 1)[1]
TREE = json.loads(PAYLOAD)
CYCLES = 60

Path = tuple[int | str, ...]


def _paths(tree: Any, at: Path = ()) -> Iterator[Path]:
    """The places of all values in a tree but the texts of sources."""
    yield at
    if isinstance(tree, list):
        for index, value in enumerate(tree):
            yield from _paths(value, (*at, index))


PATHS = tuple(path for path in _paths(TREE) if path)


def _at(tree: Any, path: Path) -> Any:
    for step in path:
        tree = tree[step]
    return tree


def _use(payload: bytes) -> bool:
    """Do with a payload what commands do with a file; whether it was not refused."""
    refused = ""
    try:
        library = program(seal(payload), "forged")
        run = Interpreter(library, YesWorld(library))
        for goal in ("(push-all ball cube)", "(push-one ball) :priority 1"):
            run.submit(read_task_request(goal))
        run.run(until=500, cycles=CYCLES)
        for tests, linked, name in SavedLibrary(seal(payload), "forged").suites():
            for test in tests:
                run_case(Case(test, Program(linked, name)))
    except (SavedError, RefusedError) as error:
        refused = str(error)
    assert refused.count("\n") == 0
    return refused == ""


@pytest.fixture(autouse=True, scope="module")
def _short_tests() -> Iterator[None]:
    """Let no test that was forged to be endless go on for long."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(testing, "MOST_CYCLES", CYCLES)
        yield


def test_what_was_not_forged_is_not_refused() -> None:
    assert _use(PAYLOAD)


def _nested(depth: int) -> bytes:
    """The library with a `not` in so many others."""
    text = PAYLOAD.decode()
    start = text.index('["Not",["Believe",')
    _, end = json.JSONDecoder().raw_decode(text, start)
    span = json.dumps([TREE[0], 0, 0])
    deep = '["Not",' * depth + text[start:end] + f",{span}]" * depth
    return (text[:start] + deep + text[end:]).encode()


@pytest.mark.parametrize("depth", [150, 900, 100_000])
def test_what_is_nested_too_deeply_is_refused(depth: int) -> None:
    with pytest.raises(SavedError, match=r"nested too deeply|recursion depth"):
        SavedLibrary(seal(_nested(depth)), "forged").look_at_all()


def test_what_is_not_nested_too_deeply_runs() -> None:
    assert _use(_nested(140))


@examples(50)
@given(st.integers(0, len(PAYLOAD) - 1), st.binary(max_size=4), st.integers(0, 4))
def test_bytes_put_in_place_of_others(at: int, new: bytes, old: int) -> None:
    _use(PAYLOAD[:at] + new + PAYLOAD[at + old :])


WORDS = [
    None,
    True,
    "",
    "a b",
    "?",
    "?x",
    "t1",
    ":go",
    "push-one",
    "unknown",
    "\x1b[1m",
]
NUMBERS = [0, -1, 1, 2.0, 1e40, 10**60, -(10**300)]
LISTS = [[], [[]], {}, {"type": "text"}, {"type": "text", "value": "a (b"}]
ODD = st.sampled_from([*WORDS, *NUMBERS, *LISTS]).map(lambda value: [value])


@examples(100)
@given(st.sampled_from(PATHS), st.sampled_from(PATHS) | ODD)
def test_parts_put_in_place_of_others(path: Path, new: Any) -> None:
    part = _at(TREE, new) if isinstance(new, tuple) else new[0]
    tree = json.loads(PAYLOAD)
    _at(tree, path[:-1])[path[-1]] = part
    _use(json.dumps(tree).encode())


@examples(50)
@given(st.sampled_from(PATHS), st.booleans())
def test_parts_left_out_or_put_in_twice(path: Path, twice: bool) -> None:
    tree = json.loads(PAYLOAD)
    parts = _at(tree, path[:-1])
    if twice:
        parts.insert(path[-1], parts[path[-1]])
    else:
        del parts[path[-1]]
    _use(json.dumps(tree).encode())
