"""What a host may do and see while a run goes on: new RAPs, the agenda (T 4.10.1)."""

from __future__ import annotations

import pytest

import rapc
from rapc.compiler.program import Program
from rapc.errors import RefusedError
from rapc.library.loader import load_text
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest, read_task_request
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

LIBRARY = """\
(declare-primitive walk (?place) (okay))
(declare-memory-property at (?place) unknown)

(define-rap (go ?place)
  (duration 7)
  (succeed (at ?place))
  (method
    (primitive (walk ?place))))

(define-rap (stand-by)
  (succeed nil)
  (monitor-state (at den))
  (method
    (task-net)))
"""

PLAN = """\
(define-rap (round-trip ?there ?back)
  (method
    (task-net
      (t1 (go ?there) (for t2))
      (t2 (go ?back)))))
"""


def started() -> Interpreter:
    """A run in which a task stands by and walks take three units."""
    library = Program(load_text(LIBRARY).library)
    walk = Row(("walk", "?place"), takes=3, asserts=(("at", "?place"),))
    run = Interpreter(library, ScriptedWorld([walk], declared=library.library))
    run.submit(read_task_request("(stand-by) :background true"))
    return run


def library() -> rapc.CheckedLibrary:
    """The library again."""
    return rapc.loads(LIBRARY)


def test_a_sketchy_plan_is_taken_up_while_the_run_goes_on() -> None:
    run = started()
    run.submit(TaskRequest(("go", "park")))
    run.step()
    run.extend(library().extend(PLAN).program)
    run.submit(TaskRequest(("round-trip", "den", "park")))
    assert run.run() == "done"
    assert [result.outcome for result in run.results()] == [
        "unfinished",
        "succeeded",
        "succeeded",
    ]
    assert run.now == 9


def test_a_plan_with_a_mistake_is_found_before_it_is_taken_up() -> None:
    with pytest.raises(rapc.CheckError, match="go-too") as caught:
        library().extend(PLAN.replace("(go ?back)", "(go-too ?back)"))
    [finding] = caught.value.report.findings
    assert finding.diagnostic.span.file == "<plan>"


def test_a_library_with_more_than_new_raps_is_refused() -> None:
    run = started()
    more = library().extend("(declare-memory-proposition new (?x))").program
    with pytest.raises(RefusedError, match="no changed propositions"):
        run.extend(more)
    other = LIBRARY.replace("(duration 7)", "(duration 8)")
    with pytest.raises(RefusedError, match="`go` differs from the RAP in the run"):
        run.extend(Program(load_text(other).library))


def test_added_methods_extend_a_library_but_no_run() -> None:
    more = library().extend("(define-method go crawl (primitive (walk ?place)))")
    assert [m.name for m in more.program.library.raps["go"].methods] == [None, "crawl"]
    with pytest.raises(RefusedError, match="`go` differs from the RAP in the run"):
        started().extend(more.program)


def test_the_agenda_shows_each_task_with_its_slack() -> None:
    run = started()
    run.submit(read_task_request("(go park) :deadline 20 :priority 3"))
    run.step()
    sleeper, walker = run.agenda()
    assert (sleeper.task, sleeper.state, sleeper.slack) == (1, "blocked", None)
    assert sleeper.waits_for == "(at den)"
    assert (walker.task, walker.state, walker.priority) == (2, "eligible", 3)
    assert (walker.deadline, walker.duration, walker.slack) == (20, 7, 10)
    assert walker.waits_for == ""
    run.run()
    assert run.agenda() == ()
    assert (walker.state, walker.slack) == ("eligible", 10)
