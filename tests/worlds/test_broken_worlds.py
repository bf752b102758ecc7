"""Mistakes of a world's author are laid at the author's door, with file and line."""

from __future__ import annotations

import itertools
from math import nan
from pathlib import Path
from typing import Any

import pytest

import rapc
from rapc.runtime import held_world
from rapc.world import (
    Fact,
    Offer,
    Reply,
    Text,
)
from rapc.worlds.faults import FaultyWorld, InjectedFault
from tests.cli.command import rapc as command
from tests.worlds.broken_worlds import (
    ARITIES,
    HERE,
    LIBRARY,
    OFFER,
    RAISING,
    TYPES,
    Good,
    Waits,
    answers,
    boom,
    handlers,
    ignored,
    run,
    with_,
    with_kit,
)


def test_nothing_is_wrong_with_the_good_one() -> None:
    for task in ("(compare)", "(weigh a)"):
        assert run(Good, task).succeeded


@pytest.mark.parametrize("case", RAISING)
def test_exception_of_an_author_has_its_position(case: str) -> None:
    world, whose = RAISING[case]
    with pytest.raises(rapc.PortError) as caught:
        run(world)
    assert caught.value.message.startswith(f"{whose} failed at {HERE}:")
    assert caught.value.__cause__ is not None


class Mute(ValueError):
    """An error that cannot be printed."""

    def __init__(self, ends: BaseException) -> None:
        self.ends = ends

    def __str__(self) -> str:
        raise self.ends


@pytest.mark.parametrize("ends", [KeyError("pillow"), SystemExit(0)])
def test_unprintable_error_is_reported_with_its_position(
    ends: BaseException,
) -> None:
    def break_down(*args: Any) -> Any:
        raise Mute(ends)

    name = type(ends).__name__
    for part, said in (("perform", f"failed at test_{HERE}"), ("__init__", "refuses")):
        with pytest.raises(rapc.Error) as caught:
            run(with_(**{part: break_down}))
        assert said in caught.value.message
        assert f"(it cannot be printed: {name})" in caught.value.message


def test_a_solver_and_a_default_function_are_told_of_too() -> None:
    for world, task, whose in (
        (with_kit(solvers={"stuck": boom}), "(stuck a)", "the solver of `stuck`"),
        (
            with_kit(functions={"usual-weight": boom}),
            "(weigh a)",
            "the function `usual-weight`",
        ),
    ):
        with pytest.raises(rapc.PortError, match=f"{whose} failed at {HERE}:"):
            run(world, task)


def test_forbidden_fact_is_a_fault_of_the_handler() -> None:
    def assert_nonsense(memory: Any, request: Fact, result: str) -> None:
        memory.assert_fact("nonsense", "a")

    with pytest.raises(
        rapc.PortError, match=f"`look` failed at test_{HERE}:.*nonsense"
    ):
        run(handlers(assert_nonsense, lambda m, d: None))


@pytest.mark.parametrize("case", ARITIES)
def test_code_with_wrong_arguments_is_refused_before_the_run(case: str) -> None:
    world, said = ARITIES[case]
    with pytest.raises(rapc.RefusedError, match=said) as caught:
        run(world)
    assert len(caught.value.reasons) == 1
    assert HERE in caught.value.message or case == "a text"


@pytest.mark.parametrize("case", TYPES)
def test_answers_of_the_wrong_type_are_the_worlds_fault(case: str) -> None:
    world, said = TYPES[case]
    slow = issubclass(world, Waits)
    with pytest.raises(rapc.PortError, match=said) as caught:
        run(world, "(rest)" if slow else "(compare)")
    assert HERE in caught.value.message


@pytest.mark.parametrize("place", [nan, True, None, "A b", "5", Text("\ud800")])
def test_handler_with_an_invalid_value_is_named(place: Any) -> None:
    def goes(memory: Any, request: Fact, result: str) -> None:
        memory.arrive(place)

    said = f"the handler of `look` failed at test_{HERE}:.*is not a symbol"
    with pytest.raises(rapc.PortError, match=said):
        run(handlers(goes, ignored))


