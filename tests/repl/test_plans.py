"""Plans in the debugger: `:plan`, and `:why` of a step of a plan."""

from __future__ import annotations

from rapc.debug.history import History
from rapc.host import load
from rapc.repl.commands.table import commands
from rapc.repl.shell import Shell
from tests.repl.shells import rows, said

GOAL = "(and (delivered medicine ward-3) (docked))"


def courier_shell() -> Shell:
    history = History.open(load("examples/courier"), "courier", seed=1)
    shell = Shell(history, commands())
    shell.answer(":show none")
    return shell


def test_plan_is_shown_and_changes_nothing() -> None:
    shell = courier_shell()
    before = shell.history.run.save()
    assert rows(shell, f":plan {GOAL}") == [
        ("t1", "(fetch medicine ward-3)", "for t2: (on-tray medicine ward-3)"),
        (
            "t2",
            "(bring medicine ward-3)",
            "for the goal: (delivered medicine ward-3); before t3",
        ),
        ("t3", "(travel-to base)", "for t4: (robot-at base)"),
        ("t4", "(go-into-dock)", "for the goal: (docked)"),
    ]
    assert said(shell, f":plan {GOAL}").endswith(
        "4 steps of 5 operators, 6 states, cost 78\n"
    )
    assert shell.history.run.save() == before
    shell.answer(":assert (on-tray medicine ward-3)")
    assert rows(shell, f":plan {GOAL}")[0][1] == "(bring medicine ward-3)"


def test_submitted_plan_is_carried_out_and_repeated() -> None:
    shell = courier_shell()
    text = said(shell, f":plan {GOAL} do :priority 2")
    assert text.endswith("reloaded `achieve-1`\n[1] (achieve-1) :priority 2\n")
    shell.answer(":run")
    end = shell.history.stand()
    assert "run ended (done)" in end
    assert said(shell, GOAL) == "yes\n"
    shell.answer(":goto 2")
    shell.answer(":run")
    assert shell.history.stand() == end


def test_goal_without_a_plan_is_not_submitted() -> None:
    shell = courier_shell()
    goal = "(gives-out pharmacy meals)"
    assert said(shell, f":plan {goal}") == f"no plan: nothing brings about {goal}\n"
    assert shell.answer(f":plan {goal} do").failed
    assert shell.history.run.created == 0


def test_plan_without_steps_names_the_assumed_parts_of_the_goal() -> None:
    assert said(courier_shell(), ":plan (> 3 4)") == (
        "no step is needed\n"
        "the planner takes this part of the goal to hold: (> 3 4): "
        "a comparison of numbers\n"
        "0 steps of 5 operators, 0 states\n"
    )


def test_plan_with_invalid_options_changes_nothing() -> None:
    shell = courier_shell()
    for options, reason in (
        (":deadline x", "expected a number after :deadline"),
        ("do", "expected an option that begins with a colon, not do"),
    ):
        assert said(shell, f":plan (docked) do {options}") == f"{reason}\n"
    assert said(shell, ":plan (docked) do").endswith("[1] (achieve-1)\n")


def test_why_names_the_purpose_of_a_step_of_a_plan() -> None:
    shell = courier_shell()
    shell.answer(f":plan {GOAL} do")
    shell.answer(":step 2")
    step = shell.history.selected
    assert said(shell, f":why {step}").splitlines()[2] == (
        "It is step t1 of plan-1, for t2: (on-tray medicine ward-3)"
    )
    assert "It is step" not in said(shell, ":why 1")
