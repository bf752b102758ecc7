"""A default that depends on the place where a thing is (T 2.2.2)."""

from __future__ import annotations

from rapc.base.values import Atom, Fact
from rapc.compiler.program import Program
from rapc.library.loader import load_text
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.memory.access import MemoryView
from rapc.runtime.task_request import TaskRequest
from rapc.worlds.scripted import ScriptedWorld

LIBRARY = """\
(declare-memory-property lies (?thing ?place) unknown)
(declare-memory-function working-by-place (?index))
(declare-memory-property works (?thing ?value) working-by-place)

(define-rap (judge ?thing ?value)
  (succeed (works ?thing ?value)))
"""


def working_by_place(memory: MemoryView, index: Fact) -> Atom:
    """Things work, but not on the scrap heap; in the workshop nobody knows."""
    place = memory.value("lies", index[1])
    return {"scrap-heap": "false", "workshop": "unknown"}.get(str(place), "true")


def judged(place: str, value: str, *facts: Fact) -> str:
    """What becomes of the question whether a thing at a place works."""
    run = Interpreter(
        Program(load_text(LIBRARY).library),
        ScriptedWorld([]),
        functions={"working-by-place": working_by_place},
    )
    run.start()
    run.assert_fact("lies", "drill", place)
    for fact in facts:
        run.assert_fact(*fact)
    run.submit(TaskRequest(("judge", "drill", value)))
    run.run()
    return run.results()[0].outcome


def test_a_default_depends_on_the_place() -> None:
    assert judged("shelf", "true") == "succeeded"
    assert judged("scrap-heap", "true") == "failed"
    assert judged("scrap-heap", "false") == "succeeded"
    assert judged("workshop", "unknown") == "succeeded"


def test_earlier_answers_count_more() -> None:
    found = ("works", "drill", "true")
    assert judged("scrap-heap", "true", found) == "succeeded"
    assert judged("scrap-heap", "false", found) == "failed"
