"""A run goes on with another text of its library, and back with the one before."""

from __future__ import annotations

import re
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


def test_definition_typed_again_keeps_those_typed_with_it() -> None:
    shell = truck_shell()
    fast = "(define-rap (go-fast) (method (primitive (truck-speed fast))))"
    slow = "(define-rap (go-slow) (method (primitive (truck-speed slow))))"
    said(shell, f"{fast} {slow}")
    assert "reloaded" in said(shell, fast.replace("speed fast", "speed medium"))
    assert "truck-speed slow" in said(shell, ":source go-slow")
    assert "truck-speed medium" in said(shell, ":source go-fast")


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


RULES = """
(declare-primitive say (?word) (okay hoarse))
(declare-event :noise ((?sound symbol)))
(declare-memory-proposition heard (?word ?by))
(define-rap (speak ?word ?tone) (method (primitive (say ?word))))
(define-memory-rule (speak ?word ?tone) :event
  (match-result ((:noise ?sound) (rule (true (mem-add (heard ?word event)))))))
(define-memory-rule (speak ?word ?) :finish
  (match-result (succeed (rule (true (mem-add (heard ?word finish)))))))
(define-memory-rule (speak ?word ?word) :finish
  (match-result (succeed (rule (true (mem-add (heard ?word same)))))))
(define-event-rule (:noise ?sound) (rule (true (mem-add (heard ?sound any)))))
(define-event-rule (:noise bang) (rule (true (mem-add (heard bang bang)))))
"""


def _asserted_by(session: History) -> list[str]:
    """Return the last argument of each fact that a rule asserts."""
    library = session.run.library.library
    rules = (*library.memory_rules, *library.event_rules)
    return re.findall(r"\(heard \S+ ([^\s)]+)", " ".join(map(format_node, rules)))


@pytest.mark.parametrize(
    ("typed", "by"),
    [
        (
            "(define-memory-rule (speak ?w ?tone) :finish"
            " (match-result (succeed (rule (true (mem-add (heard ?w new)))))))",
            ["event", "same", "new", "any", "bang"],
        ),
        (
            "(define-memory-rule (speak ?w ?w) :finish"
            " (match-result (succeed (rule (true (mem-add (heard ?w new)))))))",
            ["event", "finish", "new", "any", "bang"],
        ),
        (
            "(define-memory-rule (speak ?a ?b) :event"
            " (match-result ((:noise ?) (rule (true (mem-add (heard ?a new)))))))",
            ["finish", "same", "new", "any", "bang"],
        ),
        (
            "(define-memory-rule (speak hello ?) :finish"
            " (match-result (succeed (rule (true (mem-add (heard hello new)))))))",
            ["event", "finish", "same", "new", "any", "bang"],
        ),
        (
            "(define-event-rule (:noise ?any) (rule (true (mem-add (heard x new)))))",
            ["event", "finish", "same", "bang", "new"],
        ),
        (
            "(define-event-rule (:noise hiss) (rule (true (mem-add (heard x new)))))",
            ["event", "finish", "same", "any", "bang", "new"],
        ),
    ],
)
def test_typed_rule_replaces_the_rule_of_its_pattern(typed: str, by: list[str]) -> None:
    session = scripted(RULES, "(speak hello soft)", rows=(row("(say ?word)"),))
    _typed(session, typed)
    assert _asserted_by(session) == by
    _typed(session, typed.replace(" new)", " newer)"))
    assert _asserted_by(session) == ["newer" if one == "new" else one for one in by]


def test_typed_comparator_replaces_the_comparator_of_its_class_and_place() -> None:
    session = scripted(
        TEXT + "(declare-memory-property size (?thing (?size number)) unknown)"
        "(declare-indistinct-class cup) (declare-indistinct-class jar)"
        "(declare-class-comparator cup (score size 1))"
        "(declare-class-comparator cup attic (score size 2))"
        "(declare-class-comparator jar (score size 3))",
        "(speak)",
    )
    _typed(session, "(declare-class-comparator cup (score size 4))")
    library = session.run.library.library
    assert [int(format_node(one)[-3]) for one in library.comparators] == [2, 3, 4]


def test_typed_rule_is_refused_if_several_rules_have_its_pattern() -> None:
    rule = (
        "(define-memory-rule (speak ?w ?t) :finish"
        " (match-result (succeed (rule (true (mem-add (heard ?w {}))))))) "
    )
    session = scripted(
        RULES + rule.format("second"), "(speak hello soft)", rows=(row("(say ?word)"),)
    )
    with pytest.raises(RefusedError, match="2 rules have this pattern"):
        _typed(session, rule.format("new"))
    _typed(session, rule.format("new") + rule.format("newer"))
    assert _asserted_by(session) == ["event", "same", "new", "newer", "any", "bang"]


def test_reload_keeps_typed_rules_and_rereads_the_others(tmp_path: Path) -> None:
    file = tmp_path / "small.rap"
    file.write_text(RULES)
    session = scripted(RULES, "(speak hello soft)", rows=(row("(say ?word)"),))
    shell = Shell(session, commands(), [str(file)])
    text = "(define-event-rule (:noise ?s) (rule (true (mem-add (heard ?s {})))))"
    assert said(shell, text.format("new")) == "reloaded `event rules`\n"
    assert said(shell, ":reload") == "no definition changed\n"
    assert said(shell, text.format("newer")) == "reloaded `event rules`\n"
    file.write_text(RULES.replace("same", "alike"))
    assert said(shell, ":reload") == "reloaded `memory rules`\n"
    assert _asserted_by(session) == ["event", "finish", "alike", "bang", "newer"]


def test_source_shows_added_methods() -> None:
    shell = truck_shell()
    said(shell, "(define-method rock-order doze (primitive (eye-scan external)))")
    rows = said(shell, ":source rock-order")
    assert "(define-rap (rock-order" in rows
    assert "<typed>\n1 (define-method rock-order doze" in rows


def test_one_of_two_typed_rules_of_a_pattern_is_not_replaced_alone() -> None:
    session = _session()
    rule = (
        "(define-memory-rule (utter ?word) :finish"
        " (match-result (succeed (rule (true (mem-add ({} ?word)))))))"
    )
    declared = " ".join(
        f"(declare-memory-proposition {name} (?word))" for name in ("one", "two", "six")
    )
    _typed(session, f"{declared} {rule.format('one')} {rule.format('two')}")
    with pytest.raises(RefusedError, match="2 rules have this pattern"):
        _typed(session, rule.format("six"))