@pytest.mark.parametrize("call", ["introduce", "fix_cardinality", "assert_fact"])
def test_handler_storing_an_invalid_symbol_is_named(call: str) -> None:
    def stores(memory: Any, request: Fact, result: str) -> None:
        given = {
            "introduce": ("A b", "box", "shelf"),
            "fix_cardinality": ("A b",),
            "assert_fact": ("seen", "A b"),
        }
        getattr(memory, call)(*given[call])

    said = f"the handler of `look` failed at test_{HERE}:.*`A b` is not a symbol"
    with pytest.raises(rapc.PortError, match=said):
        run(handlers(stores, ignored))


def test_world_without_end_of_first_facts_is_blamed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(held_world, "MOST_FACTS", 1000)
    endless = with_(facts=lambda world: itertools.repeat(("seen", "mouse")))
    with pytest.raises(rapc.PortError, match=r"more than 1000 first facts.*`facts`"):
        run(endless)


def test_handler_omitting_a_value_is_named_with_the_declaration() -> None:
    def paints(memory: Any, request: Fact, result: str) -> None:
        memory.assert_fact("colour", request[1])

    said = (
        f"the handler of `look` failed at test_{HERE}:.*: .colour one. has no "
        r"value for `.colour .thing .colour.`, declared at <text>:\d+:1; a handler"
    )
    with pytest.raises(rapc.PortError, match=said):
        run(handlers(paints, ignored))


def test_world_with_incomplete_initial_facts_is_refused() -> None:
    short = with_(facts=answers([("colour", "mouse")]))
    said = r"<text>:\d+:\d+: `.colour .thing .colour.` takes all .*colour mouse."
    with pytest.raises(rapc.RefusedError, match=said):
        run(short)


def test_a_run_in_a_broken_world_is_ended_in_its_trace() -> None:
    events: list[Any] = []
    bad = with_(perform=answers(Reply("bang")))
    with pytest.raises(rapc.PortError) as caught:
        rapc.run(rapc.loads(LIBRARY), bad, "(compare)", listeners=[events.append])
    last = events[-1]
    assert (type(last).__name__, last.reason) == ("RunEnded", "broken")
    assert last.because == caught.value.message


def test_results_missing_in_the_library_are_reported_before_the_run() -> None:
    more = with_kit(
        offer=Offer(
            {**OFFER.primitives, "look": (1, ("okay", "dark"))},
            OFFER.data,
            events=OFFER.events,
        )
    )
    with pytest.raises(rapc.RefusedError, match="answer `look` with `dark`, not decl"):
        run(more)


def test_a_handler_may_give_another_result() -> None:
    library = LIBRARY.replace("(look ?thing) (okay)", "(look ?thing) (okay dark)")
    library = library.replace("look (?thing) (okay)", "look (?thing) (okay dark)")

    def sees_nothing(memory: Any, request: Fact, result: str) -> str:
        return "dark"

    world = handlers(sees_nothing, lambda m, d: None)
    events: list[Any] = []
    rapc.run(rapc.loads(library), world, "(watch one)", listeners=[events.append])
    ended = [e for e in events if type(e).__name__ == "PrimitiveEnded"]
    assert {e.result for e in ended} == {"dark"}


@pytest.mark.parametrize("value", ["a text", ["a text"], None])
def test_a_solver_returns_methods(value: Any) -> None:
    world = with_kit(solvers={"stuck": answers(value)})
    with pytest.raises(rapc.PortError, match=r"the solver of `stuck`.* returned"):
        run(world, "(stuck a)")


def test_exception_of_a_listener_reaches_the_host() -> None:
    with pytest.raises(KeyError, match="pillow"):
        rapc.run(rapc.loads(LIBRARY), Good, "(compare)", listeners=[boom])


def test_non_atomic_primitive_is_not_declared_atomic() -> None:
    late = with_kit(
        offer=Offer(
            OFFER.primitives, OFFER.data, events=OFFER.events, not_atomic=("look",)
        )
    )
    said = "`look` is not atomic in the world `bad`; declare it with `:atomic false`"
    with pytest.raises(rapc.RefusedError, match=said):
        run(late)


