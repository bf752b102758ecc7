"""The partly ordered task-net of a plan: an order only where it is needed.

For each atom that a step needs, the last step before it that brings the atom about is
its producer. A step that spoils the atom comes before the producer or after the
consumer. The fact is protected from the end of the producer to the start of the
consumer.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from rapc.base.values import Atom
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.planning.ground import Action, Literal, Placeholder, Problem


class Link(NamedTuple):
    """A fact that a step brings about for another step, or for the goal."""

    producer: int
    #: The step that needs the fact; None for the goal.
    consumer: int | None
    literal: Literal


class Sketch(NamedTuple):
    """A partly ordered plan; steps are numbered from 0."""

    actions: tuple[Action, ...]
    links: tuple[Link, ...]
    #: The facts that hold at the beginning and could change.
    relied_on: tuple[Literal, ...]
    #: Pairs of steps, the first before the second; none follows from other pairs.
    order: tuple[tuple[int, int], ...]


def sketch(problem: Problem, actions: Sequence[Action]) -> Sketch:
    """Return the partial order of a sequence of actions that solves a problem."""
    goal = goal_atoms(problem, actions)
    assert goal is not None
    ends = [(at, action.needs) for at, action in enumerate(actions)]
    before = [set[int]() for _ in actions]
    links: list[Link] = []
    relied_on: dict[Literal, None] = {}
    # A fact that only gives a cost its value orders the steps; nobody relies on it.
    for consumer, needs in [*ends, (len(actions), goal)]:
        for atom in needs:
            if atom in problem.counters:
                continue
            made = [at for at in range(consumer) if atom in actions[at].adds]
            producer = made[-1] if made else None
            is_goal = consumer == len(actions)
            weighed = not is_goal and atom in actions[consumer].weighed
            literal = problem.literals[atom]
            if producer is None and atom in problem.changing and not weighed:
                relied_on[literal] = None
            if producer is not None:
                if not weighed:
                    links.append(Link(producer, None if is_goal else consumer, literal))
                if not is_goal:
                    before[consumer].add(producer)
            for at, action in enumerate(actions):
                if atom not in action.deletes or at in (producer, consumer):
                    continue
                if at < consumer and producer is not None:
                    before[producer].add(at)
                elif not is_goal:
                    before[at].add(consumer)
    for first, second in _limited(problem, actions):
        before[second].add(first)
    rest = tuple(links), tuple(relied_on), _reduced(before)
    return Sketch(tuple(actions), *rest)


def _limited(problem: Problem, actions: Sequence[Action]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of steps that keep their order because of a limit."""
    for limit in problem.limits:
        added = [at for one in actions for at in one.adds if at in limit.atoms]
        if len(limit.atoms & problem.state) + len(added) > limit.most:
            counted = [
                at
                for at, one in enumerate(actions)
                if not limit.atoms.isdisjoint((*one.adds, *one.deletes))
            ]
            yield from pairwise(counted)


def goal_atoms(problem: Problem, actions: Sequence[Action]) -> tuple[int, ...] | None:
    """Return the atoms of the goal that hold after the actions.

    Return None if an action cannot start, or the actions do not reach the goal.
    """
    state = problem.state
    for action in actions:
        after = state.difference(action.deletes).union(action.adds)
        allowed = all(limit.allows(state, after) for limit in problem.limits)
        if not (allowed and state.issuperset(action.needs)):
            return None
        state = after
    for branch in problem.goal:
        chosen = [
            next((way for way in ways if state.issuperset(way)), None)
            for ways in branch
        ]
        if None not in chosen:
            atoms = [at for way in chosen if way is not None for at in way]
            return tuple(dict.fromkeys(atoms))
    return None


def _reduced(before: Sequence[set[int]]) -> tuple[tuple[int, int], ...]:
    """Return the pairs that do not follow from other pairs, in order."""
    closed: list[set[int]] = []
    found: list[tuple[int, int]] = []
    for at, own in enumerate(before):
        beyond = {earlier for one in own for earlier in closed[one]}
        found += [(one, at) for one in own - beyond]
        closed.append(own | beyond)
    return tuple(sorted(found))


