"""`rapc.strict`: handlers do what `:on` and `:tells` say, no less and no more."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rapc
from rapc.errors import SettingError
from rapc.runtime.settings import Settings, read_settings
from rapc.world import Datum, Fact, Handlers, Kit, Offer, Reply, World

LIBRARY = """
(declare-primitive grasp (?arm ?item) (okay dropped jammed)
  :tells (weight)
  :on (okay (holding ?arm ?item) (not (arm-at ?arm ?)) (arm-force ?arm ?)
            (may (dirty ?arm)) (may (clean ?arm)))
  :on (dropped (not (holding ?arm ?))))
(declare-primitive find (?kind) (okay)
  :on (okay (class ?item ?kind true) (location ?item ?place)))
(declare-primitive wait () (okay) :on (okay (patient)))
(declare-primitive peek () (okay) :on (okay (patient) (seen ?anything)))
(declare-memory-proposition seen (?thing))
(declare-sensor-datum weight (?item (?kilos number)) :on ((weighs ?item ?kilos)))
(declare-sensor-datum smell (?item))
(declare-memory-proposition holding (?arm ?item))
(declare-memory-proposition arm-at (?arm ?place))
(declare-memory-property arm-force (?arm ?force) unknown)
(declare-memory-proposition dirty (?arm))
(declare-memory-proposition clean (?arm))
(declare-memory-proposition patient ())
(declare-memory-property weighs (?item ?kilos) unknown)
(declare-memory-property class (?item ?class ?value) false)
(declare-memory-property location (?item ?place) unknown)
(declare-memory-proposition done ())
(define-rap (take ?arm ?item) (succeed (last-result ?any))
  (method (primitive (grasp ?arm ?item))))