@pytest.mark.parametrize("value", ["soon", -1, nan, None])
def test_invalid_usual_time_is_a_fault_of_the_world(value: Any) -> None:
    world: Any = with_(usual_time=answers(value))
    faulty = FaultyWorld(
        world(None, {}), [InjectedFault(("look", "?"), "okay")], seed=0
    )
    with pytest.raises(
        rapc.PortError, match=r"usual time of \(look one\) is"
    ) as caught:
        rapc.run(rapc.loads(LIBRARY), faulty, "(compare)", until=100)
    assert f"see `usual_time` ({HERE}:" in caught.value.message


QUIT = "import sys\nsys.exit(0)\n"

WORLDS = {
    "breaks:Any": (
        "BEDS = {}\n\nBED = BEDS['one']\n",
        "loaded (breaks.py:3): KeyError",
    ),
    "slips:Any": ("import os\ndef f(:\n", "cannot be loaded (slips.py:2): SyntaxError"),
    "lacks:Any": ("\nimport no_such_module\n", "loaded (lacks.py:2): ModuleNotFound"),
    "offers:Any": (
        "from rapc.world import Offer\n\nOFFER = Offer({'look': (1, 'okay')})\n",
        "loaded (offers.py:3): TypeError: expected a number of arguments and a tup",
    ),
    "quit:Any": (QUIT, "cannot be loaded (quit.py:2): SystemExit: 0"),
    "bare:Bare": (
        "from rapc.world import World\nclass Bare(World): pass\n",
        "does not define",
    ),
    "rapc.worlds.faults:FaultyWorld": ("", "does not define name, kit"),
    "makes:Makes": (
        "import sys\nfrom tests.worlds.broken_worlds import Good\n"
        "class Makes(Good):\n    def __init__(self, rng, options): sys.exit(0)\n",
        "cannot be built (makes.py:4): SystemExit: 0",
    ),
    "plays:Plays": (
        "import sys\nfrom tests.worlds.broken_worlds import Good\n"
        "class Plays(Good):\n    def perform(self, ticket, request): sys.exit(0)\n",
        "the world `good` failed at plays.py:4: SystemExit: 0",
    ),
    "shuts:Shuts": (
        "import sys\nfrom tests.worlds.broken_worlds import Good\n"
        "class Shuts(Good):\n"
        "    def perform(self, ticket, request):\n"
        "        sys.stdout.close()\n"
        "        return super().perform(ticket, request)\n",
        "the world's code closed standard output",
    ),
}


@pytest.mark.parametrize("name", WORLDS)
def test_the_command_line_says_it_in_a_line_with_status_2(
    name: str, tmp_path: Path
) -> None:
    text, said = WORLDS[name]
    (tmp_path / f"{name.partition(':')[0]}.py").write_text(text)
    (tmp_path / "a.rap").write_text(LIBRARY)
    checkout = Path(__file__).parents[2]
    done = command(
        *("run", "a.rap", "--world", name, "--task", "(compare)", "-q"),
        cwd=tmp_path,
        PYTHONPATH=str(checkout),
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: the world")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1


def test_name_ending_the_process_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "ends.py").write_text(
        "from rapc.world import Offer, Kit, World\n"
        "class Name(str):\n"
        "    __hash__ = str.__hash__\n"
        "    def __eq__(self, other):\n"
        "        raise SystemExit(0)\n"
        "class Any(World):\n"
        "    name = 'any'\n"
        "    kit = Kit(Offer({Name('look'): (0, ('okay',))}))\n"
        "    def __init__(self, rng, options): ...\n"
        "    now = perform = next_time = advance = messages = lambda *given: None\n"
    )
    (tmp_path / "a.rap").write_text(
        "(declare-primitive look () (okay))\n"
        "(define-rap (go) (method (primitive (look))))\n"
    )
    words = ("run", "a.rap", "--world", "ends:Any", "--task", "(go)")
    done = command(*words, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: ends.py:5 ended the process: SystemExit: 0\n"
