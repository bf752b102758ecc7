"""A planning problem as PDDL, for other planners.

The text has no variables: a predicate is an atom of the problem, that is a fact that is
present or a fact that is absent, and an action is an instance of an operator. Another
planner solves the problem that the search of rapc solves. Names are those of the
library, without the characters that PDDL does not allow.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rapc.base.values import format_atom, format_list
from rapc.base.visible import visible
from rapc.library.operators import FRESH
from rapc.planning.ground import Action, Problem
from rapc.planning.search import Goal, reduced

_RESERVED = frozenset(
    {"all", "always", "and", "at", "define", "domain", "either", "end", "exists"}
    | {"forall", "imply", "increase", "metric", "not", "object", "objects", "or"}
    | {"over", "problem", "sometime", "start", "total-cost", "total-time", "when"}
)
"""Words that readers of PDDL do not accept as names."""

_LONGEST = 60
"""The greatest number of characters of a name, without its number."""


class Pddl(NamedTuple):
    """A problem as text, with the meaning of its actions."""

    domain: str
    problem: str
    #: The actions by name; None for an action that only tests the goal.
    actions: Mapping[str, Action | None]


class _Row(NamedTuple):
    """An action as text."""

    needs: Sequence[str]
    effects: Sequence[str]
    comment: str


class _Names:
    """Names that PDDL allows; each is given once."""

    def __init__(self) -> None:
        self._taken = set(_RESERVED)
        #: The next number for a name that is taken.
        self._numbers: dict[str, int] = {}

    def new(self, *parts: str) -> str:
        """Return a new name that consists of parts."""
        plain = [re.sub(r"[^a-z0-9-]+", "-", one.lower()).strip("-") for one in parts]
        name = "_".join([one or "x" for one in plain])[:_LONGEST]
        name = name if name[0].isalpha() else f"x{name}"
        found = name
        while found in self._taken:
            number = self._numbers[name] = self._numbers.get(name, 1) + 1
            found = f"{name}_{number}"
        self._taken.add(found)
        return found


def written(problem: Problem, *, costs: bool = True) -> Pddl:
    """Return a problem as PDDL.

    Args:
        problem: the problem.
        costs: whether actions have their costs, if these are different whole numbers.
    """
    goal, actions, always = reduced(problem)
    atoms = [at for branch in goal for ways in branch for way in ways for at in way]
    atoms += [at for one in actions for at in one.needs if at not in always]
    names = _Names()
    terms: dict[int, str] = {}
    predicates: dict[str, str] = {}
    for at in dict.fromkeys(atoms):
        present, fact = problem.literals[at]
        parts = ["-".join(map(str, n)) if isinstance(n, tuple) else n for n in fact]
        name = names.new(*([] if present else ["not"]), *map(format_atom, parts))
        terms[at] = f"({name})"
        predicates[terms[at]] = str(problem.literals[at])
    found: dict[str, Action | None] = {}
    rows: dict[str, _Row] = {}
    counts = {one.cost for one in actions}
    costs = costs and len(counts) > 1 and all(float(one).is_integer() for one in counts)
    for one in actions:
        effects = [f"(not {terms[at]})" for at in one.deletes if at in terms]
        effects += [terms[at] for at in one.adds if at in terms]
        if costs:
            effects.append(f"(increase (total-cost) {int(one.cost)})")
        rap = one.operator.rap
        given = {arg.name for arg in (*rap.inputs, *rap.outputs)}
        others = [
            value
            for name, value in sorted(one.values.items())
            if name not in given and not name.startswith(FRESH)
        ]
        name = names.new(*map(format_atom, (*one.goal, *others)))
        found[name] = one
        needs = [terms[at] for at in one.needs if at in terms]
        rows[name] = _Row(needs, effects, format_list(one.goal))
    start = [terms[at] for at in sorted(problem.state) if at in terms]
    if len(goal) == 1 and all(len(ways) == 1 for ways in goal[0]):
        wanted = [terms[at] for ways in goal[0] for at in ways[0]]
    else:
        acting, done = f"({names.new('acting')})", f"({names.new('done')})"
        start, wanted = [*start, acting], [done]
        rows = {n: row._replace(needs=[*row.needs, acting]) for n, row in rows.items()}
        tests = {
            names.new("test"): row for row in _tests(goal, terms, names, acting, done)
        }
        rows.update(tests)
        found.update(dict.fromkeys(tests))
        added = [row.effects[0] for row in tests.values()]
        predicates.update(dict.fromkeys([acting, done, *added], "a test of the goal"))
    domain = "".join(_limits(problem, terms)) + _domain(predicates, rows, costs)
    return Pddl(domain, _problem(start, wanted, costs), found)


def _limits(problem: Problem, terms: Mapping[int, str]) -> Iterator[str]:
    """Yield a comment for each limit that a plan of the text may exceed."""
    for limit in problem.limits:
        counted = [terms[at] for at in sorted(limit.atoms) if at in terms]
        if len(counted) > limit.most:
            yield f"; left out: at most {limit.most} of {' '.join(counted)}\n"


def _tests(
    goal: Goal, terms: Mapping[int, str], names: _Names, acting: str, done: str
) -> Iterator[_Row]:
    """Yield the actions that test a goal with several branches or ways.

    After the first of them no action of the library can follow.
    """
    for branch in goal:
        holds = [f"({names.new('holds')})" for _ in branch]
        for part, ways in zip(holds, branch, strict=True):
            for way in ways:
                needs = [terms[at] for at in way]
                yield _Row(needs, [part, f"(not {acting})"], "a part of the goal")
        yield _Row(holds, [done], "the goal")


def _domain(
    predicates: Mapping[str, str], rows: Mapping[str, _Row], costs: bool
) -> str:
    costed = (" :action-costs", "\n  (:functions (total-cost) - number)")
    requirement, functions = costed if costs else ("", "")
    told = [f"\n    {term}  ; {visible(said)}" for term, said in predicates.items()]
    actions = [
        f"\n  (:action {name}  ; {visible(row.comment)}"
        f"\n    :parameters ()"
        f"\n    :precondition {_and(row.needs)}"
        f"\n    :effect {_and(row.effects)})"
        for name, row in rows.items()
    ]
    return (
        f"(define (domain rapc)\n  (:requirements :strips{requirement})"
        f"\n  (:predicates{''.join(told)}\n  ){functions}{''.join(actions)}\n)\n"
    )


def _problem(start: Sequence[str], wanted: Sequence[str], costs: bool) -> str:
    metric = "\n  (:metric minimize (total-cost))" if costs else ""
    facts = [f"\n    {one}" for one in (*start, *["(= (total-cost) 0)"][: int(costs)])]
    return (
        "(define (problem goal)\n  (:domain rapc)"
        f"\n  (:init{''.join(facts)}\n  )\n  (:goal {_and(wanted)}){metric}\n)\n"
    )


def _and(terms: Iterable[str]) -> str:
    return f"({' '.join(['and', *terms])})"