def method(made: Sketch, name: str, inputs: Mapping[str, nodes.Const]) -> nodes.Method:
    """Return the method of a plan.

    Its context holds for these inputs while the facts hold that the plan relies on, and
    until the task has tried the method.
    """
    parts = (
        *[nodes.Compare("=", nodes.Var(var), value) for var, value in inputs.items()],
        *[_formula(one, {}) for one in made.relied_on],
        nodes.Not(nodes.HistoryTest("method-tried", (nodes.Const(name),))),
    )
    return nodes.Method(
        name=name,
        position=1,
        context=parts[0] if len(parts) == 1 else nodes.And(parts),
        notations=(),
        body=nodes.TaskNet(steps(made)),
    )


def steps(made: Sketch) -> tuple[nodes.Step, ...]:
    """Return the steps of a plan, called `t1`, `t2` and so on."""
    outputs = _outputs(made)
    return tuple(
        [
            nodes.Step(
                _tag(at), 0, _goal(action, outputs), _annotations(made, at, outputs)
            )
            for at, action in enumerate(made.actions)
        ]
    )


def _annotations(
    made: Sketch, at: int, outputs: dict[Atom, nodes.Var]
) -> tuple[nodes.For, ...]:
    """Return the protections of a step, then the steps that only follow it."""
    found: dict[nodes.For, None] = {}
    for link in made.links:
        if link.producer == at and link.consumer is not None:
            fact = Literal(link.literal.present, link.literal.plain)
            formula = _formula(fact, outputs)
            found[nodes.For(formula, _tag(link.consumer))] = None
    protected = {one.tag for one in found}
    for first, second in made.order:
        if first == at and _tag(second) not in protected:
            found[nodes.For(None, _tag(second))] = None
    return tuple(sorted(found, key=lambda one: int(one.tag[1:])))


def _formula(literal: Literal, outputs: dict[Atom, nodes.Var]) -> nodes.Formula:
    """Return a literal as a formula."""
    name, *args = literal.fact
    plain, age = name if isinstance(name, tuple) else (str(name), None)
    pattern = nodes.Proposition(plain, _terms(args, outputs))
    found: nodes.Formula = pattern
    if age is not None:
        found = nodes.Believe(pattern, nodes.Const(age))
    return found if literal.present else nodes.Not(found)


def _goal(action: Action, outputs: dict[Atom, nodes.Var]) -> nodes.Goal:
    name, *inputs = action.goal
    rap = action.operator.rap
    given = [outputs.get(action.values[one.name]) for one in rap.outputs]
    return nodes.Goal(
        str(name),
        _terms(inputs, outputs),
        tuple([nodes.Var("?") if one is None else one for one in given]),
    )


def _outputs(made: Sketch) -> dict[Atom, nodes.Var]:
    """Return the output variable for each placeholder: `?NAME-N` of step N."""
    found: dict[Atom, nodes.Var] = {}
    for at, action in enumerate(made.actions, 1):
        for output in action.operator.rap.outputs:
            value = action.values[output.name]
            if isinstance(value, Placeholder):
                found[value] = nodes.Var(f"{output.name}-{at}")
    return found


def _terms(
    values: Sequence[Atom], outputs: dict[Atom, nodes.Var]
) -> tuple[nodes.Term, ...]:
    return tuple([outputs.get(value) or nodes.Const(value) for value in values])


def _tag(at: int) -> str:
    return f"t{at + 1}"


def achieved(made: Sketch) -> tuple[tuple[str, ...], ...]:
    """Return for each step the parts of the goal that the step makes true, as text."""
    outputs = _outputs(made)
    found: list[dict[str, None]] = [{} for _ in made.actions]
    for link in made.links:
        if link.consumer is None:
            fact = Literal(link.literal.present, link.literal.plain)
            found[link.producer][format_node(_formula(fact, outputs))] = None
    return tuple([tuple(one) for one in found])
