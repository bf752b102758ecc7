"""A run goes on with another text of its library, and back with the one before."""

from __future__ import annotations

from pathlib import Path

import pytest

import rapc
from rapc.debug.acts import AssertFact
from rapc.debug.history import History
from rapc.debug.reload import reread, typed_in
from rapc.errors import RefusedError
from rapc.host import CheckError
from rapc.ir.printer import format_node
from rapc.repl.commands.table import commands
from rapc.repl.shell import Shell
from tests.debug.sessions import row, scripted, truck
from tests.repl.shells import said, truck_shell

TEXT = """
(declare-primitive say (?word) (okay hoarse))
(define-rap (speak) (method once (task-net (t1 (utter one) (for t2)) (t2 (utter two)))))
(define-rap (utter ?word)
  (method loud (primitive (say ?word)))
  (method soft (primitive (say hush))))
"""


def _session(*rows: str) -> History:
    script = tuple(row(f"(say {word})", "hoarse") for word in rows)
    return scripted(TEXT, "(speak)", rows=(*script, row("(say ?word)")))


def _typed(session: History, text: str) -> None:
    library = session.run.library
    session.take_up(typed_in(library.library, text, library.name).library)


def _said(session: History) -> list[object]:
    """Return the words that have been said to the world."""
    return [
        told.keys["request"][1]
        for told in session.scan()
        if told.kind.__name__ == "PrimitiveRequested"
    ]


def test_reload_applies_to_the_next_choice() -> None:
    session = _session()
    session.step(2)
    _typed(
        session,
        """
        (define-rap (speak) (method once (task-net (t1 (utter never)))))
        (define-rap (utter ?word) (method loud (primitive (say louder))))
        """,
    )
    assert session.go().kind == "over"
    assert _said(session) == ["one", "louder"]
    session.goto(1)
    assert session.go().kind == "over"
    assert _said(session) == ["one", "louder"]


def test_tries_stay_with_methods_of_the_same_name() -> None:
    session = _session("one")
    session.step(2)
    _typed(
        session,
        """
        (define-rap (utter ?word)
          (method soft (primitive (say softly)))
          (method loud (primitive (say loudly))))
        """,
    )
    [task] = [t for t in session.run.state.live_tasks() if t.number == 2]
    failed = {m.name: task.failures_of(m) for m in task.plan.methods}
    assert sorted(failed.values()) == [0, 1]
    session.go()
    assert session.run.results()[0].outcome == "succeeded"


def test_every_moment_is_reached_again_across_a_new_text() -> None:
    session = truck()
    session.step(70)
    _typed(
        session,
        "(define-rap (truck-speed-p ?speed)"
        "  (method fast (primitive (truck-speed fast))))",
    )
    states = {}
    while session.step().kind == "asked":
        states[session.cycle] = session.run.save()
    for cycle in (min(states), 90, 130, max(states)):
        session.goto(30)
        session.goto(cycle)
        assert session.run.save() == states[cycle]


def test_refused_restore_changes_nothing() -> None:
    session = _session()
    session.step()
    here = session.run.save()
    for text, why in (
        (
            "(define-rap (speak ?x) (method (primitive (say ?x))))",
            "cannot change the inputs of",
        ),
        (
            "(declare-primitive shout (?word) (okay))",
            "`scripted`.*`shout`",
        ),
    ):
        with pytest.raises(RefusedError, match=why):
            _typed(session, text)
    with pytest.raises(CheckError, match="is not bound here"):
        _typed(session, "(define-rap (speak) (method (primitive (say ?x))))")
    assert session.run.save() == here
    assert session.branch.acts == []


WET = """
(declare-primitive wait-a-bit () (okay) :atomic false)
(declare-primitive look () (okay))
(declare-memory-proposition wet (?place))
(declare-memory-property level (?tank (?amount number)) unknown)
(define-rap (watch) (method (task-net (t1 (sleep) (for t2)) (t2 (peer)))))
(define-rap (sleep) (monitor-state (wet cellar)) (method (primitive (look))))
(define-rap (peer) (method (primitive (look))))
(define-rap (linger) (method (primitive (wait-a-bit))))
"""


def _wet(*tasks: str) -> History:
    rows = (row("(look)"), row("(wait-a-bit)", takes=0, after=9))
    return scripted(WET, *tasks, rows=rows)


def test_declarations_may_change_while_a_run_goes_on() -> None:
    session = _wet("(watch)", "(linger)")
    session.step(2)
    _typed(session, "(declare-memory-proposition dry (?place))")
    session.act(AssertFact(("dry", "attic")))
    assert session.question("(dry ?x)").all() == [{"?x": "attic"}]
    session.step()
    there = session.run.save()
    session.goto(1)
    with pytest.raises(ValueError, match="unknown predicate `dry`"):
        session.question("(dry ?x)")
    session.goto(3)
    assert session.run.save() == there
    assert session.question("(dry ?x)").all() == [{"?x": "attic"}]


def test_changed_monitor_wakes_by_its_new_text() -> None:
    session = _wet("(watch) :priority 2", "(linger)")
    session.step(2)
    assert session.run.agenda()[2].state == "blocked"
    session.act(AssertFact(("level", "tank", 3)))
    text = WET.replace("(wet cellar)", "(level ?tank 3)")
    session.take_up(rapc.loads(text, "small.rap"))
    session.go()
    assert session.run.results()[0].outcome == "succeeded"


