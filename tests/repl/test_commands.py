"""Each command that moves or looks, and what is said where it cannot be."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rapc.debug.arguments import is_balanced, split
from rapc.repl.commands.table import commands
from rapc.repl.script import inputs
from rapc.repl.shell import Shell
from tests.cli.command import rapc
from tests.debug.sessions import row, scripted
from tests.repl.shells import rows, said, truck_shell


def test_step_shows_events_and_position() -> None:
    shell = truck_shell()
    text = said(shell, ":step")
    assert "--> considering (rock-order red 1) [1]" in text
    assert text.endswith("cycle 1, time 0\n")
    assert said(shell, ":show none", ":step 4") == "cycle 5, time 0\n"


def test_out_parent_and_primitive_stop_where_they_say() -> None:
    shell = truck_shell()
    shell.answer(":show none")
    shell.answer(":step 15")
    number = shell.history.selected
    assert number is not None
    assert f"task [{number}] has ended" in said(shell, ":out")
    text = said(shell, ":goto 16", ":parent 19")
    assert "task [15] was selected" in text or "task [15] has ended" in text
    assert shell.history.selected == 15
    shell.answer(":show requests")
    assert said(shell, ":primitive").count("primitive operation") == 1
    assert said(shell, ":parent 1") == "a top-level task has no parent\n"


def test_to_goes_forth_and_goto_goes_back() -> None:
    shell = truck_shell()
    shell.answer(":show none")
    assert said(shell, ":to 40").startswith("cycle 40,")
    assert said(shell, ":to 20") == "cycle 20 is in the past; use `:goto 20`\n"
    assert said(shell, ":back 10").startswith("cycle 30,")
    assert said(shell, ":goto at 50").startswith("cycle 28,")
    assert said(shell, ":goto end").startswith("cycle 40,")
    assert "run ended (done)" in said(shell, ":run")


def test_tables_show_the_current_state() -> None:
    shell = truck_shell()
    shell.answer(":step 12")
    assert (1, "(rock-order red 1)", "running", None, None, None, "its method") in rows(
        shell, ":agenda"
    )
    assert rows(shell, ":tree")[0][:2] == ("[1] (rock-order red 1)", "running")
    assert [row[0] for row in rows(shell, ":chain 9")] == [9, 8, 7, 5, 3, 2, 1]
    assert ("state", "running") in rows(shell, ":task 9")
    assert ("(truck-location depot)", 0, 2) in rows(shell, ":memory truck-location")
    assert ("truck-location", 1) in rows(shell, ":memory")
    assert rows(shell, ":memory (place ?where quarry)")
    assert rows(shell, ":monitors")[0][0] == 6
    assert "no requests under way" in said(shell, ":requests")
    assert "no held things" in said(shell, ":claims")
    assert "* depot" in [row[0] for row in rows(shell, ":world")]
    assert "(define-rap (travel-road" in said(shell, ":source 9")
    assert "(define-rap (rock-order" in said(shell, ":source rock-order")
    assert rows(shell, ":goto at 240", ":items")


def test_queries_are_asked_and_their_answers_kept() -> None:
    shell = truck_shell()
    found = rows(shell, "(and (place ?p quarry) (produces ?p ?what))")
    assert len(found) == 3
    assert said(shell, "(place depot quarry)") == "no\n"
    assert said(shell, "(truck-status ready)") in ("yes\n", "no\n")
    assert rows(shell, "*3") == found
    assert "did you mean `place`" in said(shell, "(plaec ?x ?y)")


def test_answers_show_small_numbers_and_strings_as_rap_text() -> None:
    text = """
    (declare-memory-proposition p (?x))
    :assert (p 0.0000000000000000000000001)
    (p ?x)
    :erase (p)
    :assert (p "a b")
    (p ?x)
    """
    done = rapc("repl", stdin=text)
    assert "0.0000000000000000000000001" in done.stdout
    assert '"a b"' in done.stdout.splitlines()[-1]
    told = [
        json.loads(line)
        for line in rapc("repl", "--json", stdin=text).stdout.splitlines()
    ]
    assert told[2]["rows"] == [{"?x": 1e-25}]
    assert told[5]["rows"] == [{"?x": '"a b"'}]


def test_goals_are_submitted() -> None:
    shell = truck_shell()
    assert said(shell, "(rock-order blue 1) :priority 2") == (
        "[2] (rock-order blue 1) :priority 2\n"
    )
    assert "submitted for a later time" in said(shell, "(rock-order blue 1) :at 99")
    assert "`rock-order` has 2 inputs, not 1" in said(shell, "(rock-order blue)")


def test_branches_are_listed_and_taken_up() -> None:
    shell = truck_shell()
    shell.answer(":show none")
    text = said(shell, ":step 30", ":back 10", "(rock-order blue 1)", ":branches")
    assert "main at cycle 20" in text
    assert "20: submitted (rock-order blue 1)" in text
    assert said(shell, ":branch main").startswith("now on main\ncycle 20,")
    assert said(shell, ":branch other").startswith("now on other\n")


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        (":stpe", "unknown command `:stpe`; did you mean `:step`?"),
        (":step x", "number of cycles must be a whole number, not `x`"),
        (":step 1 2", "unexpected argument `2`"),
        (":assert (truck-status ready) 2", "unexpected argument `2`"),
        (":to", "missing cycle"),
        (":goto at noon", "time must be a number, not `noon`"),
        (":task 99", "unknown task [99]"),
        (":out", "no current task; give a task number"),
        (":source frob", "no definition of `frob`"),
        (":source fil-order", "no definition of `fil-order`; did you mean `fill-"),
        (":source no.rap:3", "no definition at no.rap:3"),
        (":memory fill-order", "RAP `fill-order` is not in memory"),
        (":show some", "expected all, requests, none, not `some`"),
        (":help stpe", "unknown command `:stpe`; did you mean `:step`?"),
        ("hello", "expected a command (`:help`) or a RAP form, not `hello`"),
        ("(", "a parenthesis or string is not closed"),
        ("*2", "no answer `*2`"),
        (":memory frob", "unknown predicate `frob`"),
        (
            ":break rap",
            "breakpoint `rap` requires an argument: a task of a RAP is selected",
        ),
        (":break fact (truck-locaton ?)", "unknown predicate `truck-locaton`; did you"),
        (":break primitive (arm-grap ?)", "unknown primitive `arm-grap`; did you"),
        (
            ":find task-failed gaol=x",
            "`task-failed` has no key `gaol`; its keys are n, cycle,",
        ),
        (":why failed 99", "unknown task [99]"),
    ],
)
def test_impossible_breakpoint_is_reported(text: str, answer: str) -> None:
    shell = truck_shell()
    found = shell.answer(text)
    assert found.failed
    assert found.lines[0].startswith(answer)


def test_rap_name_stands_for_its_live_task() -> None:
    shell = truck_shell()
    shell.answer(":step 12")
    assert said(shell, ":why-not ROCK-order") == said(shell, ":why-not 1")
    assert rows(shell, ":chain rock-order") == rows(shell, ":chain 1")
    shell.answer("(rock-order blue 1)")
    told = said(shell, ":why-not rock-order")
    assert "[1] (rock-order red 1), [" in told
    assert "(rock-order blue 1); give a number" in told
    shell.answer(":show none")
    shell.answer(":run")
    assert said(shell, ":why-not load-weapon") == "`load-weapon` has no live task\n"
    assert "has no live task; its last task was [" in said(shell, ":fail rock-order")


@pytest.mark.parametrize("command", [":why", ":why-not", ":waits", ":chain"])
def test_rap_name_stands_for_its_last_task_if_none_is_live(command: str) -> None:
    shell = truck_shell()
    shell.answer("(rock-order blue 1)")
    shell.answer(":show none")
    shell.answer(":run")
    answer = shell.answer(f"{command} rock-order")
    assert not answer.failed, answer.lines
    assert answer == shell.answer(f"{command} 2")
    assert answer != shell.answer(f"{command} 1")


def test_why_failed_takes_the_name_of_a_rap_without_live_tasks() -> None:
    session = scripted(
        "(declare-primitive say (?word) (okay hoarse))"
        "(define-rap (speak) (method (primitive (say hello))))",
        "(speak)",
        rows=(row("(say ?word)", "hoarse"),),
    )
    shell = Shell(session, commands())
    shell.answer(":run")
    told = said(shell, ":why failed speak")
    assert told.startswith("[1] (speak) failed in cycle ")
    assert told == said(shell, ":why failed 1")


def test_empty_lists_after_the_end_name_the_last_cycle() -> None:
    session = scripted(
        "(declare-primitive look () (okay)) (declare-memory-proposition wet (?place))"
        "(define-rap (go) (method (primitive (look))))"
        "(define-rap (guard) (monitor-state (wet attic)) (method (primitive (look))))",
        "(go)",
        "(guard) :background true",
        rows=(row("(look)"),),
    )
    shell = Shell(session, commands())
    shell.answer(":run")
    note = f"run over; see `:goto {session.cycle}`"
    assert said(shell, ":agenda") == f"no tasks under way: {note}\n"
    assert said(shell, ":monitors") == f"no monitors: {note}\n"
    shell.answer(f":goto {session.cycle}")
    assert "(guard)" in said(shell, ":agenda")
    assert "(guard)" in said(shell, ":monitors")
    assert said(truck_shell(), ":monitors") == "no monitors\n"


def test_ended_task_is_still_shown() -> None:
    shell = truck_shell()
    shell.answer(":run")
    assert "(define-rap (travel-for-rocks" in said(shell, ":source 5")
    assert "task [5] has ended: ask at an earlier moment" in said(shell, ":task 5")
    assert "has no clause `constraints`" in said(shell, ":why-not 5 constraints")
    told = said(shell, ":history truck-location")
    assert "for a fact, use `:history (truck-location)`" in told


@pytest.mark.parametrize("command", [":record", ":break save"])
def test_source_of_the_run_is_not_overwritten(command: str, tmp_path: Path) -> None:
    library = tmp_path / "lib.rap"
    text = '(require "truck")\n(define-rap (rest) (succeed t))\n'
    library.write_text(text)
    script = f"{command} {library}\n{command} {tmp_path / 'other'}\n"
    args = ("--world", "truck", "--task", "(rest)")
    done = rapc("repl", str(library), *args, stdin=script)
    assert done.returncode == 1
    told = " ".join(done.stdout.split())
    assert "is a source file of the library or of the world" in told
    assert library.read_text() == text
    assert (tmp_path / "other").exists()


def test_a_line_of_a_trace_goes_on_behind_its_time_and_mark() -> None:
    shell = truck_shell()
    lines = said(shell, ":step 30", width=40).splitlines()
    at = next(n for n, line in enumerate(lines) if line.endswith("operation"))
    assert lines[at].startswith("   30.5     ... primitive")
    assert lines[at + 1].startswith(" " * 16 + "(")


def test_help_knows_every_command_with_examples() -> None:
    shell = truck_shell()
    listed = said(shell, ":help")
    for command in commands():
        assert f":{command.name}" in listed
        assert command.examples, command.name
        told = said(shell, f":help {command.name}")
        assert command.doc in told.replace("\n", " ")
        assert command.examples[0] in told


@pytest.mark.parametrize("width", [40, 80, 200])
def test_answers_keep_to_the_width(width: int) -> None:
    shell = truck_shell()
    shell.answer(":step 12")
    for text in (":agenda", ":tree", ":help", ":monitors", ":world", ":trace 3"):
        drawn = said(shell, text, width=width)
        assert max(map(len, drawn.splitlines())) <= width, text


@pytest.mark.parametrize("width", [40, 60, 80, 120])
def test_tables_break_no_name(width: int) -> None:
    shell = truck_shell("(rock-order red 1) :deadline 900", "(rock-order blue 2)")
    shell.answer(":step 30")
    for text in (":agenda", ":tree", ":monitors", ":help", ":memory place"):
        wide = [word.strip(":") for word in said(shell, text, width=400).split()]
        words = [word.strip(":") for word in said(shell, text, width=width).split()]
        assert {w for w in words if "\u2500" not in w} <= {*wide}, text


def test_records_of_a_narrow_table_are_told_apart() -> None:
    shell = truck_shell("(rock-order red 1) :deadline 900")
    lines = said(shell, ":step 12", ":agenda", width=40).splitlines()
    heads = [line for line in lines if line.startswith("task ")]
    assert heads[0] == "task 1: (rock-order red 1)"
    assert len(heads) == len(rows(shell, ":agenda"))
    assert lines.count("") == len(heads) - 1
    assert "  deadline: 900" in lines


def test_further_lines_of_a_tree_begin_deeper() -> None:
    shell = truck_shell()
    lines = said(shell, ":step 30", ":tree", width=60).splitlines()
    at = next(n for n, line in enumerate(lines) if line.startswith("  ["))
    assert lines[at + 1].startswith("    ")


def test_inputs_may_go_over_several_lines() -> None:
    lines = ["; a word", "", "(and (p ?x)", "     (q ?x))", ":step", '(say "a (b")']
    assert [text for text in inputs(lines) if not text.startswith(";")] == [
        "(and (p ?x)\n     (q ?x))",
        ":step",
        '(say "a (b")',
    ]
    assert is_balanced("(a ; no ) here\n)")
    assert split('12 (a (b "c)")) take') == ["12", '(a (b "c)"))', "take"]


def test_answers_come_in_pages() -> None:
    shell = truck_shell()
    first = rows(shell, "(and (place ?one ?x) (place ?two ?y))")
    assert len(first) == 50
    second = rows(shell, ":more")
    assert not set(first) & set(second)
    while "more with `:more`" in said(shell, ":more"):
        pass
    assert said(shell, ":more") == "no more solutions\n"
    assert rows(shell, "*1") == first


@pytest.mark.parametrize(
    "text",
    [
        "(lies ?x 4)",
        ":memory (lies ?x 4)",
        ":why-not (lies ?x 4)",
        ":watch (lies ?x 4)",
    ],
)
def test_queries_with_wrong_kind_are_refused_as_assert_is(text: str) -> None:
    shell = Shell(scripted(LISTENING, "(top)", rows=(row("(act)"),)), commands())
    reason = (
        "`4` is not a value of kind place, as declared for "
        "`?where` in `(lies ?what ?where)`"
    )
    assert reason in said(shell, ":assert (lies box 4)")
    answer = shell.answer(text)
    assert (answer.failed, answer.lines) == (True, (reason,))


def test_signal_wakes_waiting_tasks_and_unknown_signal_is_refused() -> None:
    shell = Shell(scripted(LISTENING, "(top)", rows=(row("(act)"),)), commands())
    assert "unknown event `:rung`; did you mean `:ring`?" in said(
        shell, ":signal (:rung hall)"
    )
    assert "`4` is not a value of kind place" in said(shell, ":signal (:ring 4)")
    assert "expected a name with a colon" in said(shell, ":signal (ring hall)")
    assert "no " not in said(shell, ":signal (:ring hall)")
    said(shell, ":step 1", ":signal (:ring hall)")
    assert "run ended (done)" in said(shell, ":run")


LISTENING = """
(declare-kind place)
(declare-event :ring ((?where place)))
(declare-memory-proposition lies (?what (?where place)))
(declare-primitive act () (okay))
(define-rap (top) (method (task-net (t1 (go) (wait-for (:ring hall) :proceed)))))
(define-rap (go) (method (primitive (act))))
"""


def test_without_a_library_rap_text_can_be_tried() -> None:
    text = """
    (declare-memory-proposition at (?who ?where))
    (define-rap (be-at ?where) (succeed (at robot ?where)))
    :assert (at robot hall)
    (at ?who ?where)
    (be-at hall)
    :run
    (declare-primitive walk (?where) (okay))
    :reload
    """
    done = rapc("repl", "--json", stdin=text)
    records = [json.loads(line) for line in done.stdout.splitlines()]
    assert records[3]["rows"] == [{"?who": "robot", "?where": "hall"}]
    assert "task accomplished (be-at hall) [1]" in " ".join(records[5]["lines"])
    refused = {r["input"]: r["lines"] for r in records if r["failed"]}
    assert list(refused) == ["(declare-primitive walk (?where) (okay))", ":reload"]
