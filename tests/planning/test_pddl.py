"""PDDL of problems: what other planners read, and what their plans mean."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rapc
from rapc.planning.pddl import Pddl, written
from tests.planning.test_plans import Literals, Row, Strips, literal, literals, operator

COURIER = "examples/courier"
GOAL = "(and (delivered medicine ward-3) (docked))"
FACTS = ("(robot-at base)", "(gives-out pharmacy medicine)")
CHOICE = "(and (delivered ?goods ward-3) (or (docked) (robot-at ward-2)))"

State = frozenset[str]


class Told(NamedTuple):
    """The atoms that an action of a text needs, adds and deletes."""

    needs: State
    adds: State
    deletes: State


def atoms(text: str) -> tuple[State, State]:
    """Return the atoms of a conjunction, and those that it negates."""
    negated = frozenset(re.findall(r"\(not (\([^()]*\))\)", text))
    rest = re.sub(r"\(not \([^()]*\)\)", "", text)
    found = re.findall(r"\((?!and\b)[^()]*\)", rest)
    return frozenset(found), negated


def actions(text: str) -> Mapping[str, Told]:
    """Return the actions of a domain by name."""
    found = {}
    plain = re.sub(r";.*", "", text)
    for part in plain.split("(:action ")[1:]:
        needs, effects = part.split(":effect")
        found[part.split()[0]] = Told(
            atoms(needs.split(":precondition")[1])[0], *atoms(effects)
        )
    return found


def solves(found: Pddl, names: Sequence[str]) -> bool:
    """Return whether actions lead from the beginning to the goal of a text."""
    begin, goal = re.sub(r";.*", "", found.problem).split(":init")[1].split(":goal")
    state, known = atoms(begin)[0], actions(found.domain)
    for name in names:
        if not state >= known[name].needs:
            return False
        state = state - known[name].deletes | known[name].adds
    return state >= atoms(goal)[0]


@settings(max_examples=60, deadline=None)
@given(
    st.lists(operator(), min_size=1, max_size=5),
    st.sets(literal(()).map(lambda one: one[1]), max_size=5),
    literals((), 3),
)
def test_plan_of_the_search_solves_the_text(
    operators: list[Row], facts: set[tuple[str, ...]], goal: Literals
) -> None:
    solution = Strips(operators, facts, goal).plan()
    if solution.sketch is None or solution.problem is None:
        return
    text = written(solution.problem)
    names = {id(action): name for name, action in text.actions.items()}
    steps = [names[id(action)] for action in solution.sketch.actions]
    tests = [name for name, action in text.actions.items() if action is None]
    assert solves(text, [*steps, *tests])
    assert solves(text, tests) == (not steps)


def library(*names: str) -> rapc.CheckedLibrary:
    """Return a library with a proposition and an operator for each name."""
    return rapc.loads(
        "".join(
            f"(declare-memory-proposition {name} ()) "
            f"(define-rap ({name}) (effects ({name}))) "
            for name in names
        ),
        check=False,
    )


@settings(max_examples=60, deadline=None)
@given(
    st.sets(st.sampled_from(["and-1", "on", "on-", "on_", "total-cost", "ü", "7up"]))
)
def test_names_are_those_that_pddl_allows(names: set[str]) -> None:
    goal = f"(and {' '.join(f'({one})' for one in sorted(names))})"
    plan = rapc.plan(library(*sorted(names)), goal)
    texts = plan.pddl()
    assert texts is not None
    found = list(actions(texts[0]))
    assert len(found) == len(set(found)) == len(names)
    assert all(re.fullmatch("[a-z][a-z0-9_-]*", one) for one in found)
    assert "total-cost" not in found


def test_comments_do_not_end_before_the_line_does() -> None:
    found = rapc.loads(
        "(declare-memory-proposition noted (?text))"
        "(declare-memory-proposition read (?text))"
        "(define-rap (learn ?text) (preconditions (noted ?text))"
        "  (effects (read ?text)))",
        check=False,
    )
    fact = ("noted", rapc.world.Text("a\n(b"))
    texts = rapc.plan(found, "(read ?)", facts=[fact]).pddl()
    assert texts is not None
    assert list(actions(texts[0])) == ["learn_a-b"]
    assert "\n(b" not in texts[0]


def test_costs_are_written_if_they_differ() -> None:
    found = rapc.loads(
        "(declare-memory-proposition warm ()) (declare-memory-proposition cold ())"
        "(define-rap (heat) (duration 30) (effects (warm)))"
        "(define-rap (cool) (duration 7) (effects (cold)))",
        check=False,
    )
    plan = rapc.plan(found, "(and (warm) (cold))")
    with_costs, without = plan.pddl(), plan.pddl(costs=False)
    assert with_costs is not None
    assert without is not None
    assert "(increase (total-cost) 30)" in with_costs[0]
    assert "(:metric minimize (total-cost))" in with_costs[1]
    assert "total-cost" not in "".join(without)


def exported(tmp_path: Path, goal: str) -> tuple[Path, Path]:
    texts = rapc.plan(rapc.load(COURIER), goal, facts=FACTS).pddl()
    assert texts is not None
    files = tmp_path / "domain.pddl", tmp_path / "problem.pddl"
    for file, text in zip(files, texts, strict=True):
        file.write_text(text)
    return files


@pytest.mark.skipif(find_spec("pyperplan") is None, reason="requires pyperplan")
@pytest.mark.parametrize("goal", [GOAL, CHOICE])
def test_pyperplan_solves_the_text(tmp_path: Path, goal: str) -> None:
    domain, problem = exported(tmp_path, goal)
    command = [sys.executable, "-m", "pyperplan", "-s", "gbf", "-H", "hff"]
    command += [str(domain), str(problem)]
    subprocess.run(command, check=True, capture_output=True)
    plan = rapc.plan(rapc.load(COURIER), goal, facts=FACTS)
    texts = plan.pddl()
    assert texts is not None
    names = re.findall(r"\((\S+)\)", Path(f"{problem}.soln").read_text())
    assert solves(Pddl(*texts, {}), names)


@pytest.mark.nightly
@pytest.mark.skipif(
    find_spec("unified_planning") is None, reason="requires `[engines]`"
)
@pytest.mark.parametrize("goal", [GOAL, CHOICE])
def test_unified_planning_reads_the_text(tmp_path: Path, goal: str) -> None:
    domain, problem = exported(tmp_path, goal)
    code = (
        "import sys; from unified_planning.io import PDDLReader; "
        "print(len(PDDLReader().parse_problem(*sys.argv[1:]).actions))"
    )
    command = [sys.executable, "-c", code, str(domain), str(problem)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert int(done.stdout) == len(actions(domain.read_text()))
