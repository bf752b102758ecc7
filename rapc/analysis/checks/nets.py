"""RAP168 to RAP171, RAP176, RAP177: steps that repeat, contradict or lack others.

`done` (`rapc.analysis.facts.effects`) returns the guaranteed effects of a step in the
terms of its method. Preconditions and `succeed` of the called RAP are compared with the
context and with the protected facts in the same terms.
"""

from __future__ import annotations

from collections.abc import (
    Callable,
    Collection,
    Container,
    Iterator,
    Mapping,
    Sequence,
)
from functools import cache, partial
from itertools import chain

from rapc.analysis.check import Pass, RapFact, check
from rapc.analysis.facts.clashes import (
    clash_at,
    first_clash,
    follows_expanded,
    may_expand,
    said,
)
from rapc.analysis.facts.effects import (
    ACTING,
    GUARANTEED,
    acts_itself,
    done_by_method,
    may_end,
    put_in,
)
from rapc.analysis.facts.held import (
    ASKED,
    Beginnings,
    at_choice,
    of_memory,
    with_queries,
)
from rapc.analysis.facts.logic import (
    Clash,
    Literal,
    apart,
    entails,
    fact_name,
    follows,
    is_never,
    literals,
    may_clash,
)
from rapc.analysis.facts.resources import FirstValues
from rapc.analysis.facts.statistics import LIMITS
from rapc.analysis.facts.task_nets import Net, sure_net, sure_nets, tag_of
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import (
    given_names,
    input_terms,
    steps,
    subformulas,
    substitute,
    variable_names,
    ways,
)
from rapc.library.library import calls_of

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
    acting = run.result(ACTING)
    raps = run.library.raps
    called = {name for rap in raps.values() for name in calls_of(rap, raps)}
    for rap in raps.values():
        clause = _clause_to_change(rap)
        if clause is None and _is_called_in_vain(rap, acting, called):
            yield IDLE_NET.at(
                rap.methods[0].body.span,
                f"`{rap.name}` has inputs, but does nothing: no method has a step",
                help="add the steps of the method",
            )
        for method in rap.methods if clause is not None else ():
            word, formula = clause or ("", None)
            assert formula is not None
            if _is_idle(run, rap, method, word):
                yield IDLE_NET.at(
                    method.body.span,
                    f"this method does nothing, and leaves `{word}` as it is",
                    labels=(Label(formula.span, "nothing changes this"),),
                    help="add the steps of the method",
                )


def _is_called_in_vain(
    rap: nodes.DefineRap, acting: Container[str], called: Container[str]
) -> bool:
    """Return whether steps give values to a RAP that does nothing with them."""
    empty = bool(rap.methods) and not any(map(steps, rap.methods))
    useful = bool(rap.outputs) or rap.name in acting
    return empty and not useful and bool(rap.inputs) and rap.name in called


def _is_idle(
    run: Pass, rap: nodes.DefineRap, method: nodes.Method, clause: str
) -> bool:
    """Return whether a method and its descendants do nothing but count."""
    acting = run.result(ACTING)
    every = steps(method)
    if acts_itself(method) or not all(
        _does_nothing(run, step, acting) for step in every
    ):
        return False
    counted = {
        note.resource.name
        for step in every
        for note in step.annotations
        if isinstance(note, nodes.ResourceChange)
        and isinstance(note.resource, nodes.Var)
    }
    if not counted:
        return True
    contexts = [one.context for one in rap.methods if one.context is not None]
    return clause == "succeed" and counted.isdisjoint(variable_names(*contexts))


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


IDLE_STEP = Rule(
    code="RAP184",
    name="idle-step",
    severity=Severity.WARNING,
    summary="a step does nothing, and neither counts nor orders other steps",
    ignore="where the step only shows in the trace",
    source="T 4.5",
)


