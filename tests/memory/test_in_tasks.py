"""Two names turn out to be one item while tasks are under way that hold them."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

from rapc import events
from rapc.base.values import Atom, Fact, Number
from rapc.compiler.program import Program
from rapc.library.loader import load_text
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest
from rapc.world import (
    OKAY,
    HandlerMemory,
    Handlers,
    Kit,
    Message,
    Offer,
    Reply,
    World,
)

LIBRARY = """
(declare-memory-property class (?item ?class ?value) unknown)
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property color (?item ?value) unknown)
(declare-memory-proposition known (?item))
(declare-memory-proposition same (?item))
(declare-indistinct-class drum)
(declare-primitive look (?name ?color) (okay))
(declare-primitive leave () (okay))
(declare-primitive touch (?item) (okay))
(define-rap (look-p ?name ?color) (method (primitive (look ?name ?color))))
(define-rap (leave-p) (method (primitive (leave))))
(define-rap (touch-p ?item)
  (method (context (know-sensor-name ?item true)) (primitive (touch ?item))))

(define-rap (visit-twice)
  (method
    (task-net
      (t1 (look-p a red) (for t2))
      (t2 (look-p b blue) (for t3))
      (t3 (leave-p) (for t4))
      (t4 (find-red)))))

(define-rap (find-red)
  (resources (set ?seen))
  (method
    (context (color ?old red))
    (task-net
      (t1 (remember ?old) (set-add ?seen ?old) (for t2))
      (t2 (look-p c none) (for t3))
      (t3 (compare ?old ?seen)))))

(define-rap (remember ?item) (method (notations (known ?item)) (task-net)))

(define-rap (compare ?old ?seen)
  (succeed (same ?old))
  (method
    (context (and (know-sensor-name ?new true) (n= ?new ?old)))
    (task-net
      (t1 (one-of ?old ?new ?seen)))))

(define-rap (one-of ?old ?new ?seen)
  (succeed (and (= ?old ?new) (member ?seen ?new) (last-result okay)))
  (method
    (task-net
      (t1 (look-p c red) (for t2))
      (t2 (touch-p ?old)))))

(define-rap (watch)
  (monitor-state (and (know-sensor-name ?x true) (color ?x unknown)))
  (method
    (context (and (know-sensor-name ?x true) (color ?x unknown)))
    (task-net
      (t1 (await ?x)))))

(define-rap (await ?item)
  (monitor-state (same ?item))
  (succeed (same ?item))
  (method (task-net)))
"""


class Yard(World):
    """A world that shows drums: the requests say which, and of what colour."""

    name = "yard"

    def __init__(self, rng: random.Random, options: Mapping[str, Atom | bool]) -> None:
        self.time: Number = 0
        self.touched: list[Atom] = []
        offer = Offer(
            {"look": (2, (OKAY,)), "leave": (0, (OKAY,)), "touch": (1, (OKAY,))}
        )
        handlers = Handlers({"look": _look, "leave": _leave, "touch": _touch})
        self.kit = Kit(offer, handlers)

    def now(self) -> Number:
        return self.time

    def perform(self, ticket: int, request: Fact) -> Reply:
        self.time += 1
        if request[0] == "touch":
            self.touched.append(request[1])
        return Reply(OKAY)

    def next_time(self) -> None:
        return None

    def advance(self, to: Number) -> None:
        self.time = to

    def messages(self) -> Sequence[Message]:
        return ()


def _look(memory: HandlerMemory, request: Fact, result: str) -> None:
    _, name, color = request
    item = memory.introduce(f"s-{name}", "drum", "yard")
    if color != "none":
        memory.assert_fact("color", item, color)


def _leave(memory: HandlerMemory, request: Fact, result: str) -> None:
    memory.expire()


def _touch(memory: HandlerMemory, request: Fact, result: str) -> None:
    memory.assert_fact("same", request[1])


def _begun(*goals: str) -> tuple[Yard, Interpreter, list[events.Event]]:
    loaded = load_text(LIBRARY)
    assert loaded.diagnostics == ()
    world = Yard(random.Random(0), {})
    interpreter = Interpreter(Program(loaded.library), world)
    seen: list[events.Event] = []
    interpreter.listen(seen.append)
    for goal in goals:
        interpreter.submit(TaskRequest((goal,), priority=5 * (goal == "watch")))
    return world, interpreter, seen


def _run(*goals: str) -> tuple[Yard, Interpreter, list[events.Event]]:
    world, interpreter, seen = _begun(*goals)
    interpreter.run()
    return world, interpreter, seen


def test_bindings_sets_and_requests_know_an_item_by_its_older_name() -> None:
    world, interpreter, seen = _run("visit-twice")
    (result,) = interpreter.results()
    assert result.outcome == "succeeded"
    (merge,) = [e for e in seen if isinstance(e, events.ItemMerged)]
    assert world.touched == ["s-c"]
    (touch,) = [
        e
        for e in seen
        if isinstance(e, events.PrimitiveRequested) and e.request[0] == "touch"
    ]
    assert touch.request == ("touch", merge.item)
    assert touch.sent == ("touch", "s-c")
    later = seen[seen.index(merge) + 1 :]
    named = [
        e for e in later if isinstance(e, events.TaskSucceeded | events.TaskCreated)
    ]
    assert not [e for e in named if merge.with_ in e.goal.parts]


def test_an_older_name_serves_whoever_comes_with_the_younger() -> None:
    _, interpreter, seen = _run("visit-twice")
    (merge,) = [e for e in seen if isinstance(e, events.ItemMerged)]
    memory = interpreter.memory
    assert memory.value("color", merge.with_ or "") == "red"
    interpreter.assert_fact("known", merge.with_ or "")
    assert memory.query("known", None) == [("known", merge.item)]
    assert interpreter.question(f"(color {merge.with_} red)").holds()
    assert interpreter.question("(color ?x red)", "?x").holds(merge.with_)
    assert not interpreter.question("(color item-99 red)").holds()


def test_a_question_asked_before_a_merge_knows_the_younger_name_after_it() -> None:
    _, interpreter, seen = _begun("visit-twice")
    question = interpreter.question("(color item-3 ?color)")
    before = question.first()
    interpreter.run()
    (merge,) = [e for e in seen if isinstance(e, events.ItemMerged)]
    assert merge.with_ == "item-3"
    assert before == {"?color": "unknown"}
    assert question.first() == {"?color": "red"}


def test_who_waits_for_something_of_the_younger_name_is_woken_by_the_older() -> None:
    _, interpreter, seen = _run("visit-twice", "watch")
    (merge,) = [e for e in seen if isinstance(e, events.ItemMerged)]
    blocked = [e.on for e in seen if isinstance(e, events.TaskBlocked)]
    assert f"(same {merge.with_})" in blocked
    woken = [e.on for e in seen if isinstance(e, events.TaskWoken)]
    assert f"(same {merge.item})" in woken
    assert interpreter.reason == "done"
    assert [r.outcome for r in interpreter.results()] == ["succeeded", "succeeded"]