(define-rap (look-for ?kind) (method (primitive (find ?kind))))
(define-rap (rest) (method (primitive (wait))))
(define-rap (peek) (method (primitive (peek))))
"""
HERE = Path(__file__).name
OFFER = Offer(
    {
        "grasp": (2, ("okay", "dropped", "jammed")),
        "find": (1, ("okay",)),
        "wait": (0, ("okay",)),
        "peek": (0, ("okay",)),
    },
    {"weight": 2, "smell": 1},
)


def grasped(memory: Any, request: Fact, result: str) -> None:
    """What the declaration says, no more and no less."""
    if result == "okay":
        memory.erase("arm-at", request[1])
        memory.assert_fact("holding", request[1], request[2])
        memory.assert_fact("arm-force", request[1], 7)
    elif result == "dropped":
        memory.erase("holding", request[1])


def found(memory: Any, request: Fact, result: str) -> None:
    memory.introduce("sensed-1", request[1], "shelf")


def weighed(memory: Any, datum: Fact) -> None:
    memory.assert_fact("weighs", *datum[1:])


def smelt(memory: Any, datum: Fact) -> None:
    memory.assert_fact("dirty", "arm1")


GOOD = Reply("okay")


def run(
    task: str = "(take arm1 cup)",
    *,
    reply: Reply = GOOD,
    sends: Fact | None = None,
    strict: bool = True,
    **handlers: Callable[..., Any],
) -> rapc.RunResult:
    """Run a task in a world with these handlers, `strict` if not said otherwise."""
    results: dict[str, Any] = {"grasp": grasped, "find": found}
    data: dict[str, Any] = {"weight": weighed, "smell": smelt}
    for name, handler in handlers.items():
        (data if name in data else results)[name] = handler

    class Arms(World):
        name = "arms"
        kit = Kit(OFFER, Handlers(results, data))

        def __init__(self, rng: Any, options: Any) -> None:
            self.time: Any = 0
            self.sent: list[Datum] = [] if sends is None else [Datum(sends)]

        def facts(self) -> list[Fact]:
            known: list[Fact] = [("arm-at", "arm1", "nest"), ("arm-force", "arm1", 1)]
            return [*known, ("holding", "arm2", "mug"), ("clean", "arm1")]

        def now(self) -> Any:
            return self.time

        def perform(self, ticket: int, request: Fact) -> Reply:
            return reply

        def next_time(self) -> None:
            return None

        def advance(self, to: Any) -> None:
            self.time = to

        def messages(self) -> list[Datum]:
            sent, self.sent = self.sent, []
            return sent

    settings = Settings(strict=strict)
    return rapc.run(rapc.loads(LIBRARY), Arms, task, settings=settings, until=9)


def test_handlers_with_declared_effects_pass() -> None:
    assert run().succeeded
    assert run(reply=Reply("okay", (("weight", "cup", 3),))).succeeded
    assert run("(look-for mug)").succeeded
    assert run("(take arm2 mug)", reply=Reply("dropped")).reason == "done"
    assert run(sends=("smell", "cup")).succeeded


def test_undeclared_result_is_not_checked() -> None:
    def jammed(memory: Any, request: Fact, result: str) -> None:
        memory.assert_fact("dirty", "arm2")
        memory.erase("holding")

    assert run(reply=Reply("jammed"), grasp=jammed).reason == "done"


def test_possible_effect_need_not_happen() -> None:
    def cleanly(memory: Any, request: Fact, result: str) -> None:
        grasped(memory, request, result)
        memory.assert_fact("dirty", request[1])
        memory.erase("clean")

    assert run(grasp=cleanly).succeeded


def only(*facts: Fact, erase: Fact = ("arm-at", "arm1")) -> Callable[..., None]:
    """A handler that asserts some facts, whatever came, and erases one."""

    def handler(memory: Any, request: Fact, result: str) -> None:
        memory.erase(*erase)
        for fact in facts:
            memory.assert_fact(*fact)

    return handler


def does_nothing(memory: Any, *rest: Any) -> None:
    return None


def another(memory: Any, request: Fact, result: str) -> str:
    return "dropped"


HOLDS: Fact = ("holding", "arm1", "cup")
FORCE: Fact = ("arm-force", "arm1", 2)

GRASP = f"in the world `arms` the handler of `grasp` ({HERE}:"

BROKEN: dict[str, tuple[dict[str, Any], str]] = {
    "less": (
        {"grasp": only(FORCE)},
        "after (grasp arm1 cup) - okay did not make (holding arm1 cup) hold",
    ),
    "of another": (
        {"grasp": only(("holding", "arm2", "cup"), FORCE)},
        "asserted (holding arm2 cup), which `:on` does not declare",
    ),
    "more": (
        {"grasp": only(HOLDS, FORCE, ("dirty", "arm2"))},
        "asserted (dirty arm2), which `:on` does not declare",
    ),
    "left": (
        {"grasp": only(HOLDS, FORCE, erase=("clean",))},
        "did not erase (arm-at arm1 nest), as `:on` declares",
    ),
    "too much taken": (
        {"grasp": only(HOLDS, FORCE, erase=("holding",))},
        "erased (holding arm2 mug), which `:on` does not declare",
    ),
    "a property taken away": (
        {"grasp": only(HOLDS, ("arm-at", "arm1", "sky"), FORCE)},
        "asserted (arm-at arm1 sky), which `:on` does not declare",
    ),
    "the result that the handler returns": (
        {"grasp": another, "task": "(take arm2 mug)"},
        "after (grasp arm2 mug) - dropped did not erase (holding arm2 mug)",
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_handler_violating_its_effects_ends_the_run(case: str) -> None:
    given, said = BROKEN[case]
    with pytest.raises(rapc.PortError) as caught:
        run(**given)
    assert caught.value.message.startswith(GRASP)
    assert said in caught.value.message
    assert caught.value.message.endswith("; see <text>:2")
    assert run(**given, strict=False).reason == "done"


def test_error_names_the_line_of_the_assertion() -> None:
    def handler(memory: Any, request: Fact, result: str) -> None:
        grasped(memory, request, result)
        memory.assert_fact("dirty", "arm2")

    line = handler.__code__.co_firstlineno + 2
    with pytest.raises(rapc.PortError, match=f"{HERE}:{line}\\) after"):
        run(grasp=handler)


def test_declared_effects_are_carried_out_without_a_handler() -> None:
    assert run("(rest)").run.memory.query("patient") == [("patient",)]


def test_incomplete_effects_are_not_carried_out() -> None:
    with pytest.raises(rapc.PortError, match=r"did not make \(patient\) hold"):
        run("(peek)")


def test_items_stand_as_class_and_location() -> None:
    with pytest.raises(rapc.PortError, match=r"not make \(class \?item mug true\)"):
        run("(look-for mug)", find=does_nothing)

    def lost(memory: Any, request: Fact, result: str) -> None:
        item = memory.introduce("sensed-1", request[1], "shelf")
        memory.move(item, "floor")
        memory.lose(item)

    assert run("(look-for mug)", find=lost).succeeded

    def sees_a_cat(memory: Any, request: Fact, result: str) -> None:
        memory.introduce("sensed-1", "cat", "shelf")

    said = r"asserted \(class sensed-1 cat true\)"
    with pytest.raises(rapc.PortError, match=said):
        run("(look-for mug)", find=sees_a_cat)


def test_the_handler_of_a_datum_is_held_too() -> None:
    datum = ("weight", "cup", 3)
    said = r"the handler of the datum `weight` .*after \(weight cup 3\) did not make"
    with pytest.raises(rapc.PortError, match=said):
        run(sends=datum, weight=does_nothing)
    with pytest.raises(rapc.PortError, match=r"asserted \(dirty arm1\)"):
        run(sends=datum, weight=smelt)


def test_only_declared_data_come_with_a_primitive() -> None:
    said = (
        r"sent \(smell cup\) with \(grasp arm1 cup\), which `:tells` does not declare"
    )
    with pytest.raises(rapc.PortError, match=said):
        run(reply=Reply("okay", (("smell", "cup"),)))
    assert run(reply=Reply("okay", (("smell", "cup"),)), strict=False).succeeded


def test_the_setting_is_true_or_false() -> None:
    assert read_settings({"strict": "true"}).strict
    assert not read_settings({"strict": "false"}).strict
    for text in ("1", "yes", ""):
        with pytest.raises(SettingError, match=r"`rapc\.strict` takes true or false"):
            read_settings({"strict": text})
    with pytest.raises(SettingError, match=r"`rapc\.futile-limit` takes a whole"):
        read_settings({"futile-limit": "true"})
