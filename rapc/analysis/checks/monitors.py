"""Monitors, and the standing tasks that wait for their monitors."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from itertools import combinations

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import (
    below_agendas,
    done_by_method,
    endless,
    is_described,
    reached,
    request_effects,
    rule_effects,
    things_needed,
)
from rapc.analysis.facts.index import INDEX, Form, Index
from rapc.analysis.facts.logic import (
    Always,
    Literal,
    apart,
    asked_by,
    asked_through,
    conjunction,
    entails,
    expanded,
    fact_name,
    follows,
    is_computed,
    is_never,
    literals,
    number_of,
)
from rapc.analysis.facts.statistics import LIMITS, THRESHOLDS
from rapc.analysis.facts.task_nets import Net, sure_nets
from rapc.analysis.facts.variables import BINDINGS
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.base.values import Number, format_atom
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import (
    formulas,
    given_names,
    input_terms,
    steps,
    substitute,
    through_queries,
    variable_names,
    ways,
)
from rapc.library.library import Library, calls_of

AGE_IN_MONITOR = Rule(
    code="RAP068",
    name="age-in-monitor",
    severity=Severity.WARNING,
    summary="a monitor binds the age of a fact, so no time wakes its task",
    ignore="where a `monitor-time` clause also wakes the task",
    source="T 4.1.1, 4.7.1",
)


@check(AGE_IN_MONITOR, needs_whole="form")
def age_in_monitor(run: Pass) -> Iterator[Diagnostic]:
    """Find monitors that bind an age instead of testing the age."""
    for believe in run.result(BINDINGS).ages:
        yield AGE_IN_MONITOR.at(
            believe.age.span,
            "a monitor binds the age of a fact, so no time wakes its task",
            help="give `believe` a number: `(not (believe p 30))` wakes the task "
            "when p is 30 old",
        )


ENDLESS_TASK = Rule(
    code="RAP134",
    name="endless-task",
    severity=Severity.WARNING,
    summary="an agenda submits a task that never ends",
    fix="unsafe: writes `:background true`",
    ignore="where a time limit or the user ends the run",
    source="T 5.4",
)


UNHEARD_MONITOR = Rule(
    code="RAP135",
    name="unheard-monitor",
    severity=Severity.WARNING,
    summary="a monitor queries a fact that nothing in the library changes",
    ignore="where a host program asserts the fact",
    source="T 4.7.2",
)


UNREADY_REACTION = Rule(
    code="RAP138",
    name="unready-reaction",
    severity=Severity.WARNING,
    summary="a standing task has no method for some of the states that wake the task",
    ignore="where the fact always holds in the world when the monitor holds",
    source="T 4.7.1",
)


FAILING_REACTION = Rule(
    code="RAP139",
    name="failing-reaction",
    severity=Severity.WARNING,
    summary="a standing task ends with a failure if a condition of its RAP "
    "does not hold",
    ignore="where the task must end in this case",
    source="T 4.4.2, 4.7.1",
)


@check(ENDLESS_TASK, UNHEARD_MONITOR, UNREADY_REACTION, FAILING_REACTION)
def standing(run: Pass) -> Iterator[Diagnostic]:
    """Find tasks that never end but should, and monitors of facts that never hold."""
    library = run.library
    never_done = endless(below_agendas(library))
    for agenda in library.agendas.values():
        for task in agenda.tasks:
            cause = never_done.get(task.goal.name)
            if cause is not None and not task.background and task.deadline is None:
                work = any(
                    other.goal.name not in never_done and not other.background
                    for other in agenda.tasks
                )
                yield _endless(task, cause, work)
    if run.complete and is_described(library):
        told = (name for name, _ in _told(run.result(INDEX)))
        changed = {*library.functions, *told}
        idle = _never_asked_for(library, run.result(INDEX))
        always = Always(run.signatures)
        for rap in library.raps.values():
            if rap.monitor_state is not None and rap.monitor_time is None:
                yield from _unheard(library, rap.monitor_state, changed, idle)
            yield from _unready(library, rap, changed, always)
            yield from _failing(library, rap, changed, always)


IDLE_WAIT = Rule(
    code="RAP185",
    name="idle-wait",
    severity=Severity.WARNING,
    summary="a RAP without methods fails where it should wait or succeed",
    ignore="where the RAP only tests its `succeed`, and the caller handles the failure",
    source="T 4.7.1",
)


POWERLESS_STEP = Rule(
    code="RAP187",
    name="powerless-step",
    severity=Severity.WARNING,
    summary="a step that waits lacks a higher priority than the busy step it ends",
    ignore="where the other step has pauses in which the waiting step can end it",
    source="T 4.7.1, 5.4.1",
)


UNHEEDED_STEP = Rule(
    code="RAP189",
    name="unheeded-step",
    severity=Severity.WARNING,
    summary="a step only waits for a state, and its end has no effect",
    ignore="where the wait is shown in a trace or a report only",
    source="T 4.7.1",
)


@check(IDLE_WAIT, POWERLESS_STEP, UNHEEDED_STEP, needs_whole="form")
def waiting_steps(run: Pass) -> Iterator[Diagnostic]:
    """Find RAPs and steps that wait for a state in vain."""
    for rap in run.library.raps.values():
        goal, monitor = rap.succeed, rap.monitor_state
        if _only_fails(rap):
            yield IDLE_WAIT.at(
                rap.name_span,
                f"each task of `{rap.name}` waits and then fails: the RAP has neither "
                "`succeed` nor a method",
                help="add a method, or `succeed` with the awaited state",
            )
        if rap.methods or goal is None or isinstance(goal, nodes.Truth):
            continue
        if monitor is not None and not _serves_goal(run, rap, monitor, goal):
            yield IDLE_WAIT.at(
                monitor.span,
                f"`{rap.name}` fails when this wakes the task: `succeed` requires more",
                labels=(Label(goal.span, "this does not follow from the monitor"),),
                help="query the same in `monitor-state` and in `succeed`",
            )
    told: set[str] = set()
    for _, method, net in sure_nets(run):
        own = steps(method)
        ends = {at: _ended_by(step) for at, step in enumerate(own)}
        ended: dict[str, list[int]] = {}
        for at, tags in ends.items():
            for tag in tags:
                ended.setdefault(tag, []).append(at)
        for at, step in enumerate(own):
            called = run.library.raps.get(step.goal.name)
            if called is None:
                continue
            others = [o for o in ended.get(step.tag, ()) if o != at]
            if (others or ends[at]) and _only_tests(called) and called.name not in told:
                told.add(called.name)
                yield _untimely(called, step)
            elif called.monitor_state is not None:
                yield from _in_vain(run.library, called, net, own, at, others, ends[at])


def _only_fails(rap: nodes.DefineRap) -> bool:
    """Return whether a RAP waits, but has neither a goal nor a method.

    A RAP without a monitor stands for a RAP of another library, or for a solver.
    """
    waits = rap.monitor_state is not None or rap.monitor_time is not None
    goal = rap.succeed is not None or rap.effects or rap.outputs
    return waits and not goal and not rap.methods


def _ended_by(step: nodes.Step) -> list[str]:
    """Return the tags of the steps that end a step by `until`."""
    until = nodes.UntilEnd | nodes.UntilStart
    return [note.tag for note in step.annotations if isinstance(note, until)]


def _only_tests(rap: nodes.DefineRap) -> bool:
    """Return whether a RAP does nothing and waits for nothing."""
    waits = rap.monitor_state is not None or rap.monitor_time is not None
    plain = rap.succeed is None or isinstance(rap.succeed, nodes.Truth)
    return not (rap.methods or waits or plain)


def _untimely(called: nodes.DefineRap, step: nodes.Step) -> Diagnostic:
    assert called.succeed is not None
    return IDLE_WAIT.at(
        called.succeed.span,
        f"`{called.name}` does not wait for this: it has no monitor and no method",
        labels=(Label(step.span, "this step is to wait beside another step"),),
        help="write the awaited state in `monitor-state`, too",
    )


def _is_busy(library: Library, step: nodes.Step) -> bool:
    """Return whether a step has steps in a loop, or in an order."""
    below = reached(library, [step.goal.name]).values()
    return any(
        rap.repeat_while is not None or len(steps(method)) > 1
        for rap in below
        for method in rap.methods
        if isinstance(method.body, nodes.TaskNet)
    )


def _in_vain(
    library: Library,
    called: nodes.DefineRap,
    net: Net,
    own: Sequence[nodes.Step],
    at: int,
    others: Sequence[int],
    ended_by: Sequence[str],
) -> Iterator[Diagnostic]:
    """Find a step with a monitor that is too weak, or whose end has no effect."""
    step = own[at]
    for other in others:
        if own[other].priority >= step.priority and _is_busy(library, own[other]):
            yield POWERLESS_STEP.at(
                step.span,
                f"step `{step.tag}` ends `{own[other].tag}`, but has no higher "
                "priority",
                labels=(Label(own[other].span, f"priority {own[other].priority}"),),
                help="give the waiting step a higher priority, so that it is selected "
                "first",
            )
            return
    counts = any(isinstance(note, nodes.ResourceChange) for note in step.annotations)
    if others or not ended_by or called.methods or step.goal.outputs:
        return
    if counts or called.effects:
        return
    enders = [net.tags[tag] for tag in ended_by]
    after = [to for to in range(len(own)) if net.is_before(at, to)]
    if all(any(net.is_before(end, to) for end in enders) for to in after):
        yield UNHEEDED_STEP.at(
            step.span,
            f"step `{step.tag}` only waits, and its end has no effect on other steps",
            labels=tuple(Label(own[end].span, "ends the wait") for end in enders),
            help=f"add `(until-end {step.tag})` to the step that is to end",
        )


def _serves_goal(
    run: Pass, rap: nodes.DefineRap, monitor: nodes.Formula, goal: nodes.Formula
) -> bool:
    """Return whether one way of a monitor to hold also makes a goal hold."""
    given, relations = given_names(rap), run.signatures.relations
    for way in ways(monitor):
        held = literals(way)
        for end in ways(goal):
            facts = conjunction(expanded(run.library, literals(end)))
            known = list(expanded(run.library, held))
            for formula, there in ((end, held), (facts, known)):
                wanted = apart(formula, given, "@goal")
                free = set(variable_names(wanted)) - given
                if follows(literals(wanted), there, free, relations, given):
                    return True
    return False


CONTRARY_WAIT = Rule(
    code="RAP191",
    name="contrary-wait",
    severity=Severity.WARNING,
    summary="a RAP waits for the contrary of the state that other RAPs wait for",
    ignore="where this RAP alone needs the contrary",
    source="T 4.7.2",
)


@check(CONTRARY_WAIT, needs_whole="form")
def contrary_waits(run: Pass) -> Iterator[Diagnostic]:
    """Find a RAP that waits for the contrary of what several other RAPs wait for.

    A standing task reacts to a state, and may well react to the contrary. A RAP with
    other actions than these RAPs may need the contrary.
    """
    waiting: dict[Literal, list[nodes.DefineRap]] = {}
    for rap in run.library.raps.values():
        if rap.monitor_state is not None and not is_never(rap.succeed):
            for one in literals(rap.monitor_state):
                waiting.setdefault(one, []).append(rap)
    for one, raps in waiting.items():
        others = waiting.get(Literal(one.formula, not one.holds), [])
        if len(raps) != 1 or len(others) < THRESHOLDS.same_wait:
            continue
        actions = [_actions(rap, run.library) for rap in (*raps, *others)]
        shared = actions[0] & set[str]().union(*actions[1:])
        if shared:
            yield CONTRARY_WAIT.at(
                one.span,
                f"`{raps[0].name}` waits for the contrary of what {len(others)} other "
                "RAPs wait for",
                labels=(Label(others[0].span, f"`{others[0].name}` is one of them"),),
                help="query the same state, unless this RAP needs the contrary",
            )


def _actions(rap: nodes.DefineRap, library: Library) -> set[str]:
    """Return the names of the goals and requests of the methods of a RAP."""
    bodies = [method.body for method in rap.methods]
    requests = [one.request.name for one in bodies if isinstance(one, nodes.Primitive)]
    return {*calls_of(rap, library.raps), *requests}


def _endless(task: nodes.GivenTask, cause: Span, work: bool) -> Diagnostic:
    """Return the finding about a task; `work` if its agenda has other tasks as work.

    A run that has only background tasks ends at once. Without other work the usual fix
    does not help.
    """
    end = task.span.end - 1
    help_ = "write `:background true` for the task"
    if not work:
        help_ += ", and add a task that ends: a run lasts as long as such a task"
    edit = Edit(Span(task.span.file, end, end), " :background true")
    return ENDLESS_TASK.at(
        task.goal.span,
        f"`{task.goal.name}` never ends, so a run with this task never ends",
        labels=(Label(cause, "this formula never holds"),),
        help=help_,
        fix=Fix(Applicability.UNSAFE, "add `:background true`", (edit,)),
    )


# --- facts without a change -----------------------------------------------------------


def _told(index: Index) -> Iterator[tuple[str, Form]]:
    """Yield the facts that forms assert or erase."""
    for one in index.uses():
        if one.use in ("asserted", "erased"):
            yield one.name, one.owner


def _unready(
    library: Library, rap: nodes.DefineRap, changed: Container[str], always: Always
) -> Iterator[Diagnostic]:
    """Yield a fact that all methods require, but the monitor does not query."""
    if rap.monitor_state is None or not is_never(rap.succeed):
        return
    waking = [rap.monitor_state, rap.repeat_while]
    asked = {n for one in waking if one is not None for n in asked_by(library, one)}
    every = [literals(method.context) for method in rap.methods]
    given = {variable.name for variable in rap.inputs}
    if rap.repeat_while is not None:
        given.update(variable_names(rap.repeat_while))
    for one in every[0] if every else ():
        if not all(one in there for there in every):
            continue
        if one.holds and always.holds(one.formula, given):
            continue
        name = fact_name(one)
        if name in changed and name not in asked and not is_computed(library, name):
            yield UNREADY_REACTION.at(
                one.span,
                f"`{rap.name}` has no method if this does not hold, and fails "
                "without another try",
                labels=(
                    Label(rap.monitor_state.span, "only this formula wakes the task"),
                ),
                help="add a method with `otherwise`, or require this formula in the "
                "monitor",
            )
            return


def _failing(
    library: Library, rap: nodes.DefineRap, changed: Container[str], always: Always
) -> Iterator[Diagnostic]:
    """Yield a condition of a standing task that its monitor does not query."""
    monitor = rap.monitor_state
    if monitor is None or not is_never(rap.succeed):
        return
    heard = asked_by(library, monitor)
    given = {variable.name for variable in rap.inputs}
    conditions = [f for c, f in clauses.held(clauses.RAP, rap) if c.is_condition]
    for one in (one for formula in conditions for one in literals(formula)):
        asked = asked_through(library, one.formula)
        facts = set() if asked is None else asked - library.queries.keys()
        if not any(name in changed for name in facts) or facts & heard:
            continue
        if one.holds and always.holds(one.formula, given):
            continue
        yield FAILING_REACTION.at(
            one.span,
            f"`{rap.name}` fails without another try if it wakes when this "
            "does not hold",
            labels=(Label(monitor.span, "only this formula wakes the task"),),
            help="require this formula in the monitor, or in the contexts of "
            "the methods",
        )
        return


def _never_asked_for(library: Library, index: Index) -> Mapping[str, str]:
    """Return the facts that only unused primitives change: by fact, the primitive."""
    primitives = library.primitives
    raps = (form for form in library.forms if isinstance(form, nodes.DefineRap))
    bodies = (method.body for rap in raps for method in rap.methods)
    requested = {b.request.name for b in bodies if isinstance(b, nodes.Primitive)}
    wanted = requested & primitives.keys()
    idle = [form for name, form in primitives.items() if name not in wanted]
    found: dict[str, str] = {}
    for form in idle:
        data = [library.data[name] for name in form.tells if name in library.data]
        effects = [*(on.effects for on in form.on), *(one.on or () for one in data)]
        for effect in (one for there in effects for one in there):
            found.setdefault(effect.pattern.name, form.name)
    told = {name for one in wanted for name in primitives[one].tells}
    own = {id(form) for form in idle} | {
        id(library.data[name])
        for form in idle
        for name in form.tells
        if name in library.data and name not in told
    }
    for name, owner in _told(index) if found else ():
        if id(owner) not in own:
            found.pop(name, None)
    return found


def _unheard(
    library: Library,
    monitor: nodes.Formula,
    changed: Container[str],
    idle: Mapping[str, str],
) -> Iterator[Diagnostic]:
    asked = asked_through(library, monitor)
    if asked is None:
        return
    facts = sorted(asked - library.queries.keys())
    known = library.properties.keys() | library.propositions.keys()
    if not facts or not known.issuperset(facts):
        return
    names = ", ".join(f"`{name}`" for name in facts)
    if not any(name in changed for name in facts):
        yield UNHEARD_MONITOR.at(
            monitor.span,
            f"nothing in the library changes {names}",
            help="query a fact that a primitive, a datum or a rule changes, or "
            "declare the change",
        )
    elif all(name in idle for name in facts if name in changed):
        first = next(name for name in facts if name in idle)
        yield UNHEARD_MONITOR.at(
            monitor.span,
            f"no RAP uses a primitive that changes {names}",
            help=f"`{idle[first]}` does: use `{idle[first]}` in a RAP from time "
            "to time",
        )


RIVAL_REACTIONS = Rule(
    code="RAP136",
    name="rival-reactions",
    severity=Severity.WARNING,
    summary="two standing tasks of equal priority wake by the same fact "
    "and use the same thing",
    ignore="where the two tasks may run in any order",
    source="T 5.4.1",
)


UNDOING_REACTIONS = Rule(
    code="RAP137",
    name="undoing-reactions",
    severity=Severity.WARNING,
    summary="two standing tasks bring about the states that wake each other",
    ignore="where the tasks alternate on purpose, for example to make a lamp blink",
    source="T 4.7.1",
)


@check(RIVAL_REACTIONS, UNDOING_REACTIONS)
def rivals(run: Pass) -> Iterator[Diagnostic]:
    """Find standing tasks of an agenda that interfere with each other."""
    told: set[tuple[str, str]] = set()
    for agenda in run.library.agendas.values():
        tasks = [one for one in agenda.tasks if one.background]
        for one, other in combinations(tasks[: LIMITS.standing_tasks], 2):
            if one.goal.name == other.goal.name:
                continue
            if (agenda.name, other.goal.name) in told:
                continue
            for found in _between(run, one, other):
                told.add((agenda.name, other.goal.name))
                yield found


def _between(
    run: Pass, one: nodes.GivenTask, other: nodes.GivenTask
) -> Iterator[Diagnostic]:
    library = run.library
    first, second = library.raps.get(one.goal.name), library.raps.get(other.goal.name)
    if first is None or second is None:
        return
    if first.monitor_state is None or second.monitor_state is None:
        return
    if _wakes(run, one.goal, other.goal) and _wakes(run, other.goal, one.goal):
        yield UNDOING_REACTIONS.at(
            second.monitor_state.span,
            f"`{first.name}` and `{second.name}` wake each other without end",
            labels=(
                Label(first.monitor_state.span, "this formula becomes true in turn"),
            ),
            help="add a condition to one of the monitors",
        )
    elif one.priority == other.priority:
        shared = _shared_facts(library, one.goal, other.goal)
        both = sorted(
            _needed(library, first) & _needed(library, second), key=format_formula
        )
        if shared and both:
            yield RIVAL_REACTIONS.at(
                other.span,
                f"`{first.name}` and `{second.name}` wake by `{shared[0]}`, use "
                f"`{format_formula(both[0])}`, and have equal priority",
                labels=(Label(one.span, f"priority {one.priority}, too"),),
                help="give the more urgent task a higher priority",
            )


def _monitor(library: Library, goal: nodes.Goal) -> nodes.Formula:
    """Return the monitor of the RAP of a goal, with the arguments of the goal."""
    rap = library.raps[goal.name]
    assert rap.monitor_state is not None
    return substitute(rap.monitor_state, input_terms(rap, goal))


def _shared_facts(
    library: Library, first: nodes.Goal, second: nodes.Goal
) -> Sequence[str]:
    """Return the facts that can wake both tasks."""
    monitor = _monitor(library, first)
    if asked_through(library, monitor) is None:
        return ()
    others = list(_facts(library, _monitor(library, second)))
    return sorted(
        {
            one.name
            for one in _facts(library, monitor)
            if any(_may_be_one(one, other) for other in others)
        }
    )


def _facts(library: Library, monitor: nodes.Formula) -> Iterator[nodes.Proposition]:
    for one in through_queries(monitor, library.queries):
        if isinstance(one, nodes.Proposition) and one.name not in library.queries:
            yield one


def _may_be_one(one: nodes.Proposition, other: nodes.Proposition) -> bool:
    """Return whether a fact may match both, as far as constants determine."""
    return one.name == other.name and not any(
        isinstance(left, nodes.Const)
        and isinstance(right, nodes.Const)
        and left != right
        for left, right in zip(one.args, other.args, strict=False)
    )


def _needed(library: Library, rap: nodes.DefineRap) -> frozenset[nodes.Thing]:
    """Return the things that methods of a RAP and its descendants claim."""
    methods = [m for rap in reached(library, [rap.name]).values() for m in rap.methods]
    return frozenset(
        thing for method in methods for thing in things_needed(library, method)
    )


def _wakes(run: Pass, one: nodes.Goal, other: nodes.Goal) -> bool:
    """Return whether a task surely asserts facts that wake another task."""
    library, relations = run.library, run.signatures.relations
    monitor, rap = _monitor(library, other), library.raps[one.name]
    given = input_terms(rap, one)
    return bool(rap.methods) and all(
        entails(
            [
                Literal(substitute(fact.formula, given), fact.holds)
                for fact in done_by_method(library, method)
            ],
            monitor,
            (),
            relations,
        )
        for method in rap.methods
    )


FRESHER_THAN_SENSED = Rule(
    code="RAP157",
    name="fresher-than-sensed",
    severity=Severity.WARNING,
    summary="a belief must be younger than the interval between two "
    "sensings of the fact",
    ignore="where the belief must hold only directly after sensing",
    source="T 4.1.1",
)


class _Sensed(msgspec.Struct, frozen=True):
    """The shortest time between two sensings of a fact, and the evidence."""

    every: Number
    said: Span


@check(FRESHER_THAN_SENSED, needs_whole="form")
def freshness(run: Pass) -> Iterator[Diagnostic]:
    """Find beliefs with a maximum age below the time between two sensings."""
    library = run.library
    believed = [
        one for one in run.result(INDEX).of(nodes.Believe) if number_of(one.node.age)
    ]
    if not believed or not run.complete or not is_described(library):
        return
    sensing = _Sensing(library)
    for part in _believed(run):
        found, age = sensing.of(part.pattern.name), number_of(part.age)
        if found is not None and age is not None and 0 < age < found.every:
            yield _fresher(part, age, found)


def _believed(run: Pass) -> Iterator[nodes.Believe]:
    """Yield the beliefs in conditions of RAPs, and in the queries of the conditions."""
    for rap in run.library.raps.values():
        for whole in formulas(rap):
            if whole.clause.is_condition:
                for part in through_queries(whole.formula, run.library.queries):
                    if isinstance(part, nodes.Believe):
                        yield part


def _fresher(believe: nodes.Believe, age: Number, sensed: _Sensed) -> Diagnostic:
    every = format_atom(sensed.every)
    return FRESHER_THAN_SENSED.at(
        believe.age.span,
        f"`{believe.pattern.name}` is sensed at most once in {every}, "
        f"and is rarely younger than {format_atom(age)}",
        labels=(Label(sensed.said, "the task that senses the fact waits here"),),
        help="allow an older belief, or sense the fact more often",
    )


class _Sensing:
    """The times between sensings of facts.

    Args:
        library: the library.
    """

    def __init__(self, library: Library) -> None:
        raps = [form for form in library.forms if isinstance(form, nodes.DefineRap)]
        self._sources = _sources(library, raps)
        self._callers: dict[str, dict[str, None]] = {}
        self._pauses = {rap.name: _pause(rap) for rap in raps}
        for rap in raps:
            for callee in calls_of(rap, library.raps):
                self._callers.setdefault(callee, {})[rap.name] = None
        agendas = (f for f in library.forms if isinstance(f, nodes.DefineAgenda))
        self._given = {task.goal.name for form in agendas for task in form.tasks}
        self._known: dict[str, _Sensed | None] = {}

    def of(self, fact: str) -> _Sensed | None:
        """Return how often a fact is sensed; None if at any time, or never."""
        if fact not in self._known:
            self._known[fact] = self._of(fact)
        return self._known[fact]

    def _of(self, fact: str) -> _Sensed | None:
        sources = self._sources.get(fact, {None: None})
        best: _Sensed | None = None
        for name in sources:
            found = None if name is None else self._every(name)
            if found is None:
                return None
            if best is None or found.every < best.every:
                best = found
        return best

    def _every(self, start: str) -> _Sensed | None:
        """Return how often tasks of a RAP start; None if at any time."""
        best: _Sensed | None = None
        waiting, seen = [start], {start}
        while waiting:
            name = waiting.pop()
            own = self._pauses[name]
            if own is not None:
                if best is None or own.every < best.every:
                    best = own
                continue
            callers = self._callers.get(name, {})
            if not callers or name in self._given:
                return None
            waiting += [one for one in callers if one not in seen]
            seen.update(callers)
        return best


def _pause(rap: nodes.DefineRap) -> _Sensed | None:
    """Return the time that a standing RAP surely waits between two rounds."""
    if not is_never(rap.succeed):
        return None
    timed = rap.monitor_time
    if timed is not None and timed.reference == "now":
        start = number_of(timed.start)
        if start is not None and start > 0:
            return _Sensed(start, timed.span)
    for one in literals(rap.monitor_state):
        if isinstance(one.formula, nodes.Believe) and not one.holds:
            age = number_of(one.formula.age)
            if age is not None and age > 0:
                return _Sensed(age, one.span)
    return None


def _sources(
    library: Library, raps: Sequence[nodes.DefineRap]
) -> dict[str, dict[str | None, None]]:
    """Return, by fact, the RAPs that may assert the fact; None for the world."""
    asked = {name for form in library.primitives.values() for name in form.tells}
    found: dict[str, dict[str | None, None]] = {}

    def bring(facts: Iterable[str], by: str | None) -> None:
        for fact in facts:
            found.setdefault(fact, {})[by] = None

    for name, datum in library.data.items():
        if name not in asked:
            bring((e.pattern.name for e in datum.on or () if not e.negated), None)
    for rap in raps:
        for method in rap.methods:
            bring((note.name for note in method.notations), rap.name)
            if isinstance(method.body, nodes.Primitive):
                effects, _ = request_effects(library, method.body.request)
                bring((one.name for one in effects if not one.gone), rap.name)
    known = {rap.name for rap in raps}
    rules: list[tuple[str | None, Sequence[nodes.Rule]]] = [
        (None, form.rules) for form in library.event_rules
    ]
    for form in library.memory_rules:
        by = form.index.name if form.index.name in known else None
        rules += [(by, case.rules) for case in form.cases]
    for by, there in rules:
        bring((one.name for one in rule_effects(there) if not one.gone), by)
    return found
