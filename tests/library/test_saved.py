"""Compiled libraries: what goes in comes out again, and runs as its sources do."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import pytest

import rapc
from rapc import host
from rapc.base.version import VERSION
from rapc.compiler.program import Program
from rapc.errors import LoadError, SavedError
from rapc.ir.nodes import DefineRap, Node
from rapc.library import saved as saved_module
from rapc.library.loader import load_text
from rapc.library.saved import SavedLibrary, Suite, encode, seal
from rapc.testing.run import Case, Outcome, run_case
from tests.effort import first

from .saved_libraries import (
    KITCHEN,
    Recorded,
    YesWorld,
    compiled,
    fields,
    program,
    saved,
    suites,
)

CHECKOUT = Path(__file__).parents[2]
EXAMPLES = sorted((CHECKOUT / "examples").glob("*.rap"))
FOLDERS = [CHECKOUT / "stdlib" / "truck", CHECKOUT / "tests" / "rap"]


@pytest.mark.parametrize("path", [KITCHEN, *EXAMPLES, *FOLDERS], ids=lambda p: p.name)
def test_what_goes_in_comes_out_again(path: Path) -> None:
    source = host.load(path)
    data = saved(source)
    again = SavedLibrary(data, "file")
    empty = {"tests": b"[]", "forms": b"[]"}
    assert fields(again.library) == {**fields(source.program.library), **empty}
    assert again.name == source.name
    assert saved(host.load(path)) == data


LANGUAGE = "tests.rap.language_world"


def _outcome(case: Case) -> tuple[Outcome, list[bytes]]:
    recorded = Recorded()
    return run_case(case, 3, coverage=recorded, modules=[LANGUAGE]), recorded.trace


@pytest.mark.parametrize("path", first(1, [KITCHEN, *FOLDERS]), ids=lambda p: p.name)
def test_tests_run_as_they_do_from_sources(path: Path) -> None:
    together = suites(path)
    data = saved(host.load(path), together)
    ran = 0
    pairs = zip(together, SavedLibrary(data, "file").suites(), strict=True)
    for one, other in pairs:
        library = Program(one.library, one.name)
        same_library = Program(other.library, other.name)
        for test, same in zip(one.tests, other.tests, strict=True):
            outcome, trace = _outcome(Case(test, library))
            again, same_trace = _outcome(Case(same, same_library))
            assert trace == same_trace
            assert (outcome.status, outcome.failures) == (again.status, again.failures)
            ran += 1
    assert ran > 0


def _traced(library: Program, seed: int) -> list[bytes]:
    recorded = Recorded()
    run = rapc.Interpreter(library, rapc.open_world("truck", seed=seed), seed)
    run.listen(recorded)
    run.submit("(rock-order red 1)")
    run.run(until=400)
    return recorded.trace


def test_a_run_in_a_world_has_the_same_trace(tmp_path: Path) -> None:
    path = CHECKOUT / "examples" / "rock-order.rap"
    file = tmp_path / "rocks"
    file.write_bytes(compiled(path))
    assert _traced(rapc.load(file).program, 5) == _traced(rapc.load(path).program, 5)


@pytest.mark.slow
def test_another_process_and_hash_seed_make_the_same_bytes() -> None:
    code = (
        "import sys; from tests.library.saved_libraries import *; "
        "sys.stdout.buffer.write(compiled(KITCHEN))"
    )
    made = [
        subprocess.run(
            [sys.executable, "-c", code],
            cwd=CHECKOUT,
            env={"PYTHONHASHSEED": seed, "PYTHONPATH": str(CHECKOUT)},
            capture_output=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    ]
    assert made[0] == made[1]
    assert made[0].startswith(f"rapc-library {saved_module.FORMAT} {VERSION} ".encode())


def test_a_plan_can_be_added_to_a_compiled_library(tmp_path: Path) -> None:
    file = tmp_path / "kitchen.rapc"
    file.write_bytes(compiled(KITCHEN))
    library = rapc.load(file)
    more = library.extend("(define-rap (both) (method (task-net)))")
    assert (*library.raps, "both") == more.raps


def test_only_what_is_asked_for_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    library = SavedLibrary(compiled(KITCHEN), "file").library
    read: list[str] = []
    decode = saved_module._decode

    def noted(data: memoryview, kind: object) -> object:
        made = decode(data, kind)
        if isinstance(made, DefineRap):
            read.append(made.name)
        return made

    monkeypatch.setattr(saved_module, "_decode", noted)
    assert list(library.raps) == ["push-all", "push-one", "weigh"]
    assert "push-one" in library.raps
    assert read == []
    assert library.raps["push-one"] is library.raps["push-one"]
    assert read == ["push-one"]


# --- what is refused ----------------------------------------------------------------

GOOD = compiled(KITCHEN)
HEAD, PAYLOAD = GOOD.split(b"\n", 1)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "is not a compiled library"),
        (b"\x89PNG\r\n", "is not a compiled library"),
        (GOOD[:8], "is not a compiled library"),
        (GOOD[:40], "is damaged: its first line is incomplete"),
        (GOOD[:-1], "is damaged: its content does not match its checksum"),
        (GOOD + b"\n", "is damaged: its content does not match its checksum"),
        (HEAD + b"\n", "is damaged: its content does not match its checksum"),
        (GOOD.replace(b"push", b"pull", 1), "is damaged: its content does not match"),
        (seal(PAYLOAD, version="9.9"), "was compiled by rapc 9.9, format "),
        (seal(PAYLOAD, form=99), f"was compiled by rapc {VERSION}, format 99; this is"),
        (seal(b""), "is invalid: "),
        (seal(b"[]"), "is invalid: expected `array` of "),
        (seal(b"[" * 100_000), "is invalid: "),
        (
            seal(PAYLOAD.replace(b'"push-all"', b'"push all"')),
            "'push all' is not a word of the language",
        ),
        (seal(PAYLOAD.replace(b",[0],", b",[1],", 1)), "has no source"),
        (seal(PAYLOAD.replace(b",[0],", b",[0,0],", 1)), "has a duplicate source"),
    ],
)
def test_what_is_no_library_of_this_rapc_is_refused(data: bytes, said: str) -> None:
    with pytest.raises(SavedError) as caught:
        SavedLibrary(data, "odd.rapc").look_at_all()
    assert str(caught.value).startswith("`odd.rapc` ")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_rap_that_cannot_be_run_is_refused_before_the_first_cycle() -> None:
    data = seal(PAYLOAD.replace(b'["Goal","push-one"', b'["Goal","push-none"'))
    library = program(data, "odd.rapc")
    run = rapc.Interpreter(library, YesWorld(library))
    said = "in `push-all`: unknown RAP `push-none`"
    with pytest.raises(SavedError, match=said):
        run.submit("(push-all a b)")


def test_what_was_silenced_and_cannot_be_run_is_not_compiled() -> None:
    text = """(define-rap (go) ; rapc: ignore[undeclared-predicate] it may come yet
      (succeed (nowhere declared)))"""
    with pytest.raises(SavedError, match="in `go`: unknown predicate `nowhere`"):
        saved(host.checked(load_text(text), "go"))


def test_a_name_that_cannot_be_printed_is_refused() -> None:
    loaded = load_text("(define-rap (go) (method (task-net)))", "a\x1b[2Jb.rap")
    with pytest.raises(SavedError, match="a file name that cannot be printed"):
        saved(host.checked(loaded, "go"))
    odd = seal(PAYLOAD.replace(b'kitchen.rap"', b'kitchen\\u001b.rap"'))
    with pytest.raises(SavedError, match="a file name that cannot be printed"):
        SavedLibrary(odd, "odd.rapc")


def test_a_compiled_library_is_not_compiled_again() -> None:
    with pytest.raises(SavedError, match="is already a compiled library"):
        encode(SavedLibrary(GOOD, "file").library, "kitchen")


def test_sources_are_wanted_where_something_is_to_be_checked(tmp_path: Path) -> None:
    file = tmp_path / "kitchen.rapc"
    file.write_bytes(GOOD)
    said = "expected a source file, not the compiled library"
    with pytest.raises(LoadError, match=said):
        rapc.check(file)
    with pytest.raises(LoadError, match=said):
        rapc.load(file, KITCHEN)


def test_suites_of_one_library_read_it_once(monkeypatch: pytest.MonkeyPatch) -> None:
    linked: list[tuple[int, ...]] = []
    link = SavedLibrary._link

    def noted(self: SavedLibrary, places: tuple[int, ...]) -> object:
        linked.append(places)
        return link(self, places)

    monkeypatch.setattr(SavedLibrary, "_link", noted)
    library = host.load(KITCHEN)
    suite = Suite((), library.program.library, "again")
    data = saved(library, [suite] * 2000)
    linked.clear()
    assert len(list(SavedLibrary(data, "file").suites())) == 2000
    assert len(linked) == 1


SHAPE = "030b96a1c267f56e"
"""The checksum of all kinds of nodes in format 14: another one, another format."""


def test_another_shape_of_nodes_is_another_format() -> None:
    shape = hashlib.sha256(_shape().encode()).hexdigest()[:16]
    assert (saved_module.FORMAT, shape) == (14, SHAPE)


def _shape() -> str:
    """The kinds of nodes with their fields and types, as they are written."""
    kinds: list[type] = [Node]
    for kind in kinds:
        kinds.extend(kind.__subclasses__())
    rows = (f"{kind.__name__}{kind.__annotations__}" for kind in kinds)
    return "\n".join(sorted(rows))
