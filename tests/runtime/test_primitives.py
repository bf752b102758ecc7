"""Requests, names of items, results and data [L 3] [T 3.3]."""

from __future__ import annotations

from collections.abc import Sequence
from io import StringIO
from typing import Any

import msgspec
import pytest

from rapc import events
from rapc.base.values import Fact
from rapc.errors import PortError
from rapc.library.library import Library
from rapc.runtime.events.report import RunReport
from rapc.runtime.events.trace import TextTrace
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import read_task_request
from rapc.world import (
    Datum,
    Finished,
    HandlerMemory,
    Handlers,
    Kit,
    Message,
    Reply,
    Time,
)
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

from .helpers import ANY, Play, at, compiled, play, row

USE = "(define-rap (use ?x) (method (primitive (act ?x))))"


@pytest.mark.parametrize("arg", ["?never", "?c", "(/ 1 0)", "(+ ?x 1)"])
def test_request_without_values_fails_the_method(arg: str) -> None:
    ran = play(
        f"""
        (define-rap (top ?x) (resources (counter ?c))
          (succeed (last-result interference))
          (method (primitive (act {arg}))))
        """,
        "(top word)",
    )
    assert ran.told("asked") == []
    assert ran.told("ended", "succeeded") == [
        "ended top #1 interference",
        "succeeded (top word)",
    ]
    assert len(ran.told("fault")) == 1


def test_at_block_precedes_the_result_of_an_atomic_primitive() -> None:
    ran = play(
        USE,
        "(use a)",
        rows=[row("(act a)", takes=10, asserts=["(p result)"])],
        times=[at(4, "(p at)")],
    )
    assert ran.told("asserted", "done", times=True) == [
        "10 asserted (p at) by handler",
        "10 asserted (p result) by handler",
        "10 done use (act a) okay",
    ]


def test_a_result_changes_memory_before_it_is_told() -> None:
    ran = play(
        USE, "(use a)", rows=[row("(act a)", asserts=["(p x)"], erases=["(p y)"])]
    )
    assert ran.told("asserted", "done", "ended") == [
        "asserted (p x) by handler",
        "done use (act a) okay",
        "ended use #1 okay",
    ]


def test_simultaneous_primitives_end_in_the_order_of_the_world() -> None:
    text = "(define-rap (drag ?x) (method (primitive (slow ?x))))"
    for seed in range(4):
        ran = play(
            text,
            *[f"(drag {x})" for x in "abc"],
            rows=[row("(slow ?)", after=5)],
            seed=seed,
        )
        asked = [line.split("(")[1] for line in ran.told("asked")]
        done = [line.split("(")[1].replace(") okay", ")") for line in ran.told("done")]
        assert asked == done


# --- items -------------------------------------------------------------------------


def _look(memory: HandlerMemory, request: Fact, result: str) -> None:
    memory.arrive("kitchen")


def _act(memory: HandlerMemory, request: Fact, result: str) -> None:
    if request[1] == "leave":
        memory.expire()


def _seen(memory: HandlerMemory, datum: Fact) -> None:
    memory.introduce(str(datum[1]), "mug", "external")


class Eyes(ScriptedWorld):
    """A world whose `look` shows `mug-1` in the kitchen; `act leave` leaves it."""

    def __init__(self, rows: Sequence[Row], library: Library) -> None:
        handlers = Handlers({"look": _look, "act": _act}, {"seen": _seen})
        super().__init__(rows, declared=library, kit=Kit(handlers=handlers))
        self.kit = msgspec.structs.replace(self.kit, handlers=handlers)


ITEMS = """
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property class (?item ?kind ?value) false)
(declare-sensor-datum seen (?item))
(define-rap (top)
  (method (context (not (last-result ?)))
          (task-net (t1 (spy) (for t2)) (t2 (grab) (for t3)) (t3 (use leave) (for t4))
                    (t4 (grab)))))
(define-rap (spy) (method (primitive (look around))))
(define-rap (grab)
  (method (context (location ?x kitchen)) (primitive (act ?x))))
"""


