"""Mistakes of a world's author are laid at the author's door, with file and line."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

import rapc
from rapc.runtime.authors import takes
from rapc.world import (
    Datum,
    Fact,
    Finished,
    Handlers,
    Kit,
    Offer,
    Option,
    Reply,
    Signal,
    World,
)
from tests.cli.command import rapc as command

LIBRARY = """
(declare-memory-proposition seen (?thing))
(declare-memory-property weight (?thing ?kilos) usual-weight)
(declare-memory-property class (?item ?class ?value) false)
(declare-memory-property colour (?thing ?colour) unknown)
(declare-memory-property location (?item ?place) unknown)
(declare-memory-function heavy (?thing))
(declare-indistinct-class box by-eye)
(declare-primitive look (?thing) (okay))
(declare-sensor-datum spotted (?thing))
(define-rap (watch ?thing)
  (succeed (seen ?thing))
  (method (context (and (not (heavy ?thing)) (n= ?thing (nobody))))
    (primitive (look ?thing))))
(declare-memory-function nobody ())
(define-rap (weigh ?thing) (succeed (weight ?thing 3)))
(define-rap (stuck ?thing) (succeed (seen ?thing)))
(define-rap (compare)
  (method (task-net (t1 (watch one) (for t2)) (t2 (watch two)))))