@check(IDLE_STEP, needs_whole="method")
def idle_steps(run: Pass) -> Iterator[Diagnostic]:
    """Find steps for RAPs without actions that serve no other step."""
    acting = run.result(ACTING)
    for _, method, net in sure_nets(run):
        every = steps(method)
        idle = [at for at, step in enumerate(every) if _does_nothing(run, step, acting)]
        if len(every) == 1 or not idle:
            continue
        before, after = net.reach()
        named = {tag_of(n) for s in every for n in s.annotations if may_end(n)}
        for at in idle:
            step = every[at]
            notes = step.annotations
            if step.tag in named or (before[at] and after[at]):
                continue
            counts = any(isinstance(note, nodes.ResourceChange) for note in notes)
            if not counts:
                yield IDLE_STEP.at(
                    step.goal.span,
                    f"step `{step.tag}` does nothing, and no other step requires it",
                    help="change the goal of the step, or remove the step",
                )
            elif not before[at] and not after[at]:
                yield IDLE_STEP.at(
                    step.goal.span,
                    f"step `{step.tag}` only counts, and has no order with other steps",
                    help="add `for` with the tag of the step that is counted",
                )


def _does_nothing(run: Pass, step: nodes.Step, acting: Container[str]) -> bool:
    """Return whether a step has no action, waits for nothing and ends nothing.

    A RAP that does nothing in spite of its methods is reported itself.
    """
    called = run.library.raps.get(step.goal.name)
    return (
        called is not None
        and not called.methods
        and step.goal.name not in acting
        and not step.goal.outputs
        and not any(
            isinstance(note, nodes.WaitFor) or may_end(note)
            for note in step.annotations
        )
    )


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
    raps = run.library.raps
    for rap in raps.values():
        undone = run.of(UNDONE, rap)
        if undone and not any(
            _is_undone(run, name) for name in calls_of(rap, raps) if name != rap.name
        ):
            yield from undone
    reported: set[Span] = set()
    for rap in run.library.raps.values():
        for found in run.of(STEP_CONDITIONS, rap):
            causes = {label.span for label in found.labels}
            if causes.isdisjoint(reported):
                yield found
            reported |= causes


def _undone(run: Pass, rap: nodes.DefineRap) -> Sequence[Diagnostic]:
    found = (_undone_goal(run, rap, method) for method in rap.methods)
    return tuple(chain.from_iterable(found))


UNDONE = RapFact(_undone)
"""The findings about methods whose guaranteed effects contradict `succeed`."""


def _is_undone(run: Pass, name: str) -> bool:
    """Return whether a RAP has a method that contradicts its `succeed`."""
    rap = run.library.raps.get(name)
    return rap is not None and bool(run.of(UNDONE, rap))


def _step_conditions(run: Pass, rap: nodes.DefineRap) -> Sequence[Diagnostic]:
    found = (_steps(run, rap, method) for method in rap.methods if steps(method))
    return tuple(chain.from_iterable(found))


STEP_CONDITIONS = RapFact(_step_conditions)
"""The findings about the steps of a RAP and the clauses around them."""


def _undone_goal(
    run: Pass, rap: nodes.DefineRap, method: nodes.Method
) -> Iterator[Diagnostic]:
    """Find a method whose guaranteed effects contradict `succeed`."""
    goal = rap.succeed
    if goal is None or isinstance(goal, nodes.Or | nodes.Truth):
        return
    sure = _done_last(run, method)
    relations = run.signatures.relations
    if not sure or not may_clash([*literals(goal), *sure], relations):
        return
    given = given_names(rap)
    wanted = literals(apart(goal, given, "@goal"))
    bound = given | set(variable_names(*_formulas(rap, method)))
    clash = first_clash(run, (), [*wanted, *sure], bound)
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
    return run.result(GUARANTEED).of(steps[last[0]].goal)


def _steps(
    run: Pass, rap: nodes.DefineRap, method: nodes.Method
) -> Iterator[Diagnostic]:
    """Compare the steps of a method with what holds when the steps begin.

    RAPs with a fault in `succeed` are reported themselves.
    """
    given = given_names(rap)
    body = method.body
    assert isinstance(body, nodes.TaskNet)
    net = sure_net(run, method)
    if net is None:
        return
    bound = given | set(variable_names(*_formulas(rap, method), *_goals(body)))
    chosen = at_choice(run, rap, method, given)
    beginnings = Beginnings(run, rap, method, net, chosen, given)
    brought = cache(partial(_brought, run, body.steps))
    is_sure = not any(_is_undone(run, step.goal.name) for step in body.steps)
    for at, step in enumerate(body.steps):
        called = run.library.raps.get(step.goal.name)
        if called is None or _is_undone(run, called.name):
            continue
        for note in step.annotations:
            if not isinstance(note, nodes.For) or note.formula is None:
                continue
            for found in _contrary_effect(run, step, note, bound):
                if not _may_change(brought(), net, at, note):
                    yield found
        if is_sure:
            facts = partial(beginnings.about, at)
            refused = _Refusal(run, bound).of(step.goal, facts)
            if refused is not None:
                yield _cannot_begin(step, *refused)
                continue
        held = [*beginnings.surviving(chosen, at), *beginnings.protected(at)]
        if held:
            terms = input_terms(called, step.goal)
            yield from _needless(run, step, called, terms, held, bound)


