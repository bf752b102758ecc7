"""`rapc plan`: a plan for a goal that no RAP has."""

from __future__ import annotations

import json
from pathlib import Path

import rapc as package
from tests.cli.command import rapc

COURIER = "examples/courier"
GOAL = "(and (delivered medicine ward-3) (docked))"


def test_plan_is_printed_as_steps_with_links() -> None:
    done = rapc("plan", GOAL, COURIER, "--world", "courier", "--format", "steps")
    assert done.returncode == 0
    assert done.stdout.splitlines() == [
        "t1 (fetch medicine ward-3)  for t2: (on-tray medicine ward-3)",
        "t2 (bring medicine ward-3)  for the goal: (delivered medicine ward-3); "
        "before t3",
        "t3 (travel-to base)         for t4: (robot-at base)",
        "t4 (go-into-dock)           for the goal: (docked)",
        "4 steps of 5 operators, 6 states, cost 78",
    ]


def test_plan_begins_with_the_given_facts() -> None:
    fact = "(on-tray medicine ward-3)"
    done = rapc("plan", GOAL, COURIER, "--fact", fact, "--format", "json")
    plan = json.loads(done.stdout)
    assert [step["goal"] for step in plan["steps"]] == [
        "(bring medicine ward-3)",
        "(travel-to base)",
        "(go-into-dock)",
    ]
    assert plan["reason"] == "solved"


def test_unreachable_parts_of_the_goal_are_named() -> None:
    done = rapc("plan", GOAL, COURIER, "--use", "travel-to")
    assert done.returncode == 1
    wanted = "(delivered medicine ward-3), (docked)"
    assert done.stdout == f"no plan: nothing brings about {wanted}\n"


def test_missing_operators_and_facts_are_named(tmp_path: Path) -> None:
    library = tmp_path / "a.rap"
    library.write_text("(declare-memory-proposition warm ())\n(define-rap (wait))\n")
    done = rapc("plan", "(warm)", str(library))
    said = "no plan: nothing brings about (warm): no RAP is an operator\n"
    assert (done.returncode, done.stdout, done.stderr) == (1, said, "")

    library.write_text(
        "(declare-memory-proposition warm ())\n"
        "(declare-memory-proposition fire ())\n"
        "(define-rap (wait) (preconditions (fire)) (effects (warm)))\n"
    )
    done = rapc("plan", "(warm)", str(library))
    assert done.stdout == "no plan: nothing brings about (warm)\n"
    assert done.stderr == "note: memory has no facts; use --world or --fact\n"
    assert rapc("plan", "(warm)", str(library), "--fact", "(fire)").stderr == ""


def test_parts_that_the_planner_leaves_out_are_listed(tmp_path: Path) -> None:
    library = tmp_path / "a.rap"
    library.write_text(
        "(declare-memory-proposition warm ())\n"
        "(declare-memory-property heat (?level) 0)\n"
        "(define-rap (wait-long)\n"
        "  (preconditions (and (heat ?level) (> ?level 3)))\n"
        "  (effects (warm)))\n"
    )
    done = rapc("plan", "(warm)", str(library), "--explain")
    said = "preconditions of `wait-long`: (> ?level 3): a comparison of numbers"
    assert f"left out: {library}:4:37: {said}\n" in done.stdout


def test_parts_of_the_goal_that_the_planner_leaves_out_are_named(
    tmp_path: Path,
) -> None:
    library = tmp_path / "a.rap"
    library.write_text("(declare-memory-property heat (?level) 0)\n")
    goal = "(and (heat ?level) (> ?level 3))"
    done = rapc("plan", goal, str(library), "--format", "steps")
    assert done.stderr == (
        "note: the planner takes this part of the goal to hold: (> ?level 3): "
        "a comparison of numbers\n"
    )
    assert done.stdout == "0 steps of 0 operators, 0 states\n"


def test_kept_plan_is_a_library(tmp_path: Path) -> None:
    kept = tmp_path / "kept.rap"
    done = rapc("plan", GOAL, COURIER, "--world", "courier", "--keep", str(kept))
    assert done.returncode == 0
    assert "achieve-1" in package.load(kept).raps


def test_plan_is_run() -> None:
    done = rapc("-q", "plan", GOAL, COURIER, "--world", "courier", "--run")
    assert done.returncode == 0
    assert done.stdout.splitlines()[-1] == f"{GOAL}: succeeded"


def test_later_situation_is_that_of_a_run() -> None:
    task = ("--task", "(fetch medicine ward-3)")
    options = ("--world", "courier", *task, "--after", "60", "--format", "steps")
    done = rapc("plan", GOAL, COURIER, *options)
    assert done.stdout.startswith("t1 (bring medicine ward-3)")


def test_problem_is_exported_as_pddl(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "pddl"
    options = ("--world", "courier", "--export", str(folder))
    assert rapc("plan", GOAL, COURIER, *options).returncode == 0
    assert "(:action go-into-dock" in (folder / "domain.pddl").read_text()
    assert "(delivered_medicine_ward-3) (docked)" in (
        (folder / "problem.pddl").read_text()
    )
    (tmp_path / "file").touch()
    done = rapc("plan", GOAL, COURIER, "--export", str(tmp_path / "file" / "x"))
    assert done.returncode == 2
    assert done.stderr.startswith("error: --export: cannot create")


def test_problem_is_exported_to_the_working_directory(tmp_path: Path) -> None:
    library = tmp_path / "a.rap"
    library.write_text("(declare-memory-proposition warm ())\n")
    done = rapc("plan", "(warm)", "a.rap", "--export", "", cwd=tmp_path)
    assert done.returncode == 1
    names = ["a.rap", "domain.pddl", "problem.pddl"]
    assert sorted(one.name for one in tmp_path.iterdir()) == names


def test_invalid_time_limit_is_refused_before_the_plan() -> None:
    options = ("--world", "courier", "--run", "--until", "-1")
    done = rapc("plan", GOAL, COURIER, *options)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "error: --until must not be negative\n"


def test_invalid_input_is_refused() -> None:
    for options, said in (
        (("(delivred a b)", COURIER), "unknown predicate `delivred`"),
        ((GOAL, COURIER, "--use", "deliver"), "cannot use `deliver`"),
        ((GOAL, COURIER, "--run"), "--run and --after require --world"),
        ((GOAL, COURIER, "--priority", "3"), "--priority requires --run"),
        ((GOAL, COURIER, "--until", "3"), "--until requires --run"),
        ((GOAL, COURIER, "--strips"), "--strips requires --export or --engine"),
    ):
        done = rapc("plan", *options)
        assert done.returncode == 2
        assert said in done.stderr


def test_run_without_tasks_is_not_over_after_a_time() -> None:
    options = ("--world", "courier", "--after", "1", "--run")
    done = rapc("plan", "(docked)", COURIER, *options)
    assert done.returncode == 0
    assert done.stdout.endswith("(docked): succeeded\n")