"""


def looked(memory: Any, request: Fact, result: str) -> None:
    memory.assert_fact("seen", request[1])
    memory.expire()
    memory.arrive("shelf")
    item = memory.introduce(f"sensed-{request[1]}", "box", "shelf")
    memory.assert_fact("colour", item, "red")


class Good(World):
    """A world in which nothing is wrong; the others differ in one thing."""

    name = "good"
    kit = Kit(
        Offer({"look": (1, ("okay",))}, {"spotted": 1}),
        Handlers({"look": looked}, {"spotted": lambda memory, datum: None}),
        functions={
            "heavy": lambda memory, thing: False,
            "nobody": lambda memory: "nobody",
            "usual-weight": lambda memory, index: 3,
        },
        solvers={"stuck": lambda goal, memory: []},
        comparators={"by-eye": lambda one, other: 10},
    )

    def __init__(self, rng: Any, options: Any) -> None:
        self.time: Any = 0
        self.sent: Any = [Datum(("spotted", "mouse"))]

    def now(self) -> Any:
        return self.time

    def perform(self, ticket: int, request: Fact) -> Any:
        self.time += 1
        return Reply("okay")

    def next_time(self) -> Any:
        return None

    def advance(self, to: Any) -> None:
        self.time = to

    def messages(self) -> Any:
        sent, self.sent = self.sent, ()
        return sent


def boom(*args: Any) -> Any:
    raise KeyError("pillow")


def leave(*args: Any) -> Any:
    sys.exit(0)


def stop(*args: Any) -> Any:
    raise GeneratorExit


def one(memory: Any) -> Any:
    return None


def with_(**parts: Any) -> type[World]:
    """Return a world that differs from the good one in some methods."""
    return type("Bad", (Good,), {"name": "bad", **parts})


def with_kit(**fields: Any) -> type[World]:
    """Return a world that differs from the good one in some fields of its kit."""
    old = {name: getattr(Good.kit, name) for name in Kit.__struct_fields__}
    for name, value in fields.items():
        old[name] = {**old[name], **value} if isinstance(value, Mapping) else value
    return with_(kit=Kit(**old))


def handlers(result: Any = looked, datum: Any = boom) -> type[World]:
    return with_kit(handlers=Handlers({"look": result}, {"spotted": datum}))


def run(world: type[World], task: str = "(compare)") -> rapc.RunResult:
    return rapc.run(rapc.loads(LIBRARY), world, task, until=100)


def test_nothing_is_wrong_with_the_good_one() -> None:
    for task in ("(compare)", "(weigh a)"):
        assert run(Good, task).succeeded


HERE = Path(__file__).name

RAISING = {
    "the first time": (with_(now=boom), "the world `bad`"),
    "facts": (with_(facts=boom), "the world `bad`"),
    "perform": (with_(perform=boom), "the world `bad`"),
    "exit in perform": (with_(perform=leave), "the world `bad`"),
    "any end in messages": (with_(messages=stop), "the world `bad`"),
    "messages": (with_(messages=boom), "the world `bad`"),
    "ended": (with_(ended=boom), "the world `bad`"),
    "a handler": (handlers(boom, lambda m, d: None), "the handler of `look`"),
    "a datum's handler": (handlers(), "the handler of the datum `spotted`"),
    "exit in a handler": (handlers(leave, lambda m, d: None), "the handler of `look`"),
    "a function": (with_kit(functions={"heavy": boom}), "the function `heavy`"),
    "a comparator": (with_kit(comparators={"by-eye": boom}), "the comparator `by-eye`"),
}


@pytest.mark.parametrize("case", RAISING)
def test_what_an_author_raises_is_told_with_its_place(case: str) -> None:
    world, whose = RAISING[case]
    with pytest.raises(rapc.PortError) as caught:
        run(world)
    assert caught.value.message.startswith(f"{whose} failed at {HERE}:")
    assert caught.value.__cause__ is not None


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


def test_a_fact_that_may_not_be_asserted_is_the_handlers_fault() -> None:
    def assert_nonsense(memory: Any, request: Fact, result: str) -> None:
        memory.assert_fact("nonsense", "a")

    with pytest.raises(rapc.PortError, match=f"`look` failed at {HERE}:.*nonsense"):
        run(handlers(assert_nonsense, lambda m, d: None))


ARITIES = {
    "perform": (with_(perform=lambda self: None), "`perform`"),
    "messages": (with_(messages=lambda self, more: ()), "`messages`"),
    "a handler": (handlers(one), "the handler of `look` .*called with 3"),
    "a function": (with_kit(functions={"heavy": one}), "the function `heavy`"),
    "a default": (with_kit(functions={"usual-weight": one}), "`usual-weight`.*with 2"),
    "a solver": (with_kit(solvers={"stuck": one}), "the solver of `stuck`"),
    "a comparator": (with_kit(comparators={"by-eye": one}), "comparator `by-eye`"),
    "a text": (with_kit(functions={"heavy": "no"}), "`heavy` is no function"),
}


@pytest.mark.parametrize("case", ARITIES)
def test_code_that_takes_other_arguments_is_refused_beforehand(case: str) -> None:
    world, said = ARITIES[case]
    with pytest.raises(rapc.RefusedError, match=said) as caught:
        run(world)
    assert len(caught.value.reasons) == 1
    assert HERE in caught.value.message or case == "a text"


class Sends(Good):
    """Sends a message once."""

    message: Any = None

    def messages(self) -> Any:
        sent, self.sent = self.sent, ()
        return [self.message] if sent else ()


def sends(message: Any) -> type[World]:
    return type("Bad", (Sends,), {"name": "bad", "message": message})


def answers(value: Any) -> Callable[..., Any]:
    return lambda *args: value


NONE: Any = None
NAME: Any = "a"
NO_DATA: Any = ("spotted",)

TYPES: dict[str, tuple[type[World], str]] = {
    "a text as reply": (with_(perform=answers("okay")), r"the reply to \(look one\)"),
    "no result": (with_(perform=answers(Reply(NONE))), "the reply"),
    "data that are none": (with_(perform=answers(Reply("okay", NONE))), "the reply"),
    "a datum that is none": (
        with_(perform=answers(Reply("okay", NO_DATA))),
        "the reply",
    ),
    "a number of messages": (with_(messages=answers(3)), "what `messages` returns"),
    "a text as message": (sends("spotted"), "a message"),
    "an empty signal": (sends(Signal(())), "a message"),
    "an empty datum": (sends(Datum(())), "a message"),
    "a strange ticket": (sends(Finished(NAME, Reply("okay"))), "not under way: 'a'"),
    "a time that is none": (with_(now=answers("noon")), "the time"),
    "a next time that is none": (
        with_(next_time=answers("noon"), perform=answers(None)),
        "the next time",
    ),
    "facts that are none": (with_(facts=answers([3])), "a first fact"),
    "a comparator's text": (with_kit(comparators={"by-eye": answers("so")}), "'so'"),
}


@pytest.mark.parametrize("case", TYPES)
def test_answers_of_the_wrong_type_are_the_worlds_fault(case: str) -> None:
    world, said = TYPES[case]
    with pytest.raises(rapc.PortError, match=said):
        run(world)


@pytest.mark.parametrize("value", ["a text", ["a text"], None])
def test_a_solver_returns_methods(value: Any) -> None:
    world = with_kit(solvers={"stuck": answers(value)})
    with pytest.raises(rapc.PortError, match="what the solver of `stuck`"):
        run(world, "(stuck a)")


def test_what_a_listener_raises_is_the_hosts_own() -> None:
    with pytest.raises(KeyError, match="pillow"):
        rapc.run(rapc.loads(LIBRARY), Good, "(compare)", listeners=[boom])


def test_a_kit_is_made_of_what_belongs_into_it() -> None:
    wrong: Any = 3
    made: Any
    for made in (
        lambda: Kit(wrong),
        lambda: Kit(Offer(), wrong),
        lambda: Kit(options=(wrong,)),
        lambda: Kit(options=(Option("a", "colour", 1, "", ""),)),
    ):
        with pytest.raises(TypeError, match="of a Kit"):
            made()


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


QUIT = "import sys\nsys.exit(0)\n"

WORLDS = {
    "quit:Any": (QUIT, "cannot be loaded: SystemExit: 0"),
    "bare:Bare": (
        "from rapc.world import World\nclass Bare(World): pass\n",
        "does not define",
    ),
    "rapc.worlds.faults:FaultyWorld": ("", "does not define name, kit"),
    "makes:Makes": (
        "import sys\nfrom tests.worlds.test_broken_worlds import Good\n"
        "class Makes(Good):\n    def __init__(self, rng, options): sys.exit(0)\n",
        "cannot be built: SystemExit: 0",
    ),
    "plays:Plays": (
        "import sys\nfrom tests.worlds.test_broken_worlds import Good\n"
        "class Plays(Good):\n    def perform(self, ticket, request): sys.exit(0)\n",
        "the world `good` failed at plays.py:4: SystemExit: 0",
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