def _formulas(rap: nodes.DefineRap, method: nodes.Method) -> Iterator[nodes.Formula]:
    for formula in (rap.repeat_while, method.context):
        if formula is not None:
            yield formula


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
    sure = run.result(GUARANTEED).of(step.goal)
    clash = first_clash(run, sure, literals(note.formula), bound)
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


class _Refusal:
    """A search for the clause that keeps a goal from being reached.

    One search looks into each RAP once: its work is in proportion to the RAPs below.

    Args:
        run: the pass.
        bound: the variables with values in the method of the step.
    """

    def __init__(self, run: Pass, bound: set[str]) -> None:
        self._run = run
        self._asked = run.result(ASKED)
        self._bound = bound
        self._seen: set[str] = set()

    def of(self, goal: nodes.Goal, facts: _Facts, depth: int = 0) -> _Refused | None:
        """Return why a goal fails where some facts hold; None if it may succeed."""
        called = self._run.library.raps.get(goal.name)
        if called is None or depth > LIMITS.constraint_depth:
            return None
        if called.name in self._seen:
            return None
        self._seen.add(called.name)
        terms = input_terms(called, goal)
        for wanted in (called.preconditions, called.constraints):
            if wanted is not None:
                clash = self._clash(called, wanted, terms, facts)
                if clash is not None:
                    return called, wanted.span, clash
        return self._of_methods(called, terms, facts, depth)

    def _of_methods(
        self,
        called: nodes.DefineRap,
        terms: Mapping[str, nodes.Term],
        facts: _Facts,
        depth: int,
    ) -> _Refused | None:
        if called.monitor_state is not None or called.monitor_time is not None:
            return None
        if self._succeeds(called, terms, facts):
            return None
        refused: _Refused | None = None
        for method in called.methods:
            clash = None
            if method.context is not None:
                clash = self._in_context(called, method.context, terms, facts)
            if clash is None:
                refused = None
                break
            refused = refused or (called, method.body.span, clash)
        if refused is not None or len(called.methods) != 1:
            return refused
        (method,) = called.methods
        net = sure_net(self._run, method)
        is_long = len(steps(method)) > LIMITS.steps_below
        if net is None or is_long or method.constraints is not None:
            return None
        given = given_names(called)
        inner = Beginnings(self._run, called, method, net, (), given)
        names = variable_names(*_goals_of(method), *_formulas(called, method))
        late = {n: nodes.Var(f"{n}@{depth}") for n in names if n not in terms}
        for at, step in enumerate(steps(method)):
            if net.edges[at]:
                continue
            goal = substitute(step.goal, {**late, **terms})
            found = self.of(goal, partial(_kept, inner, at, facts), depth + 1)
            if found is not None:
                return found
        return None

    def _succeeds(
        self,
        called: nodes.DefineRap,
        terms: Mapping[str, nodes.Term],
        facts: _Facts,
    ) -> bool:
        """Return whether a goal may hold already."""
        goal = called.succeed
        if goal is None or is_never(goal):
            return False
        return self._clash(called, goal, terms, facts) is None

    def _in_context(
        self,
        called: nodes.DefineRap,
        context: nodes.Formula,
        terms: Mapping[str, nodes.Term],
        facts: _Facts,
    ) -> Clash | None:
        """Return why no branch of a context holds."""
        first: Clash | None = None
        for way in ways(context):
            clash = self._clash(called, way, terms, facts)
            if clash is None:
                return None
            first = first or clash
        return first

    def _clash(
        self,
        called: nodes.DefineRap,
        wanted: nodes.Formula,
        terms: Mapping[str, nodes.Term],
        facts: _Facts,
    ) -> Clash | None:
        """Return why a clause of a RAP does not hold, or None."""
        asked, relations = self._asked.wanted(wanted), self._run.signatures.relations
        held = of_memory(facts(asked.names)) if asked.literals else []
        every = [*held, *asked.literals]
        if not held or not may_clash(every, relations, for_any_terms=True):
            return None
        there = _in_terms_of_caller(called, wanted, terms)
        own = with_queries(self._run.library, of_memory(literals(there)))
        clash = first_clash(self._run, (), [*held, *own], self._bound)
        mine = {id(one) for one in own}
        if clash is None or id(clash.second) not in mine or id(clash.first) in mine:
            return None
        return clash


