"""A world in which nothing is wrong, and others that differ from it in one thing."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from math import nan
from pathlib import Path
from typing import Any

import rapc
from rapc.world import (
    Datum,
    Fact,
    Finished,
    Handlers,
    Kit,
    Offer,
    Reply,
    Signal,
    Text,
    World,
)

LIBRARY = """
(declare-memory-proposition seen (?thing))
(declare-memory-function usual-weight (?index))
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


def end(*args: Any) -> Any:
    raise StopIteration


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


HERE = Path(__file__).name


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


# --- what may be wrong ------------------------------------------------------------

RAISING = {
    "the first time": (with_(now=boom), "the world `bad`"),
    "facts": (with_(facts=boom), "the world `bad`"),
    "the end of an iterator in facts": (with_(facts=end), "the world `bad`"),
    "facts of a generator": (
        with_(facts=lambda world: (boom() for _ in range(1))),
        "the world `bad`",
    ),
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


ARITIES = {
    "perform": (with_(perform=lambda self: None), "`perform`"),
    "messages": (with_(messages=lambda self, more: ()), "`messages`"),
    "a handler": (
        handlers(one),
        "the handler of `look` .*called with 3 arguments .memory, request, result.",
    ),
    "a function": (with_kit(functions={"heavy": one}), "the function `heavy`"),
    "a default": (with_kit(functions={"usual-weight": one}), "`usual-weight`.*with 2"),
    "a solver": (with_kit(solvers={"stuck": one}), "the solver of `stuck`"),
    "a comparator": (with_kit(comparators={"by-eye": one}), "comparator `by-eye`"),
    "a text": (with_kit(functions={"heavy": "no"}), "`heavy` is no function"),
}


NONE: Any = None
NAME: Any = "a"
TICKETS: Any = [1]
NO_DATA: Any = ("spotted",)

TYPES: dict[str, tuple[type[World], str]] = {
    "a text as reply": (
        with_(perform=answers("okay")),
        r"the reply to \(look one\) of .*`'okay'`, not a `Reply` whose data are each a",
    ),
    "no result": (with_(perform=answers(Reply(NONE))), "the reply"),
    "data that are none": (with_(perform=answers(Reply("okay", NONE))), "the reply"),
    "a datum that is none": (
        with_(perform=answers(Reply("okay", NO_DATA))),
        "the reply",
    ),
    "a number of messages": (
        with_(messages=answers(3)),
        "what `messages` returns of .* is `3`, not a list of messages",
    ),
    "a text as message": (sends("spotted"), "a message .*, not a `Datum` or"),
    "an empty signal": (sends(Signal(())), "a message"),
    "a signal with an odd number": (sends(Signal((":bell",), (), -1)), "the number"),
    "an empty datum": (sends(Datum(())), "a message"),
    "a strange ticket": (sends(Finished(NAME, Reply("okay"))), "not under way: 'a'"),
    "a time too large to be moved on": (with_(now=answers(1e308)), "from 0 to 10"),
    "a next time too large to be reached": (
        waits(next_time=answers(1e308)),
        "the next time .*, not a number from 0 to 10",
    ),
    "an odd symbol in a datum": (sends(Datum(("spotted", "A b ( ;"))), "a message"),
    "a control character in a datum": (
        sends(Datum(("spotted", "a\x1b[2J"))),
        "a message",
    ),
    "a variable in a datum": (sends(Datum(("spotted", "?thing"))), "a message"),
    "a number written as text": (sends(Datum(("spotted", "5"))), "a message"),
    "a datum that holds no number": (sends(Datum(("weighed", nan))), "a message"),
    "a half character in a text": (
        sends(Datum(("spotted", Text("\ud800")))),
        "a message",
    ),
    "an odd symbol in a signal": (sends(Signal((":bell\n",))), "a message"),
    "an odd symbol in a reply": (
        with_(perform=answers(Reply("okay", (("spotted", "A"),)))),
        "the reply",
    ),
    "an odd symbol in a fact": (with_(facts=answers([("seen", "A b")])), "first fact"),
    "a ticket that is a list": (
        sends(Finished(TICKETS, Reply("okay"))),
        r"not under way: \[1\]",
    ),
    "a time that is none": (
        with_(now=answers("noon")),
        r"the time .*, not a number from 0 to 10\^15;",
    ),
    "a next time that is none": (
        waits(next_time=answers("noon")),
        r"the next time .*, not a number from 0 to 10\^15, `None` or `NOT_KNOWN`",
    ),
    "a next time that is no number": (waits(next_time=answers(nan)), "the next time"),
    "a next time that has been": (
        waits(next_time=answers(1), time=2, advance=answers(None)),
        "announces its next message for time 1, but the time is 2",
    ),
    "a next time at which nothing comes": (
        waits(next_time=answers(0)),
        "announced a message for time 0, but sent none",
    ),
    "a clock that stands still": (
        waits(next_time=answers(5), advance=answers(None)),
        "did not move its clock to 5",
    ),
    "a clock that goes back": (with_(perform=back), "clock back, from 0 to -3"),
    "a clock that breaks later": (with_(perform=lame), "the time"),
    "no answer where one is declared": (
        with_(perform=answers(None)),
        r"was asked \(look one\) and did not answer it, and it is declared atomic",
    ),
    "a result that nobody declares": (
        with_(perform=answers(Reply("bang"))),
        r"ended \(look one\) with `bang`, .*expected one of okay",
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
        r"sent the datum \(weighed heavy\): `heavy` is not a value of kind number",
    ),
    "a datum without a handler": (sends(Datum(("smelt", "a"))), "no handler"),
    "a signal that is not offered": (sends(Signal((":alarm", "a"))), "does not offer"),
    "too much in a signal": (
        sends(Signal((":bell", "a"))),
        "takes no arguments, not 1",
    ),
    "messages that are none": (with_(messages=answers(None)), "what `messages`"),
    "an end that is no text": (
        with_(ended=answers(True)),
        "the end .*, not a text or `None`",
    ),
    "an end of nothing": (sends(Finished(3, Reply("okay"))), "not under way: 3"),
    "facts that are none": (
        with_(facts=answers([3])),
        "a first fact .* is `3`, not a tuple of a name and its arguments",
    ),
    "no list of facts": (with_(facts=answers(None)), "initial facts"),
    "a handler that returns no result": (
        handlers(answers("bang"), lambda m, d: None),
        "the handler of `look`.* returned `bang`, which is not a result of `look`",
    ),
    "a comparator's text": (with_kit(comparators={"by-eye": answers("so")}), "'so'"),
}