def test_a_task_under_way_may_gain_a_monitor_and_lose_it() -> None:
    session = _wet("(watch)")
    session.step(1)
    looking = "(method (primitive (look))))"
    _typed(session, f"(define-rap (peer) (monitor-state (wet attic)) {looking}")
    session.act(AssertFact(("wet", "cellar")))
    assert session.go().said == "stuck"
    session.goto(session.cycle)
    assert not session.over
    _typed(session, f"(define-rap (peer) {looking}")
    session.go()
    assert session.run.results()[0].outcome == "succeeded"


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        (
            "(declare-memory-proposition wet (?place))",
            "(declare-memory-proposition wet (?place ?how))",
            r"memory contains 1 fact of `wet`, which is now the proposition "
            r"`\(wet \?place \?how\)`; remove the facts with `:erase \(wet\)`",
        ),
        (
            "(?tank (?amount number))",
            "(?tank (?amount item))",
            r"memory contains \(level tank 3\): ",
        ),
        (
            "(declare-primitive wait-a-bit () (okay)",
            "(declare-primitive wait-a-bit () (okay late)",
            r"cannot change the declaration of `wait-a-bit`: \(wait-a-bit\) is "
            r"under way",
        ),
    ],
)
def test_saved_fields_must_have_declared_types(old: str, new: str, why: str) -> None:
    session = _wet("(linger)")
    session.step(1)
    session.act(AssertFact(("wet", "attic")))
    session.act(AssertFact(("level", "tank", 3)))
    here = session.run.save()
    text = WET.replace("(monitor-state (wet cellar))", "").replace(old, new)
    with pytest.raises(RefusedError, match=why):
        session.take_up(rapc.loads(text, "small.rap"))
    assert session.run.save() == here


def test_watches_and_breakpoints_go_with_the_text() -> None:
    shell = Shell(_wet("(watch)", "(linger)"), commands())
    shell.answer(":step")
    shell.answer("(declare-memory-proposition dry (?place))")
    assert "watch 1 (dry ?x): no" in said(shell, ":watch (dry ?x)")
    shell.answer(":break true (dry attic)")
    shell.answer(":break rap peer if (dry attic)")
    assert "* watch 1 (dry ?x): ?x attic" in said(
        shell, ":assert (dry attic)", ":watch"
    )
    shell.answer(":assert (wet cellar)")
    assert "stopped: breakpoint 1" in said(shell, ":step")
    assert "watch 1 (dry ?x): unknown predicate `dry`" in said(
        shell, ":unbreak 1", ":branch other", ":goto 0", ":watch", width=200
    )


def test_files_are_read_again(tmp_path: Path) -> None:
    file = tmp_path / "small.rap"
    file.write_text(TEXT)
    session = _session()
    shell = Shell(session, commands(), [str(file)])
    assert said(shell, ":reload") == "no definition changed\n"
    shell.answer(":step 2")
    file.write_text(TEXT.replace("(say ?word)", "(say again)"))
    assert said(shell, ":reload") == "reloaded `utter`\n"
    file.write_text(TEXT.replace("?word)))", "?wrod)))"))
    assert "is not bound here" in said(shell, ":reload", width=200)
    shell.answer(":run")
    assert _said(session) == ["one", "again"]
    file.unlink()
    assert "does not exist" in said(shell, ":reload", width=200)


def test_typed_definitions_stay_when_files_are_read_again(tmp_path: Path) -> None:
    file = tmp_path / "small.rap"
    file.write_text(TEXT)
    renewed = reread(
        [str(file)], "(define-rap (utter ?w) (method (primitive (say me))))", "x"
    )
    assert renewed.library.program.library.raps["utter"].span.file == "<typed>"
    assert "speak" in renewed.library.raps


def test_definitions_are_typed_checked_and_used() -> None:
    shell = truck_shell()
    assert said(
        shell, "(define-rap (go-fast) (method (primitive (truck-speed fast))))"
    ) == ("reloaded `go-fast`\n")
    assert "[2] (go-fast)" in said(shell, "(go-fast)")
    text = said(
        shell,
        "(define-rap (go-fast) (method (primitive (truck-sped fast))))",
        width=200,
    )
    assert "<typed>:1:" in text
    assert "did you mean" in text or "truck-sped" in text
    assert "<typed>" in said(shell, ":source go-fast")
    assert "a parenthesis or string is not closed" in said(shell, "(define-rap (x")


def test_typed_methods_are_added_and_replaced() -> None:
    session = _session()
    _typed(session, "(define-method utter song (primitive (say la)))")
    _typed(session, "(define-method utter song (primitive (say lala)))")
    utter = session.run.library.library.raps["utter"]
    assert [method.name for method in utter.methods] == ["loud", "soft", "song"]
    assert format_node(utter.methods[2].body) == "(primitive (say lala))"
    with pytest.raises(CheckError, match="duplicate method name `loud` of `utter`"):
        _typed(session, "(define-method utter loud (primitive (say la)))")
    with pytest.raises(CheckError, match="unknown RAP `uter`"):
        _typed(session, "(define-method uter song (primitive (say la)))")


def test_source_shows_added_methods() -> None:
    shell = truck_shell()
    said(shell, "(define-method rock-order doze (primitive (eye-scan external)))")
    rows = said(shell, ":source rock-order")
    assert "(define-rap (rock-order" in rows
    assert "<typed>\n1 (define-method rock-order doze" in rows
