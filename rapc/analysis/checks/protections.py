"""RAP119 and RAP126: steps that undo a fact that another step protects or needs.

Between the end of a step with `(formula for t)` and the start of t, any step may run
that the order allows: a threat, in the terms of partial-order planning. The effects of
a step come from its RAP where the effects are certain: declared `effects`, `succeed`,
and the common effects of all its primitives that end `okay`.

RAP129: steps that undo the fact of a constraint, directly or in their descendants.

A constraint is evaluated at each selection of each task below [L 3.21]. The constraint
fails if a step at any depth surely undoes the fact and another step follows.

RAP143: formulas with `for` that no step before can make true.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.bindings import MayBeBound
from rapc.analysis.facts.effects import (
    EFFECTS,
    GUARANTEED,
    Effect,
    Effects,
    done,
    may_establish,
    put_in,
)
from rapc.analysis.facts.logic import (
    Literal,
    contradict,
    fact_name,
    is_computed,
    literals,
)
from rapc.analysis.facts.statistics import LIMITS
from rapc.analysis.facts.task_nets import Net, sure_net, sure_nets
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_formula, format_goal
from rapc.ir.walk import FormulaAt, formulas, input_terms, steps, variable_names

THREAT = Rule(
    code="RAP126",
    name="threatened-protection",
    severity=Severity.WARNING,
    summary="a step may undo a fact that another step protects with `for`",
    ignore="where priorities, or things that both steps use, prevent this",
    source="T 4.7.3, 4.9",
)

RACING = Rule(
    code="RAP119",
    name="racing-steps",
    severity=Severity.WARNING,
    summary="a step may undo a fact that another step requires before its start",
    ignore="where a thing that both steps use delays the one until the "
    "end of the other",
    source="T 4.4.2, 4.5.2",
)


@check(THREAT, RACING, needs_whole="method")
def threats(run: Pass) -> Iterator[Diagnostic]:
    """Find steps that undo a fact that another step protects, or needs to begin."""
    for _, method, net in sure_nets(run):
        every = steps(method)
        yield from (*_threats(run, every, net), *_races(run, every, net))


def _threats(run: Pass, steps: Sequence[nodes.Step], net: Net) -> Iterator[Diagnostic]:
    protected = list(_protected(steps))
    if not protected:
        return
    places = {step.tag: at for at, step in enumerate(steps)}
    before, after = net.reach()
    every = (1 << len(steps)) - 1
    between: list[tuple[int, nodes.For, Literal]] = []
    for at, note, wanted in protected:
        other = places[note.tag]
        may_come = every & ~(before[at] | after[other] | 1 << at | 1 << other)
        if may_come:
            between.append((may_come, note, wanted))
    changes = _changes(run, steps, net) if between else {}
    changing = {n: _bits({by for by, _ in there}) for n, there in changes.items()}
    for may_come, note, wanted in between:
        if not changing.get(fact_name(wanted), 0) & may_come:
            continue
        for by, effect in changes.get(fact_name(wanted), ()):
            if may_come >> by & 1 and contradict(run.signatures, wanted, effect):
                yield _threat(note, wanted, steps[by])


def _changes(
    run: Pass, steps: Sequence[nodes.Step], net: Net
) -> dict[str, list[tuple[int, Literal]]]:
    """Return the guaranteed effects of steps by name, with the position of the step."""
    changes: dict[str, list[tuple[int, Literal]]] = {}
    sure = run.result(GUARANTEED)
    for at, step in enumerate(steps):
        for effect in sure.of(step.goal) if at not in net.early else ():
            changes.setdefault(fact_name(effect), []).append((at, effect))
    return changes


def _races(run: Pass, steps: Sequence[nodes.Step], net: Net) -> Iterator[Diagnostic]:
    """Yield the first step that may undo a need of another step without an order."""
    needs: dict[str, list[tuple[int, Literal]]] = {}
    for at, step in enumerate(steps):
        for one in _needed(run, step.goal):
            needs.setdefault(fact_name(one), []).append((at, one))
    if not needs:
        return
    before, after = net.reach()
    sure = run.result(GUARANTEED)
    for by, step in enumerate(steps):
        for effect in sure.of(step.goal) if by not in net.early else ():
            for at, wanted in needs.get(fact_name(effect), ())[: LIMITS.steps_of_fact]:
                apart = before[at] | after[at] | 1 << at
                if apart >> by & 1 or steps[at].priority > step.priority:
                    continue
                if contradict(run.signatures, wanted, effect):
                    yield _race(wanted, steps[at], step)
                    return


def _needed(run: Pass, goal: nodes.Goal) -> Iterator[Literal]:
    """Yield the facts that the RAP of a goal requires before its start."""
    rap = run.library.raps.get(goal.name)
    if rap is None:
        return
    facts = [
        one
        for clause, formula in clauses.held(clauses.RAP, rap)
        if clause.required and clause.when == "select"
        for one in literals(formula)
        if fact_name(one)
    ]
    yield from put_in(facts, input_terms(rap, goal))


def _race(needed: Literal, step: nodes.Step, by: nodes.Step) -> Diagnostic:
    return RACING.at(
        by.goal.span,
        f"step `{by.tag}` may undo `{needed.written}`, which step "
        f"`{step.tag}` requires",
        labels=(
            Label(step.goal.span, f"`{format_goal(step.goal)}` may run after that"),
            Label(needed.span, "queried here"),
        ),
        help=f"put step `{step.tag}` before step `{by.tag}`",
    )


def _bits(numbers: set[int]) -> int:
    return sum(1 << one for one in numbers)


def _protected(
    steps: Sequence[nodes.Step],
) -> Iterator[tuple[int, nodes.For, Literal]]:
    """Yield the protected facts, each with the position of the step and its note."""
    for at, step in enumerate(steps):
        for note in step.annotations:
            if isinstance(note, nodes.For):
                for one in literals(note.formula):
                    if fact_name(one):
                        yield at, note, one


def _threat(note: nodes.For, undone: Literal, step: nodes.Step) -> Diagnostic:
    return THREAT.at(
        note.span,
        f"step `{step.tag}` may undo `{undone.written}` before step "
        f"`{note.tag}` begins",
        labels=(
            Label(
                step.goal.span,
                f"`{format_goal(step.goal)}` may run between the two steps",
            ),
        ),
        help=f"put step `{step.tag}` before this step, or after step `{note.tag}`",
    )


BROKEN = Rule(
    code="RAP129",
    name="broken-constraint",
    severity=Severity.WARNING,
    summary="a step violates a constraint while other steps follow",
    ignore="where the other steps must not run in this case",
    source="T 4.4.3, 5.3.4",
)


@check(BROKEN, needs_whole="method")
def constraints(run: Pass) -> Iterator[Diagnostic]:
    """Find steps that undo the fact of a constraint above."""
    for rap, method, net in sure_nets(run):
        asked = [*literals(rap.constraints), *literals(method.constraints)]
        asked = [one for one in asked if fact_name(one)]
        if asked:
            yield from _broken(run, steps(method), net, asked)


def _broken(
    run: Pass, steps: Sequence[nodes.Step], net: Net, asked: Sequence[Literal]
) -> Iterator[Diagnostic]:
    """Yield the first step that surely undoes a fact while other steps follow."""
    left = _left(net)
    search = _Search(run, asked)
    for far in (0, LIMITS.constraint_depth):
        for at, step in enumerate(steps):
            found = search.undoing(step.goal, left[at], far)
            if found is not None:
                yield _break(step, *found)
                return


def _left(net: Net) -> list[bool]:
    """Return, for each step, whether another step may start after its end."""
    before, _ = net.reach()
    everything = (1 << len(before)) - 1
    return [there | 1 << at != everything for at, there in enumerate(before)]


_Undone = tuple[Literal, nodes.Goal]
"""A required fact, and the goal that surely undoes the fact."""


class _Search:
    """A search for goals that undo facts, in the steps of a method and below.

    Args:
        run: the pass.
        asked: the facts, in the terms of the method.
    """

    def __init__(self, run: Pass, asked: Sequence[Literal]) -> None:
        self._run = run
        self._asked: dict[str, list[Literal]] = {}
        for one in asked:
            self._asked.setdefault(fact_name(one), []).append(one)
        self._below = 0

    def undoing(self, goal: nodes.Goal, left: bool, far: int) -> _Undone | None:
        """Return the goal, or a goal below, that surely undoes a fact, or None.

        Args:
            goal: the goal, in the terms of the method.
            left: whether a step follows after the goal is reached.
            far: the number of levels of RAPs to follow.
        """
        library = self._run.library
        for effect in done(library, goal) if left else ():
            for wanted in self._asked.get(fact_name(effect), ()):
                if contradict(self._run.signatures, wanted, effect):
                    return wanted, goal
        rap = library.raps.get(goal.name)
        if rap is None or not far or not rap.methods:
            return None
        given = input_terms(rap, goal)
        first = None
        for method in rap.methods:
            found = self._in_method(method, given, left, far)
            if found is None:
                return None
            first = first or found
        return first

    def _in_method(
        self,
        method: nodes.Method,
        given: Mapping[str, nodes.Term],
        left: bool,
        far: int,
    ) -> _Undone | None:
        net = sure_net(self._run, method)
        if net is None:
            return None
        more = _left(net)
        for at, step in enumerate(steps(method)):
            self._below += 1
            if at in net.early or self._below > LIMITS.goals_below:
                continue
            goal = _handed(step.goal, given, far)
            found = self.undoing(goal, left or more[at], far - 1)
            if found is not None:
                return found
        return None


def _handed(goal: nodes.Goal, given: Mapping[str, nodes.Term], far: int) -> nodes.Goal:
    """Return a goal in the terms of the caller; unknown terms get unique names."""
    args: list[nodes.Term] = []
    for at, term in enumerate(goal.args):
        if isinstance(term, nodes.Const):
            args.append(term)
        elif isinstance(term, nodes.Var) and term.name in given:
            args.append(given[term.name])
        else:
            args.append(nodes.Var(f"?{goal.name} {far} {at}"))
    return msgspec.structs.replace(goal, args=tuple(args))


def _break(step: nodes.Step, wanted: Literal, by: nodes.Goal) -> Diagnostic:
    labels = [Label(wanted.span, "queried here")]
    way = ""
    if by.span != step.goal.span:
        labels.append(Label(by.span, f"`{format_goal(by)}` does so"))
        way = " in a step below it"
    return BROKEN.at(
        step.goal.span,
        f"step `{step.tag}` undoes "
        f"`{format_formula(wanted.formula)}`{way}, a constraint of the "
        "remaining steps",
        labels=tuple(labels),
        help="make it the last step, or query the fact in the context instead",
    )


VAIN = Rule(
    code="RAP143",
    name="vain-protection",
    severity=Severity.WARNING,
    summary="`for` protects a fact that no step before it can bring about",
    ignore="where the fact holds from the start and nothing must undo it",
    source="T 4.7.3",
)


@check(VAIN, needs_whole="form")
def vain_protection(run: Pass) -> Iterator[Diagnostic]:
    """Find formulas with `for` that no step before can make true."""
    known: dict[str, _ByName | None] = {}
    for rap, method, net in sure_nets(run) if run.complete else ():
        notes = [note for step in steps(method) for note in step.annotations]
        if any(isinstance(n, nodes.For) and n.formula is not None for n in notes):
            misplaced = list(_misplaced(run, steps(method), net))
            yield from misplaced or _of_net(run, rap, method, net, known)


def _misplaced(
    run: Pass, steps: Sequence[nodes.Step], net: Net
) -> Iterator[Diagnostic]:
    """Yield protected facts that an earlier step guarantees, and this step may undo."""
    every = [
        {one.formula for one in run.result(GUARANTEED).of(step.goal) if one.holds}
        for step in steps
    ]
    brought: dict[nodes.Formula, list[int]] = {}
    for by, facts in enumerate(every):
        for fact in facts:
            brought.setdefault(fact, []).append(by)
    for at, note, wanted in _protected(steps):
        there = brought.get(wanted.formula, [])
        if not wanted.holds or at in there or len(there) != 1:
            continue
        (by,) = there
        changes = run.result(EFFECTS).changes(steps[at].goal.name)
        if changes is not None and fact_name(wanted) not in changes:
            continue
        if by not in net.early and net.is_before(by, at):
            yield VAIN.at(
                note.span,
                f"step `{steps[at].tag}` does not bring about "
                f"`{format_formula(wanted.formula)}`, step `{steps[by].tag}` does",
                labels=(Label(steps[by].goal.span, "guaranteed here"),),
                help=f"write the formula at step `{steps[by].tag}`",
            )


def _asked(rap: nodes.DefineRap) -> set[str]:
    """Return the facts in the conditions of a RAP; these facts may hold at its start.

    The facts that the conditions deny surely do not hold.
    """
    found = set()
    waiting = [
        (one.formula, True)
        for one in formulas(rap)
        if one.clause.required and one.step is None
    ]
    while waiting:
        formula, holds = waiting.pop()
        match formula:
            case nodes.And() | nodes.Or():
                waiting += [(part, holds) for part in formula.parts]
            case nodes.Not():
                waiting.append((formula.part, not holds))
            case nodes.Believe() if holds:
                found.add(formula.pattern.name)
            case nodes.Proposition() if holds:
                found.add(formula.name)
    return found


_ByName = Mapping[str, Sequence[Effect]]
"""The possible effects of a RAP, by the names of facts."""


def _by_name(effects: Effects, name: str) -> _ByName | None:
    done = effects.of(name)
    if done is None:
        return None
    found: dict[str, list[Effect]] = {}
    for effect in done:
        found.setdefault(effect.name, []).append(effect)
    return found


_Changers = Mapping[str, Sequence[tuple[int, Sequence[Effect]]]]
"""By the names of facts: the steps that may change the facts, with the effects."""


def _changers(
    run: Pass, steps: Sequence[nodes.Step], known: dict[str, _ByName | None]
) -> _Changers | None:
    """Return the steps that may change each fact; None if some effects are unknown."""
    changers: dict[str, list[tuple[int, Sequence[Effect]]]] = {}
    for at, step in enumerate(steps):
        name = step.goal.name
        if name not in known:
            known[name] = _by_name(run.result(EFFECTS), name)
        done = known[name]
        if done is None:
            return None
        for fact, effects in done.items():
            changers.setdefault(fact, []).append((at, effects))
    return changers


def _of_net(
    run: Pass,
    rap: nodes.DefineRap,
    method: nodes.Method,
    net: Net,
    known: dict[str, _ByName | None],
) -> Iterator[Diagnostic]:
    """Yield protected facts that no step before the other step can make true."""
    every = steps(method)
    changers = _changers(run, every, known)
    if changers is None:
        return
    asked = _asked(rap)
    bound = MayBeBound(rap, run.library.functions)
    places = {step.tag: at for at, step in enumerate(every)}
    for at, step in enumerate(every):
        for note in step.annotations:
            if not isinstance(note, nodes.For) or note.formula is None:
                continue
            given = bound.at(FormulaAt(note.formula, clauses.FOR, method, step))
            until = places[note.tag]
            for one in literals(note.formula):
                fact = fact_name(one)
                there = changers.get(fact, [])
                if not fact or len(there) > LIMITS.steps_of_fact:
                    continue
                if not one.holds:
                    others = [change for change in there if change[0] != at]
                    if _undoes(run, step, one) and not _comes(
                        run, one, others, net, until
                    ):
                        yield _vain(one, step)
                elif not (
                    fact in asked
                    or is_computed(run.library, fact)
                    or _is_looked_up(one, given)
                    or _may_be_default(run, one)
                    or _comes(run, one, there, net, until)
                ):
                    yield _vain(one, step)


def _is_looked_up(one: Literal, given: Container[str]) -> bool:
    """Return whether a fact is queried to bind a variable without a value."""
    return any(name not in given for name in variable_names(one.formula))


def _may_be_default(run: Pass, one: Literal) -> bool:
    """Return whether a property may hold by its default."""
    assert isinstance(one.formula, nodes.Proposition)
    declared = run.signatures.relations.get(one.formula.name)
    if declared is None or not declared.is_property:
        return False
    value = declared.full(one.formula.args)[-1:]
    return declared.default_function is not None or any(
        isinstance(term, nodes.Const) and term.value == declared.default
        for term in value
    )


def _undoes(run: Pass, step: nodes.Step, denied: Literal) -> bool:
    """Return whether a guaranteed effect of a step contradicts a protected literal."""
    return any(
        fact_name(effect) == fact_name(denied)
        and contradict(run.signatures, denied, effect)
        for effect in run.result(GUARANTEED).of(step.goal)
    )


def _comes(
    run: Pass,
    one: Literal,
    there: Sequence[tuple[int, Sequence[Effect]]],
    net: Net,
    until: int,
) -> bool:
    """Return whether a step that may run before another may make a literal hold."""
    if not there:
        return may_establish(run.library, one, ())
    return any(
        may_establish(run.library, one, effects)
        and other != until
        and not net.is_before(until, other)
        for other, effects in there
    )


def _vain(one: Literal, step: nodes.Step) -> Diagnostic:
    written = format_formula(one.formula)
    return VAIN.at(
        one.span,
        f"no step up to here brings about `{written}`"
        if one.holds
        else f"this step brings about `{written}`, not the opposite",
        labels=(
            Label(
                step.goal.span,
                f"`{format_goal(step.goal)}` does{' not' * one.holds}",
            ),
        ),
        help="protect an effect of the step, or declare the effect",
    )
