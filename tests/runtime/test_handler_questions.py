"""Formulas that handlers ask: answered as a clause is, made ready once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import rapc
from rapc.base.values import Atom, Fact
from rapc.events import Event, QueryFaulted
from rapc.runtime.host_query import HostQuery
from rapc.world import Handlers, Kit, Offer, Reply, World

LIBRARY = """
(declare-primitive look (?where) (okay))
(declare-memory-property class (?item ?class ?value) false)
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property open (?door ?state) unknown)
(declare-memory-proposition near (?place ?other))
(declare-memory-proposition told (?what))
(declare-indistinct-class box)
(define-query (beside ?place ?item)
  (and (near ?place ?other) (location ?item ?other)))
(define-rap (look-at ?where)
  (succeed (told ?where))
  (method (primitive (look ?where))))
"""
Handler = Callable[[Any, Fact, str], None]
HERE = Path(__file__).name


def run(handler: Handler) -> list[Event]:
    """The events of a run in which `handler` takes the result of one request."""

    def looked(memory: Any, request: Fact, result: str) -> None:
        handler(memory, request, result)
        memory.assert_fact("told", request[1])

    class Rooms(World):
        name = "rooms"
        kit = Kit(Offer({"look": (1, ("okay",))}), Handlers({"look": looked}))

        def __init__(self, rng: Any, options: Any) -> None:
            self.time: Any = 0

        def facts(self) -> list[Fact]:
            return [("near", "hall", "shed"), ("location", "cart", "shed")]

        def now(self) -> Any:
            return self.time

        def perform(self, ticket: int, request: Fact) -> Reply:
            return Reply("okay")

        def next_time(self) -> None:
            return None

        def advance(self, to: Any) -> None:
            self.time = to

        def messages(self) -> tuple[()]:
            return ()

    events: list[Event] = []
    tasks = ["(look-at hall)", "(look-at shed)"]
    rapc.run(rapc.loads(LIBRARY), Rooms, tasks=tasks, listeners=[events.append])
    return events


def answers(
    formula: str, given: dict[str, Atom] | None = None
) -> list[list[dict[str, Any]]]:
    """What a formula comes to for a handler that asks it twice in a run."""
    found: list[list[dict[str, Any]]] = []
    run(lambda memory, request, result: found.append(memory.ask(formula, given)))
    return found


def test_a_handler_asks_named_queries_and_defaults() -> None:
    assert answers("(beside hall ?x)") == [[{"?x": "cart"}]] * 2
    assert answers("(open gate ?how)") == [[{"?how": "unknown"}]] * 2
    assert answers("(near ?a ?b)", {"?b": "shed"}) == [[{"?a": "hall"}]] * 2
    assert answers("(not (near shed ?))") == [[{}]] * 2
    assert answers("(near shed ?)") == [[], []]


def test_query_sees_changes_of_the_handler() -> None:
    found: list[Any] = []

    def looked(memory: Any, request: Fact, result: str) -> None:
        memory.assert_fact("near", "shed", request[1])
        found.append(memory.ask("(near shed ?x)"))
        memory.erase("near", "shed")
        found.append(memory.ask("(near shed ?x)"))

    run(looked)
    assert found == [[{"?x": "hall"}], [], [{"?x": "shed"}], []]


def test_items_of_the_batch_are_asked_for_by_their_names() -> None:
    found: list[Any] = []

    def looked(memory: Any, request: Fact, result: str) -> None:
        memory.expire()
        memory.arrive("shed")
        item = memory.introduce("sensed-1", "box", "shed")
        found.append((item, memory.ask("(location ?x external)", {"?x": item})))
        found.append(memory.ask("(class ?x box true)"))

    run(looked)
    (item, here), seen, (again, there), both = found
    assert (here, there) == ([{}], [{}])
    assert seen == [{"?x": item}]
    assert again in [one["?x"] for one in both]


@pytest.mark.parametrize(
    ("formula", "given", "said"),
    [
        ("(nearby ?x)", {}, "no proposition .* called `nearby`|`nearby`"),
        ("(near ?x", {}, "ValueError|TextError"),
        ("(near ?x ?y)", {"?z": "a"}, "`[?]z` is not in the query"),
    ],
)
def test_invalid_query_is_a_fault_of_the_handler(
    formula: str, given: dict[str, Atom], said: str
) -> None:
    with pytest.raises(rapc.PortError, match=said) as caught:
        answers(formula, given)
    assert f"the handler of `look` failed at {HERE}:" in caught.value.message


def test_a_fault_in_a_question_is_traced_and_answers_nothing() -> None:
    def looked(memory: Any, request: Fact, result: str) -> None:
        assert memory.ask("(and (near ?x ?y) (near (/ 1 0) ?y))") == []

    faults = [e for e in run(looked) if isinstance(e, QueryFaulted)]
    assert [fault.task for fault in faults] == [None, None]


def test_a_formula_is_made_ready_once(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Any] = []

    class Counted(HostQuery):
        def __init__(self, *args: Any) -> None:
            made.append(args[1])
            super().__init__(*args)

    monkeypatch.setattr("rapc.runtime.host_query.HostQuery", Counted)
    places: list[str] = []

    def looked(memory: Any, request: Fact, result: str) -> None:
        places.append(str(request[1]))
        memory.ask("(near ?x ?y)", {"?x": request[1]})
        memory.ask("(near ?x ?y)", {"?y": request[1]})

    run(looked)
    assert places == ["hall", "shed"]
    assert len(made) == 2
