"""Mistakes of a world's author are laid at the author's door, with file and line."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from math import nan
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
from rapc.worlds.faults import FaultyWorld, InjectedFault
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
(declare-primitive doze () (okay) :atomic false)
(declare-sensor-datum spotted (?thing))
(declare-sensor-datum weighed ((?kilos number)))
(declare-event :bell ())
(define-rap (rest) (method (primitive (doze))))
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


OFFER = Offer(
    {"look": (1, ("okay",)), "doze": (0, ("okay",))},
    {"spotted": 1, "weighed": 1},
    events={":bell": 0},
)


def ignored(memory: Any, datum: Fact) -> None:
    return None


class Good(World):
    """A world in which nothing is wrong; the others differ in one thing."""

    name = "good"
    kit = Kit(
        OFFER,
        Handlers({"look": looked}, dict.fromkeys(OFFER.data, ignored)),
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
        self.time = max(self.time, to)

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
    return with_kit(
        handlers=Handlers({"look": result}, {"spotted": datum, "weighed": ignored})
    )


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


def waits(**parts: Any) -> type[World]:
    """Return a world that does what it was asked later, if ever."""
    return type("Bad", (Waits,), {"name": "bad", **parts})


class Waits(Good):
    """Takes a request that is not atomic, and sends nothing."""

    def __init__(self, rng: Any, options: Any) -> None:
        super().__init__(rng, options)
        self.time = type(self).time

    time: Any = 0

    def perform(self, ticket: int, request: Fact) -> Any:
        return None

    def messages(self) -> Any:
        return ()


def back(world: Any, ticket: int, request: Fact) -> Any:
    world.time -= 3
    return Reply("okay")


def lame(world: Any, ticket: int, request: Fact) -> Any:
    world.time = "noon"
    return Reply("okay")


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
    "a next time that is none": (waits(next_time=answers("noon")), "the next time"),
    "a next time that is no number": (waits(next_time=answers(nan)), "the next time"),
    "a next time that has been": (
        waits(next_time=answers(1), time=2, advance=answers(None)),
        "will next send something at 1, and it is 2 by now",
    ),
    "a next time at which nothing comes": (
        waits(next_time=answers(0)),
        "said that it would send something at 0, and sent nothing",
    ),
    "a clock that stands still": (
        waits(next_time=answers(5), advance=answers(None)),
        "did not move its clock on to 5",
    ),
    "a clock that goes back": (with_(perform=back), "clock back, from 0 to -3"),
    "a clock that breaks later": (with_(perform=lame), "the time"),
    "no answer where one is declared": (
        with_(perform=answers(None)),
        r"was asked \(look one\) and did not answer it, and it is declared atomic",
    ),
    "a result that nobody declares": (
        with_(perform=answers(Reply("bang"))),
        r"answered \(look one\) with `bang`, .*those are okay",
    ),
    "too much in a datum": (
        sends(Datum(("spotted", "a", "b"))),
        r"sent the datum \(spotted a b\): `spotted` takes 1 argument, not 2",
    ),
    "too little in a reply's datum": (
        with_(perform=answers(Reply("okay", (("spotted",),)))),
        r"`spotted` takes 1 argument, not 0; see `perform`",
    ),
    "a datum of another kind": (
        sends(Datum(("weighed", "heavy"))),
        r"sent the datum \(weighed heavy\): `heavy` is no number",
    ),
    "a datum without a handler": (sends(Datum(("smelt", "a"))), "no handler"),
    "a signal that is not offered": (sends(Signal((":alarm", "a"))), "does not offer"),
    "too much in a signal": (
        sends(Signal((":bell", "a"))),
        "takes no arguments, not 1",
    ),
    "messages that are none": (with_(messages=answers(None)), "what `messages`"),
    "an end that is no text": (with_(ended=answers(True)), "the end"),
    "an end of nothing": (sends(Finished(3, Reply("okay"))), "not under way: 3"),
    "facts that are none": (with_(facts=answers([3])), "a first fact"),
    "no list of facts": (with_(facts=answers(None)), "knows at first"),
    "a handler that returns no result": (
        handlers(answers("bang"), lambda m, d: None),
        "the handler of `look`.* returned `bang`, which is no result of `look`",
    ),
    "a comparator's text": (with_kit(comparators={"by-eye": answers("so")}), "'so'"),
}


@pytest.mark.parametrize("case", TYPES)
def test_answers_of_the_wrong_type_are_the_worlds_fault(case: str) -> None:
    world, said = TYPES[case]
    slow = issubclass(world, Waits)
    with pytest.raises(rapc.PortError, match=said) as caught:
        run(world, "(rest)" if slow else "(compare)")
    assert HERE in caught.value.message


def test_a_run_in_a_broken_world_is_ended_in_its_trace() -> None:
    events: list[Any] = []
    bad = with_(perform=answers(Reply("bang")))
    with pytest.raises(rapc.PortError) as caught:
        rapc.run(rapc.loads(LIBRARY), bad, "(compare)", listeners=[events.append])
    last = events[-1]
    assert (type(last).__name__, last.reason) == ("RunEnded", "broken")
    assert last.because == caught.value.message


def test_results_that_only_the_world_knows_of_are_told_beforehand() -> None:
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


def test_an_offer_is_made_of_what_belongs_into_it() -> None:
    wrong: Any
    for wrong, said in (
        ({"primitives": {"look": 1}}, "a tuple of results for `look`, not 1"),
        ({"primitives": {"look": (1, "okay")}}, "not .1, 'okay'"),
        ({"primitives": {"look": ("okay",)}}, "not .'okay',"),
        ({"data": {"seen": ("a",)}}, "a number of arguments for `seen`"),
        ({"events": {"bell": 0}}, "the name of `bell` in an Offer begins with a colon"),
        ({"skills": {"roll": 0}}, "the name of `roll`"),
        ({"sensors": "look"}, "a tuple of names, not 'look'"),
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
        ({"arguments": {"seen": ()}}, "an Offer has no `seen`"),
    ):
        with pytest.raises(TypeError, match=said):
            Offer(**wrong)


def test_what_is_not_atomic_is_not_declared_atomic() -> None:
    late = with_kit(
        offer=Offer(
            OFFER.primitives, OFFER.data, events=OFFER.events, not_atomic=("look",)
        )
    )
    said = "`look` is not atomic in the world `bad`; declare it with `:atomic false`"
    with pytest.raises(rapc.RefusedError, match=said):
        run(late)


@pytest.mark.parametrize("value", ["soon", -1, nan, None])
def test_a_usual_time_that_is_none_is_the_worlds_fault(value: Any) -> None:
    world: Any = with_(usual_time=answers(value))
    faulty = FaultyWorld(
        world(None, {}), [InjectedFault(("look", "?"), "okay")], seed=0
    )
    with pytest.raises(
        rapc.PortError, match=r"usual time of \(look one\) is"
    ) as caught:
        rapc.run(rapc.loads(LIBRARY), faulty, "(compare)", until=100)
    assert f"see `usual_time` ({HERE}:" in caught.value.message


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
    "breaks:Any": (
        "BEDS = {}\n\nBED = BEDS['one']\n",
        "loaded (breaks.py:3): KeyError",
    ),
    "slips:Any": ("import os\ndef f(:\n", "cannot be loaded (slips.py:2): SyntaxError"),
    "lacks:Any": ("\nimport no_such_module\n", "loaded (lacks.py:2): ModuleNotFound"),
    "offers:Any": (
        "from rapc.world import Offer\n\nOFFER = Offer({'look': (1, 'okay')})\n",
        "loaded (offers.py:3): TypeError: an Offer has a number of arguments and a tup",
    ),
    "quit:Any": (QUIT, "cannot be loaded (quit.py:2): SystemExit: 0"),
    "bare:Bare": (
        "from rapc.world import World\nclass Bare(World): pass\n",
        "does not define",
    ),
    "rapc.worlds.faults:FaultyWorld": ("", "does not define name, kit"),
    "makes:Makes": (
        "import sys\nfrom tests.worlds.test_broken_worlds import Good\n"
        "class Makes(Good):\n    def __init__(self, rng, options): sys.exit(0)\n",
        "cannot be built (makes.py:4): SystemExit: 0",
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
