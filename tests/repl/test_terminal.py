"""The prompt as a person meets it: on a pseudo-terminal of three widths."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.repl.complete import candidates
from rapc.repl.prompt import history_file
from tests.effort import first
from tests.repl.shells import truck_shell
from tests.repl.terminal import Terminal

TASK = ("--task", "(rock-order red 1)", "--seed", "7")


@pytest.mark.parametrize("columns", first(1, [40, 80, 200]))
def test_a_session_on_a_terminal(columns: int, tmp_path: Path) -> None:
    terminal = Terminal(columns, tmp_path, *TASK)
    terminal.see("Ctrl-D quits")
    terminal.ask(":show none", "shown after each step: none")
    terminal.ask(":step 3", "cycle 3, time 0")
    terminal.ask(":back", "cycle 2, time 0")
    terminal.ask("(and (place ?p quarry)\r(produces ?p rock))", "quarry-3")
    terminal.ask(":stpe", "did you mean `:step`?")
    terminal.ask(":why", "was selected in cycle 2")
    screen = terminal.ask(":agenda", "its method")
    assert all(len(line) <= columns for line in screen)
    assert terminal.leave() == 0


def test_tab_completes_and_the_toolbar_says_where_it_stands(tmp_path: Path) -> None:
    terminal = Terminal(100, tmp_path, *TASK)
    terminal.see("time 0  cycle 0")
    terminal.press(":primi\t")
    terminal.see("rapc> :primitive")
    terminal.press("\r")
    terminal.see("primitive operation (truck-")
    terminal.see("for [1] (rock-order red 1)")
    assert terminal.leave() == 0


def test_ctrl_c_clears_the_line_and_twice_leaves(tmp_path: Path) -> None:
    terminal = Terminal(80, tmp_path, *TASK)
    terminal.see("Ctrl-D quits")
    terminal.press("(and (place")
    terminal.see("(and (place")
    terminal.press("\x03")
    terminal.see("press Ctrl-C again to quit")
    terminal.ask(":step", "cycle 1, time 0")
    terminal.clear()
    terminal.press("\x03")
    terminal.see("press Ctrl-C again to quit")
    assert terminal.leave("\x03") == 0


def test_error_before_the_prompt_breaks_no_name(tmp_path: Path) -> None:
    terminal = Terminal(46, tmp_path, "--fact", "(truck-location depot dept)")
    terminal.see("takes 1 argument")
    words = " ".join(terminal.lines()).split()
    assert {"`truck-location`", "argument,", "(truck-location"} <= {*words}
    assert all(len(line) <= 46 for line in terminal.lines())


@pytest.mark.parametrize("erased", ["", "\x7f" * 6])
def test_ctrl_c_does_not_leave_after_typing(erased: str, tmp_path: Path) -> None:
    terminal = Terminal(80, tmp_path, *TASK)
    terminal.see("Ctrl-D quits")
    terminal.press("\x03")
    for _ in range(2):
        terminal.see("press Ctrl-C again to quit")
        terminal.press(":agend")
        terminal.see("rapc> :agend")
        terminal.clear()
        terminal.press(f"{erased}\x03")
    terminal.see("press Ctrl-C again to quit")
    terminal.ask(":step", "cycle 1, time 0")
    assert terminal.leave() == 0


def test_ctrl_c_pauses_a_run(tmp_path: Path) -> None:
    """The run takes some 40,000 cycles: Ctrl-C is not too late on a busy machine."""
    orders = [word for _ in range(60) for word in ("--task", "(rock-order red 4)")]
    terminal = Terminal(100, tmp_path, *orders, "--set", "truck.fuel-use=0")
    terminal.see("Ctrl-D quits")
    terminal.ask(":show none", "shown after each step: none")
    terminal.clear()
    terminal.press(":run\r")
    terminal.until_carried_out()
    terminal.child.sendintr()
    terminal.see("paused")
    assert terminal.leave() == 0


def test_inputs_are_kept_for_each_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    one, other = history_file("one/robot"), history_file("two/robot")
    assert one != other
    assert one == history_file(str(tmp_path / "one" / "robot"))
    assert one.name.startswith("robot-")
    assert history_file(None).name.startswith("typed-")


def test_inputs_are_kept_from_one_session_to_the_next(tmp_path: Path) -> None:
    terminal = Terminal(80, tmp_path, *TASK)
    terminal.see("Ctrl-D quits")
    terminal.ask(":to 7", "cycle 7, time 0")
    terminal.leave()
    [kept] = (tmp_path / ".local/state/rapc/inputs").iterdir()
    assert ":to 7" in kept.read_text()
    again = Terminal(80, tmp_path, *TASK)
    again.see("Ctrl-D quits")
    again.see("cycle 0")
    again.press("\x1b[A")
    again.see("rapc> :to 7")
    again.press("\r")
    again.see("cycle 7, time 0")
    assert again.leave() == 0


# --- what the prompt asks the house ---------------------------------------------------


def _texts(text: str) -> list[str]:
    shell = truck_shell()
    return [one.text for one in candidates(shell, text)]


@pytest.mark.parametrize(
    ("text", "offered"),
    [
        (":st", ":step"),
        (":help got", "goto"),
        (":source fill", "fill-order"),
        (":out ", "1"),
        (":break ", "primitive"),
        (":break rap trav", "travel-road"),
        (":break fact (loc", "location"),
        (":find back task-f", "task-failed"),
        (":history item-1 col", "color"),
        (":diff bra", "branch"),
        (":diff branch ma", "main"),
        (":diff library exam", "examples/"),
        (":waits ", "1"),
        ("(rock-o", "rock-order"),
        ("(truck-loc", "truck-location"),
        ("(place quarry-", "quarry-1"),
        ("(define-r", "define-rap"),
        ("(define-rap (x) (suc", "succeed"),
        ("(define-rap (x) (method (primitive (truck-m", "truck-move"),
        ("(define-rap (x) (succeed (truck-loc", "truck-location"),
    ],
)
def test_completion_offers_matching_words(text: str, offered: str) -> None:
    assert offered in _texts(text)


def test_nothing_else_is_offered() -> None:
    assert _texts("(frobnicate") == []
    assert _texts(":help frob") == []


def test_names_come_with_a_line_on_them() -> None:
    shell = truck_shell()
    [found] = [
        one for one in candidates(shell, "(truck-loc") if one.text == "truck-location"
    ]
    assert found.doc.startswith("(truck-location ?")
    assert found.replaces == len("truck-loc")