def _kept(
    inner: Beginnings, at: int, facts: _Facts, names: Collection[str]
) -> Sequence[Literal]:
    return inner.surviving(facts(names), at)


_Facts = Callable[[Collection[str]], Sequence[Literal]]
"""What holds of the facts of some names."""

_Refused = tuple[nodes.DefineRap, Span, Clash]
"""A RAP that fails, the place of its clause, and the literals that contradict."""


def _goals_of(method: nodes.Method) -> Iterator[nodes.Goal]:
    return (step.goal for step in steps(method))


def _cannot_begin(
    step: nodes.Step, called: nodes.DefineRap, place: Span, clash: Clash
) -> Diagnostic:
    return clash_at(
        CONTRARY,
        f"`{called.name}` requires {said(clash.second)}, but here "
        f"{said(clash.first)} holds",
        step.goal.span,
        Label(place, "required here"),
    )


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
    known, wanted = of_memory(held), _in_terms_of_caller(called, goal, terms)
    if entails(known, wanted, bound, run.signatures.relations) or (
        may_expand(run, known, wanted) and follows_expanded(run, known, wanted, bound)
    ):
        yield clash_at(
            NEEDLESS,
            f"`{called.name}` succeeds at once: its goal holds when the step begins",
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
    for rap in run.library.raps.values():
        yield from run.of(UNORDERED_STEPS, rap)


def _unordered(run: Pass, rap: nodes.DefineRap) -> Sequence[Diagnostic]:
    return tuple(_unordered_steps(run, rap))


UNORDERED_STEPS = RapFact(_unordered)
"""The findings about steps without an order in a RAP."""


def _unordered_steps(run: Pass, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    """Yield the first finding in each method."""
    for method in rap.methods:
        net = sure_net(run, method)
        if net is None:
            continue
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
                    f"the step `{step.tag}` requires "
                    f"`{needed.written.replace(_NEED, '')}`, which the "
                    f"step `{steps[by].tag}` brings about",
                    labels=(Label(steps[by].goal.span, "not before the other step"),),
                    help=f"add `(for {step.tag})` to the step `{steps[by].tag}`",
                )
                break


def _protected(steps: Sequence[nodes.Step]) -> Mapping[str, Sequence[Literal]]:
    """Return by tag the literals that hold when a step begins, by `for` of others."""
    found: dict[str, list[Literal]] = {}
    for step in steps:
        for note in step.annotations:
            if isinstance(note, nodes.For) and note.formula:
                found.setdefault(note.tag, []).extend(literals(note.formula))
    return found


def _known(rap: nodes.DefineRap, method: nodes.Method) -> Iterator[Literal]:
    for formula in (rap.preconditions, rap.monitor_state, method.context):
        if formula is not None:
            for part in subformulas(formula):
                yield Literal(part, True)


Brought = Mapping[str, Sequence[tuple[int, Literal]]]
"""By the name of a fact: the steps that bring such facts about, and the facts."""


def _brought(run: Pass, steps: Sequence[nodes.Step]) -> Brought:
    found: dict[str, list[tuple[int, Literal]]] = {}
    guaranteed = run.result(GUARANTEED)
    for at, step in enumerate(steps):
        for one in [*guaranteed.of(step.goal), *_of_some(run, step.goal)]:
            name = fact_name(one)
            if name:
                found.setdefault(name, []).append((at, one))
    return found


def _of_some(run: Pass, goal: nodes.Goal) -> list[Literal]:
    """Return the facts in `succeed` of a goal about things that the goal finds."""
    rap = run.library.raps.get(goal.name)
    found = [one for one in literals(rap.succeed) if fact_name(one)] if rap else []
    given = input_terms(rap, goal) if rap else {}
    names = variable_names(*(one.formula for one in found))
    late = {n: nodes.Var(f"{n}@made") for n in names if n not in given}
    loose = [one for one in found if not late.keys().isdisjoint(_names(one))]
    return put_in([one for one in loose if one.holds], {**late, **given})


def _names(one: Literal) -> Sequence[str]:
    return variable_names(one.formula)


def _missing_order(
    run: Pass,
    step: nodes.Step,
    net: Net,
    at: int,
    brought: Brought,
    sure: Container[str],
) -> tuple[int, Literal] | None:
    """Return a step that brings about what another step requires, and the fact."""
    for needed in _needed(run, step.goal, set()):
        name = fact_name(needed)
        there = brought.get(name, ())
        if name in sure or (needed.holds and _is_any(run, needed)):
            continue
        if len(there) > LIMITS.steps_of_fact:
            continue
        there = [(by, one) for by, one in there if one.holds is needed.holds]
        late = [(by, one) for by, one in there if not net.is_before(by, at)]
        if needed.holds and len(late) < len(there):
            continue
        for by, one in late:
            if by not in (at, *net.early) and _is_one(run, needed, one):
                return by, needed
    return None


def _is_any(run: Pass, needed: Literal) -> bool:
    """Return whether a need is met by any value, or by a fact about any thing."""
    fact = needed.formula
    assert isinstance(fact, nodes.Proposition)
    free = [
        isinstance(term, nodes.Var) and (term.anonymous or term.name.endswith(_NEED))
        for term in fact.args
    ]
    declared = run.signatures.relations.get(fact.name)
    is_property = declared is not None and declared.is_property
    return all(free) or (is_property and free[-1] and any(free[:-1] or free))


def _is_one(run: Pass, needed: Literal, brought: Literal) -> bool:
    """Return whether a fact that a step brings about meets a need, or a part of it.

    If a step requires that no thing is in a state, other steps each see to one thing.
    """
    needed, brought = Literal(needed.formula, True), Literal(brought.formula, True)
    names = variable_names(needed.formula)
    free = {name for name in names if name.endswith(_NEED)}
    return bool(follows([needed], [brought], free, run.signatures.relations))


def _needed(
    run: Pass, goal: nodes.Goal, seen: set[str], depth: int = 0
) -> list[Literal]:
    """Return the facts that a goal requires at its start, also in its first steps.

    Variables that the goal does not give have names with a mark of their own. The RAPs
    in `seen` are left out; the function adds each RAP that it looks into.
    """
    rap = run.library.raps.get(goal.name)
    if rap is None or rap.name in seen:
        return []
    seen.add(rap.name)
    asked = [one for f in (rap.preconditions, rap.constraints) for one in literals(f)]
    if rap.methods and all(method.context is not None for method in rap.methods):
        every = [literals(method.context) for method in rap.methods]
        asked += [one for one in every[0] if all(one in row for row in every[1:])]
    method = _sure_method(rap)
    if method is not None and depth < LIMITS.need_depth:
        known = {fact_name(one) for one in _known(rap, method)}
        net, inside = sure_net(run, method), steps(method)
        is_read = net is not None and len(inside) <= LIMITS.steps_below
        for at, step in enumerate(inside if is_read else ()):
            if net is not None and not net.edges[at]:
                inner = _needed(run, step.goal, seen, depth + 1)
                asked += [one for one in inner if fact_name(one) not in known]
    given = input_terms(rap, goal)
    names = variable_names(*(one.formula for one in asked))
    late = {n: nodes.Var(f"{n}{_NEED}") for n in names if n not in given}
    anyone = {"?": nodes.Var("?")}
    asked = [one for one in asked if fact_name(one)]
    return put_in(asked, {**anyone, **late, **given})


_NEED = "@need"
"""The end of the names of variables that a goal does not give."""


def _sure_method(rap: nodes.DefineRap) -> nodes.Method | None:
    """Return the method that a new task chooses unless the RAP has succeeded."""
    if len(rap.methods) == 1:
        return rap.methods[0]
    first = FirstValues(rap.resources)
    for method in rap.methods[:1]:
        if method.context is not None and first.holds(method.context):
            return method
    return None


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
        branches = [literals(way) for way in ways(rap.preconditions)]
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
        inner = [literals(way) for way in ways(formula)]
        return isinstance(formula, nodes.Or) and all(
            any(_is_history(one) for one in branch) for branch in inner
        )
    if isinstance(formula, nodes.And) and not literal.holds:
        return all(
            _is_history(Literal(one.formula, not one.holds))
            for one in literals(formula)
        )
    return isinstance(formula, nodes.HistoryTest) and literal.holds
