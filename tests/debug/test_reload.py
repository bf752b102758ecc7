"""A run goes on with another text of its library, and back with the one before."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.debug.reload import reread, typed_in
from rapc.debug.session import Session
from rapc.errors import RefusedError
from rapc.host import CheckError
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


def _session(*rows: str) -> Session:
    script = tuple(row(f"(say {word})", "hoarse") for word in rows)
    return scripted(TEXT, "(speak)", rows=(*script, row("(say ?word)")))


def _typed(session: Session, text: str) -> None:
    library = session.run.machine.library
    session.take_up(typed_in(library.library, text, library.name).library)


def _said(session: Session) -> list[object]:
    """Return the words that have been said to the world."""
    return [
        told.keys["request"][1]
        for told in session.scan()
        if told.kind.__name__ == "PrimitiveRequested"
    ]


def test_a_method_under_way_keeps_its_text_and_the_next_choice_sees_the_new() -> None:
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


def test_what_a_task_has_tried_stays_with_methods_of_the_same_name() -> None:
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
    [task] = [t for t in session.run.machine.state.live_tasks() if t.number == 2]
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


def test_what_cannot_be_taken_up_changes_nothing() -> None:
    session = _session()
    session.step()
    here = session.run.save()
    for text, why in (
        (
            "(define-rap (speak ?x) (method (primitive (say ?x))))",
            "its inputs must stay",
        ),
        (
            "(declare-memory-proposition p)",
            r"declarations have changed \(propositions\)",
        ),
    ):
        with pytest.raises(RefusedError, match=why):
            _typed(session, text)
    with pytest.raises(CheckError, match="is not bound here"):
        _typed(session, "(define-rap (speak) (method (primitive (say ?x))))")
    assert session.run.save() == here
    assert session.branch.acts == []


def test_files_are_read_again(tmp_path: Path) -> None:
    file = tmp_path / "small.rap"
    file.write_text(TEXT)
    session = _session()
    shell = Shell(session, commands(), [str(file)])
    assert said(shell, ":reload") == "nothing has changed\n"
    shell.answer(":step 2")
    file.write_text(TEXT.replace("(say ?word)", "(say again)"))
    assert said(shell, ":reload") == "done: take up utter\n"
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
    ) == ("done: take up go-fast\n")
    assert "[2] (go-fast)" in said(shell, "(go-fast)")
    text = said(
        shell,
        "(define-rap (go-fast) (method (primitive (truck-sped fast))))",
        width=200,
    )
    assert "<typed>:1:" in text
    assert "did you mean" in text or "truck-sped" in text
    assert "<typed>" in said(shell, ":source go-fast")
    assert "a parenthesis or a string is left open" in said(shell, "(define-rap (x")
