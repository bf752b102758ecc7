"""RAP168 to RAP171, RAP176, RAP177: steps that repeat, contradict or lack others.

`done` (`rapc.analysis.facts.effects`) returns the guaranteed effects of a step in the
terms of its method. Preconditions and `succeed` of the called RAP are compared with the
context and with the protected facts in the same terms.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.clashes import (
    clash_at,
    first_clash,
    follows_expanded,
    said,
)
from rapc.analysis.facts.effects import (
    does_nothing,
    done,
    done_by_method,
    put_in,
)
from rapc.analysis.facts.logic import (
    Literal,
    apart,
    entails,
    fact_name,
    is_never,
    literals,
)
from rapc.analysis.facts.statistics import LIMITS
from rapc.analysis.facts.task_nets import Net, sure_net, sure_nets
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.walk import (
    given_names,
    input_terms,
    subformulas,
    substitute,
    variable_names,
    ways,
)

COPIED_STEP = Rule(
    code="RAP168",
    name="copied-step",
    severity=Severity.WARNING,
    summary="two steps of a task-net have the same goal, and one of them is idle",
    ignore="where both steps must run at the same time",
    source="T 4.5",
)


@check(COPIED_STEP, needs_whole="method")
def copied_steps(run: Pass) -> Iterator[Diagnostic]:
    """Find equal goals in a task-net, unless the order makes a repetition."""
    for rap in run.library.raps.values():
        for method in rap.methods:
            if isinstance(method.body, nodes.TaskNet):
                yield from _equal_goals(run, method, method.body)


def _equal_goals(
    run: Pass, method: nodes.Method, body: nodes.TaskNet
) -> Iterator[Diagnostic]:
    first: dict[nodes.Goal, int] = {}
    equal = [
        (first[step.goal], at)
        for at, step in enumerate(body.steps)
        if first.setdefault(step.goal, at) != at
    ]
    net = sure_net(run, method) if equal else None
    if net is None:
        return
    before, after = net.reach()
    for other, at in equal:
        ordered = before[at] >> other & 1 or before[other] >> at & 1
        between = before[at] & after[other] | before[other] & after[at]
        step = body.steps[at]
        if ordered and (between or not _lasts(run, step)):
            continue
        if _is_repeated(run, body.steps[other], step):
            continue
        yield COPIED_STEP.at(
            step.goal.span,
            f"the step `{step.tag}` has the goal of the step `{body.steps[other].tag}`",
            labels=(Label(body.steps[other].goal.span, "the first step"),),
            help="change the goal or its arguments, or remove a step",
        )


def _lasts(run: Pass, step: nodes.Step) -> bool:
    """Return whether the success of a step depends only on memory."""
    called = run.library.raps.get(step.goal.name)
    return called is not None and _is_lasting(called.succeed)


def _is_repeated(run: Pass, one: nodes.Step, other: nodes.Step) -> bool:
    """Return whether the second of two equal steps may repeat the first on purpose."""
    notes = [*one.annotations, *other.annotations]
    if any(isinstance(note, nodes.Window | nodes.WaitFor) for note in notes):
        return True
    first, second = (
        [note for note in step.annotations if isinstance(note, nodes.ResourceChange)]
        for step in (one, other)
    )
    called = run.library.raps.get(one.goal.name)
    return first != second or called is None or not called.methods


def _is_lasting(formula: nodes.Formula | None) -> bool:
    """Return whether a formula depends only on memory, not on the task."""
    if formula is None or isinstance(formula, nodes.Truth):
        return False
    return not any(
        isinstance(part, nodes.HistoryTest | nodes.SetTest | nodes.Truth)
        or (isinstance(part, nodes.Compare) and _computes(part))
        for part in subformulas(formula)
    )


def _computes(test: nodes.Compare) -> bool:
    return any(isinstance(term, nodes.Call) for term in (test.left, test.right))


IDLE_NET = Rule(
    code="RAP169",
    name="idle-net",
    severity=Severity.WARNING,
    summary="a method without steps in a RAP that has a goal, a loop or a monitor",
    ignore="where another task brings about the goal",
    source="T 4.5",
)


@check(IDLE_NET, needs_whole="method")
def idle_nets(run: Pass) -> Iterator[Diagnostic]:
    """Find empty task-nets that leave a clause of their RAP as it is."""
    for rap in run.library.raps.values():
        clause = _clause_to_change(rap)
        for method in rap.methods if clause is not None else ():
            acts = method.notations or method.skills or _is_last_resort(method)
            if does_nothing(method) and not acts:
                word, formula = clause or ("", None)
                assert formula is not None
                yield IDLE_NET.at(
                    method.body.span,
                    f"this method does nothing, and leaves `{word}` as it is",
                    labels=(Label(formula.span, "nothing changes this"),),
                    help="add the steps of the method",
                )


def _is_last_resort(method: nodes.Method) -> bool:
    """Return whether a method gives up where no other method applies."""
    return isinstance(method.context, nodes.Otherwise)


def _clause_to_change(rap: nodes.DefineRap) -> tuple[str, nodes.Node] | None:
    goal = rap.succeed
    if goal is not None and _is_lasting(goal):
        return "succeed", goal
    if rap.repeat_while is not None:
        return "repeat-while", rap.repeat_while
    if rap.monitor_state is not None and is_never(goal):
        return "monitor-state", rap.monitor_state
    if rap.monitor_time is not None and is_never(goal):
        return "monitor-time", rap.monitor_time
    return None


CONTRARY = Rule(
    code="RAP170",
    name="contrary-step",
    severity=Severity.WARNING,
    summary="a step brings about the contrary of a clause, or can never begin",
    ignore="where another task changes the fact before the clause is evaluated",
    source="T 4.5",
)

NEEDLESS = Rule(
    code="RAP171",
    name="needless-step",
    severity=Severity.WARNING,
    summary="the goal of a step holds whenever its method is chosen",
    ignore="where another task may undo the goal before the step begins",
    source="T 4.3",
)


@check(CONTRARY, NEEDLESS, needs_whole="form")
def step_conditions(run: Pass) -> Iterator[Diagnostic]:
    """Compare each step with the context and the clauses around the step."""
    for rap in run.library.raps.values():
        given = given_names(rap)
        for method in rap.methods:
            yield from _undone_goal(run, rap, method, given)
            if isinstance(method.body, nodes.TaskNet) and method.body.steps:
                yield from _steps(run, rap, method, given)


def _undone_goal(
    run: Pass, rap: nodes.DefineRap, method: nodes.Method, given: set[str]
) -> Iterator[Diagnostic]:
    """Find a method whose guaranteed effects contradict `succeed`."""
    goal = rap.succeed
    if goal is None or isinstance(goal, nodes.Or | nodes.Truth):
        return
    sure = _done_last(run, method)
    wanted = list(literals(apart(goal, given, "@goal")))
    bound = given | set(variable_names(*_formulas(rap, method)))
    clash = first_clash(run, (), [*wanted, *sure], bound) if sure else None
    own = {id(one) for one in sure}
    if clash is not None and id(clash.second) in own and id(clash.first) not in own:
        yield clash_at(
            CONTRARY,
            f"a method of `{rap.name}` brings about {said(clash.second)}, "
            "the contrary of `succeed`",
            goal.span,
            Label(method.body.span, "this method"),
        )


def _done_last(run: Pass, method: nodes.Method) -> Sequence[Literal]:
    """Return what a method guarantees at its end: the effects of its last step."""
    if not isinstance(method.body, nodes.TaskNet):
        return done_by_method(run.library, method)
    net, steps = sure_net(run, method), method.body.steps
    if net is None:
        return ()
    before = {edge.before for edges in net.edges for edge in edges}
    last = [at for at in range(len(steps)) if at not in before]
    if len(last) != 1 or last[0] in net.early:
        return ()
    return done(run.library, steps[last[0]].goal)


def _steps(
    run: Pass, rap: nodes.DefineRap, method: nodes.Method, given: set[str]
) -> Iterator[Diagnostic]:
    body = method.body
    assert isinstance(body, nodes.TaskNet)
    net = sure_net(run, method)
    if net is None:
        return
    bound = given | set(variable_names(*_formulas(rap, method), *_goals(body)))
    monitor = (
        list(literals(apart(rap.monitor_state, given, "@monitor")))
        if rap.monitor_state is not None and is_never(rap.succeed)
        else []
    )
    context = [*monitor, *literals(method.context)]
    protected, brought = _protected(body.steps), _brought(run, body.steps)
    for at, step in enumerate(body.steps):
        called = run.library.raps.get(step.goal.name)
        if called is None:
            continue
        terms = input_terms(called, step.goal)
        for note in step.annotations:
            if not isinstance(note, nodes.For) or note.formula is None:
                continue
            for found in _contrary_effect(run, step, note, bound):
                if not _may_change(brought, net, at, note):
                    yield found
        is_first = not net.edges[at]
        held = [*(context if is_first else ()), *protected.get(step.tag, ())]
        yield from _cannot_begin(run, step, called, terms, held, bound)
        if is_first and context:
            yield from _needless(run, step, called, terms, context, bound)


def _formulas(rap: nodes.DefineRap, method: nodes.Method) -> Iterator[nodes.Formula]:
    for formula in (rap.repeat_while, method.context):
        if formula is not None:
            yield formula


def _protected(steps: Sequence[nodes.Step]) -> Mapping[str, Sequence[Literal]]:
    """Return by tag the literals that hold when a step begins, by `for` of others."""
    found: dict[str, list[Literal]] = {}
    for step in steps:
        for note in step.annotations:
            if isinstance(note, nodes.For) and note.formula:
                found.setdefault(note.tag, []).extend(literals(note.formula))
    return found


def _goals(body: nodes.TaskNet) -> Iterator[nodes.Goal]:
    return (step.goal for step in body.steps)


def _may_change(brought: Brought, net: Net, at: int, note: nodes.For) -> bool:
    """Return whether another step may change a protected fact before its use."""
    names = dict.fromkeys(map(fact_name, literals(note.formula)))
    there = [brought.get(name, ()) for name in names]
    if sum(map(len, there)) > LIMITS.steps_of_fact:
        return True
    others = [by for found in there for by, _ in found]
    user = net.tags[note.tag]
    return any(
        not net.is_before(by, at) and not net.is_before(user, by)
        for by in others
        if by not in (at, user)
    )


def _contrary_effect(
    run: Pass, step: nodes.Step, note: nodes.For, bound: set[str]
) -> Iterator[Diagnostic]:
    assert note.formula is not None
    sure = done(run.library, step.goal)
    clash = first_clash(run, sure, list(literals(note.formula)), bound)
    if clash is not None:
        yield clash_at(
            CONTRARY,
            f"`{step.goal.name}` brings about {said(clash.first)}, the contrary of "
            f"what is protected for `{note.tag}`",
            note.span,
            Label(clash.first.span, "guaranteed here"),
        )


def _in_terms_of_caller(
    called: nodes.DefineRap, formula: nodes.Formula, terms: Mapping[str, nodes.Term]
) -> nodes.Formula:
    inputs = {variable.name for variable in called.inputs}
    return substitute(apart(formula, inputs, "@called"), terms)


def _cannot_begin(
    run: Pass,
    step: nodes.Step,
    called: nodes.DefineRap,
    terms: Mapping[str, nodes.Term],
    held: Sequence[Literal],
    bound: set[str],
) -> Iterator[Diagnostic]:
    for wanted in (called.preconditions, called.constraints):
        if wanted is not None and held:
            yield from _contrary_need(run, step, called, terms, held, bound, wanted)


def _contrary_need(
    run: Pass,
    step: nodes.Step,
    called: nodes.DefineRap,
    terms: Mapping[str, nodes.Term],
    held: Sequence[Literal],
    bound: set[str],
    wanted: nodes.Formula,
) -> Iterator[Diagnostic]:
    own = _of_memory(literals(_in_terms_of_caller(called, wanted, terms)))
    clash = first_clash(run, (), [*_of_memory(held), *own], bound)
    mine = {id(one) for one in own}
    if clash is not None and id(clash.second) in mine and id(clash.first) not in mine:
        yield clash_at(
            CONTRARY,
            f"`{called.name}` requires {said(clash.second)}, but here "
            f"{said(clash.first)} holds",
            step.goal.span,
            Label(wanted.span, "required here"),
        )


def _of_memory(found: Iterable[Literal]) -> list[Literal]:
    """Return the literals that do not depend on the task that evaluates them."""
    own = nodes.HistoryTest | nodes.SetTest | nodes.Otherwise
    return [
        one
        for one in found
        if not any(isinstance(part, own) for part in subformulas(one.formula))
    ]


def _needless(
    run: Pass,
    step: nodes.Step,
    called: nodes.DefineRap,
    terms: Mapping[str, nodes.Term],
    held: Sequence[Literal],
    bound: set[str],
) -> Iterator[Diagnostic]:
    goal = called.succeed
    if goal is None or not _is_lasting(goal) or called.monitor_state is not None:
        return
    wanted = _in_terms_of_caller(called, goal, terms)
    if entails(_of_memory(held), wanted, bound, run.signatures.relations) or (
        follows_expanded(run, _of_memory(held), wanted, bound)
    ):
        yield clash_at(
            NEEDLESS,
            f"`{called.name}` succeeds at once: its goal holds where this method is "
            "chosen",
            step.goal.span,
            Label(goal.span, "the goal of the step"),
        )


UNORDERED = Rule(
    code="RAP176",
    name="unordered-steps",
    severity=Severity.WARNING,
    summary="a step requires what another step brings about, without waiting for it",
    ignore="where the fact holds before the method is chosen",
    source="T 4.5.1",
)


@check(UNORDERED, needs_whole="method")
def unordered_steps(run: Pass) -> Iterator[Diagnostic]:
    """Find steps that need the effect of a step that is not before them."""
    for rap, method, net in sure_nets(run):
        steps = method.body.steps if isinstance(method.body, nodes.TaskNet) else ()
        known = {fact_name(one) for one in _known(rap, method)}
        brought, protected = _brought(run, steps), _protected(steps)
        for at, step in enumerate(steps):
            sure = known.union(map(fact_name, protected.get(step.tag, ())))
            found = _missing_order(run, step, net, at, brought, sure)
            if found is not None:
                by, needed = found
                yield UNORDERED.at(
                    step.goal.span,
                    f"the step `{step.tag}` requires `{needed.written}`, which the "
                    f"step `{steps[by].tag}` brings about",
                    labels=(Label(steps[by].goal.span, "not before the other step"),),
                    help=f"add `(for {step.tag})` to the step `{steps[by].tag}`",
                )
                break


def _known(rap: nodes.DefineRap, method: nodes.Method) -> Iterator[Literal]:
    for formula in (rap.preconditions, rap.monitor_state, method.context):
        if formula is not None:
            for part in subformulas(formula):
                yield Literal(part, True)


Brought = Mapping[str, Sequence[tuple[int, Literal]]]
"""By the name of a fact: the steps that bring such facts about, and the facts."""


def _brought(run: Pass, steps: Sequence[nodes.Step]) -> Brought:
    found: dict[str, list[tuple[int, Literal]]] = {}
    for at, step in enumerate(steps):
        for one in done(run.library, step.goal):
            name = fact_name(one)
            if name:
                found.setdefault(name, []).append((at, one))
    return found


def _missing_order(
    run: Pass,
    step: nodes.Step,
    net: Net,
    at: int,
    brought: Brought,
    sure: Container[str],
) -> tuple[int, Literal] | None:
    """Return a step that brings about what another step requires, and the fact."""
    for needed in _needed(run, step.goal):
        name = fact_name(needed)
        there = brought.get(name, ())
        if not needed.holds or name in sure or len(there) > LIMITS.steps_of_fact:
            continue
        there = [(by, one) for by, one in there if one.holds]
        late = [(by, one) for by, one in there if not net.is_before(by, at)]
        if len(late) < len(there):
            continue
        for by, one in late:
            if by not in (at, *net.early) and one.formula == needed.formula:
                return by, needed
    return None


def _needed(run: Pass, goal: nodes.Goal) -> list[Literal]:
    """Return the facts that a goal requires: its preconditions and constraints."""
    rap = run.library.raps.get(goal.name)
    if rap is None:
        return []
    asked = [one for f in (rap.preconditions, rap.constraints) for one in literals(f)]
    if rap.methods and all(method.context is not None for method in rap.methods):
        every = [list(literals(method.context)) for method in rap.methods]
        asked += [one for one in every[0] if all(one in row for row in every[1:])]
    return put_in([one for one in asked if fact_name(one)], input_terms(rap, goal))


NOT_YET = Rule(
    code="RAP177",
    name="history-required",
    severity=Severity.WARNING,
    summary="a precondition requires an earlier result of the same task",
    ignore="never: a new task has no earlier result",
    source="T 4.1.2",
)


@check(NOT_YET)
def history_required(run: Pass) -> Iterator[Diagnostic]:
    """Find preconditions that no new task meets."""
    for rap in run.library.raps.values():
        if rap.preconditions is None:
            continue
        branches = [list(literals(way)) for way in ways(rap.preconditions)]
        asked = [
            next((one for one in branch if _is_history(one)), None)
            for branch in branches
        ]
        if branches and all(asked):
            yield NOT_YET.at(
                rap.preconditions.span,
                f"no method of `{rap.name}` begins: a new task has no earlier result",
                help="negate the formula, or write it in the context of a method",
            )


def _is_history(literal: Literal) -> bool:
    """Return whether a literal never holds for a new task."""
    formula = literal.formula
    if isinstance(formula, nodes.Not | nodes.Or) and literal.holds:
        inner = [list(literals(way)) for way in ways(formula)]
        return isinstance(formula, nodes.Or) and all(
            any(_is_history(one) for one in branch) for branch in inner
        )
    if isinstance(formula, nodes.And) and not literal.holds:
        return all(
            _is_history(Literal(one.formula, not one.holds))
            for one in literals(formula)
        )
    return isinstance(formula, nodes.HistoryTest) and literal.holds