def items_run() -> tuple[Interpreter, list[events.Event]]:
    """A run in which an item is seen, used, left, and used again."""
    library = compiled(ITEMS + USE)
    rows = [row("(look ?)", data=(("seen", "mug-1"),)), *ANY]
    world = Eyes(rows, library.library)
    interpreter = Interpreter(library, world)
    heard: list[events.Event] = []
    interpreter.listen(heard.append)
    interpreter.submit(read_task_request("(top)"))
    interpreter.run()
    return interpreter, heard


def test_item_names_become_sensor_names_and_need_one() -> None:
    interpreter, heard = items_run()
    asked = [e for e in heard if isinstance(e, events.PrimitiveRequested)]
    item = next(e.item for e in heard if isinstance(e, events.ItemEvent))
    assert [(e.request, e.sent) for e in asked] == [
        (("look", "around"), ("look", "around")),
        (("act", item), ("act", "mug-1")),
        (("act", "leave"), ("act", "leave")),
    ]
    failed = [e for e in heard if isinstance(e, events.TaskFailed)]
    assert (str(failed[0].goal), failed[0].reason, failed[0].result) == (
        "(grab)",
        "futile-loop",
        "futile-loop",
    )
    assert interpreter.memory.value("location", item) == "kitchen"


def test_the_result_is_handled_before_the_data_and_both_before_the_trace() -> None:
    _, heard = items_run()
    kinds = [type(e).__name__ for e in heard]
    item = kinds.index("ItemIntroduced")
    assert kinds[item : kinds.index("PrimitiveEnded") + 1][-1] == "PrimitiveEnded"
    ended = next(e for e in heard if isinstance(e, events.PrimitiveEnded))
    (introduced,) = (e for e in heard if isinstance(e, events.ItemIntroduced))
    assert introduced.location == "kitchen"  # `arrive` of the result came first
    assert ended.data == (("seen", introduced.item),)


# --- what the world must keep to ---------------------------------------------------


class Rude(ScriptedWorld):
    """A world that sends what it should not."""

    def __init__(self, messages: Sequence[Message], **more: Any) -> None:
        super().__init__([*ANY], **more)
        self.rude = list(messages)

    def messages(self) -> Sequence[Message]:
        """The rude ones first."""
        found, self.rude = self.rude, []
        return (*found, *super().messages())


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (Finished(99, Reply("okay")), "not under way"),
        (Datum(("nonsense",)), "no handler"),
    ],
)
def test_world_violating_the_port_is_an_error(message: Message, words: str) -> None:
    library = compiled(USE)
    interpreter = Interpreter(library, Rude([message], declared=library.library))
    interpreter.submit(read_task_request("(use a)"))
    with pytest.raises(PortError, match=words):
        interpreter.run()


def test_primitive_ending_after_until_stays_unended() -> None:
    times: list[Time] = []
    ran = Play(USE, "(use a)", rows=[row("(act a)", takes=10)])
    ran.interpreter.call_at_end(lambda: times.append(ran.interpreter.now))
    ran.run(until=5)
    assert ran.told("asked", "done", "over") == ["asked (act a)", "over until"]
    assert times == [5]


SLOW = "(define-rap (charge) (method (primitive (slow dock))))"


def test_task_waiting_for_a_primitive_is_shown_everywhere() -> None:
    ran = Play(SLOW, "(charge)", rows=[row("(slow dock)", after=50)])
    run, stream = ran.interpreter, StringIO()
    report = RunReport()
    run.listen(TextTrace(stream))
    run.listen(report, *report.kinds)
    run.step()
    assert run.agenda()[0].waits_for == "(slow dock)"
    assert run.waiting() == ("(charge) [1] waits for (slow dock)",)
    run.run(until=20)
    assert ran.events[-1].waiting == ("(charge) [1] waits for (slow dock)",)  # type: ignore[attr-defined]
    assert " ... primitive operation (slow dock) begun\n" in stream.getvalue()
    lines = list(report.lines())
    assert lines[lines.index("Left over:") + 1] == (
        "  (charge) [1] waits for (slow dock)"
    )


def test_instant_primitive_has_one_line_in_the_trace() -> None:
    ran = Play(USE, "(use a)")
    stream = StringIO()
    ran.interpreter.listen(TextTrace(stream))
    ran.run()
    assert "begun" not in stream.getvalue()
    assert "... primitive operation (act a) - okay" in stream.getvalue()
