"""RAP064 to RAP066: sets, counters and plain values confused with each other (T 4.8).

A RAP declares the kinds of its own resources. Only the caller knows the kind of an
input: the use of an input in the RAP is compared with the arguments of the steps that
call the RAP.

RAP066: a set or counter where a plain value is needed [T 4.8.1] [L 6].

RAP124, RAP164 and RAP180: resources without a change, or without a query.

The use of a resource that is passed to a step is looked up in the called RAP
(`rapc.analysis.facts.resources`). A resource that is passed elsewhere is not reported.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from typing import Literal

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import EFFECTS, may_end
from rapc.analysis.facts.index import INDEX, Form, Index
from rapc.analysis.facts.logic import Always, asked_by, is_never, literals, number_of
from rapc.analysis.facts.names import renaming
from rapc.analysis.facts.resources import FirstValues, Flow, flows, overall_use
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
    Subject,
)
from rapc.base.names import nearest
from rapc.ir import nodes
from rapc.ir.walk import given_names, steps, variable_names, ways
from rapc.language.heads import CALLS
from rapc.library.library import Library

WRONG_KIND = Rule(
    code="RAP064",
    name="wrong-resource-kind",
    severity=Severity.ERROR,
    summary="a set is used as a counter, or a counter as a set",
    source="T 4.8.1",
)

NOT_A_RESOURCE = Rule(
    code="RAP065",
    name="not-a-resource",
    severity=Severity.ERROR,
    summary="a term that is neither a set nor a counter is used as one",
    fix="unsafe: writes the similar resource, if there is one",
    source="T 4.8.1",
)

Kind = Literal["set", "counter"]


class Demand(msgspec.Struct, frozen=True):
    """A term that must be a set or a counter, and its RAP."""

    term: nodes.Term
    kind: Kind
    rap: nodes.DefineRap
    #: The value that is added, removed or tested.
    amount: nodes.Term | None = None


@check(WRONG_KIND, NOT_A_RESOURCE, needs_whole="method")
def resources(run: Pass) -> Iterator[Diagnostic]:
    """Find sets used as counters, counters used as sets, and plain values as either."""
    by_input: dict[_Input, list[Demand]] = {}
    for demand in _demands(run.result(INDEX)):
        rap, term = demand.rap, demand.term
        if isinstance(term, nodes.Var) and term.anonymous:
            continue
        declared = _resource(rap, term)
        if declared is not None:
            if declared.kind != demand.kind:
                yield _wrong_kind(term, declared, demand)
        elif isinstance(term, nodes.Var) and term in rap.inputs:
            by_input.setdefault((id(rap), term.name), []).append(demand)
        else:
            yield _no_resource(run, demand)
    handed = list(_handed(run)) if by_input else []
    wanted, mixed = _settled(by_input, handed)
    yield from mixed
    for owner, term, to in handed:
        if to in wanted:
            declared = _resource(owner, term)
            if declared is not None and declared.kind != wanted[to].kind:
                yield _wrong_kind(term, declared, wanted[to])
            elif isinstance(term, nodes.Const):
                yield _no_resource(run, wanted[to], term)


def _demands(index: Index) -> Iterator[Demand]:
    """Yield every term of a RAP that must be a resource."""
    found: list[tuple[Form, nodes.Term, Kind, nodes.Term | None]] = []
    for test in index.of(nodes.SetTest):
        found.append((test.owner, test.node.args[0], "set", test.node.args[-1]))
    for call in index.of(nodes.Call):
        # A call with an unreadable argument has no argument; the reader reports the
        # error.
        if call.node.function in ("size-of", "value") and call.node.args:
            kind: Kind = "set" if call.node.function == "size-of" else "counter"
            found.append((call.owner, call.node.args[0], kind, None))
    for change in index.of(nodes.ResourceChange):
        kind = "set" if change.node.op in ("set-add", "set-sub") else "counter"
        found.append((change.owner, change.node.resource, kind, change.node.amount))
    for resource in index.of(nodes.Resource):
        first, owner = resource.node.initial, resource.owner
        assert isinstance(owner, nodes.DefineRap)
        # A counter may start with a number, not only with the value of another counter.
        if first is not None and (
            resource.node.kind == "set" or _resource(owner, first) is not None
        ):
            found.append((owner, first, resource.node.kind, None))
    for form, term, kind, amount in found:
        if isinstance(form, nodes.DefineRap):
            yield Demand(term, kind, form, amount)


def _resource(rap: nodes.DefineRap, term: nodes.Term) -> nodes.Resource | None:
    if not isinstance(term, nodes.Var):
        return None
    return next((r for r in rap.resources if r.variable.name == term.name), None)


_Input = tuple[int, str]
"""An input of a RAP, by the `id` of the RAP and the name of the input."""

_Handed = tuple[nodes.DefineRap, nodes.Term, _Input]
"""A term that a step of a RAP passes to an input."""


def _handed(run: Pass) -> Iterator[_Handed]:
    for goal in run.result(INDEX).of(nodes.Goal):
        callee = run.library.raps.get(goal.node.name)
        if callee is not None and isinstance(goal.owner, nodes.DefineRap):
            for term, variable in zip(goal.node.args, callee.inputs, strict=False):
                yield goal.owner, term, (id(callee), variable.name)


def _settled(
    by_input: Mapping[_Input, Sequence[Demand]], handed: Iterable[_Handed]
) -> tuple[dict[_Input, Demand], list[Diagnostic]]:
    """Return the required kind of each input, and the contradictory uses.

    If all steps pass resources of one kind, that kind counts; otherwise the first use.
    """
    given: dict[_Input, list[nodes.Resource]] = {}
    for owner, term, to in handed:
        declared = _resource(owner, term)
        if declared is not None:
            given.setdefault(to, []).append(declared)
    wanted = {}
    found = []
    for to, demands in by_input.items():
        kinds = {one.kind for one in demands}
        there = given.get(to, [])
        sorts = {one.kind for one in there}
        if len(sorts) == 1 and (kinds != sorts) and (len(kinds) > 1 or there[1:]):
            wrong = [one for one in demands if one.kind not in sorts]
            found.append(_wrong_kind(wrong[0].term, there[0], wrong[0]))
            continue
        first = wanted[to] = demands[0]
        other = next((one for one in demands if one.kind != first.kind), None)
        if other is not None and not there:
            found.append(_two_kinds(first, other))
    return wanted, found


def _two_kinds(first: Demand, other: Demand) -> Diagnostic:
    assert isinstance(other.term, nodes.Var)
    return WRONG_KIND.at(
        other.term.span,
        f"`{other.term.name}` is a {first.kind}, not a {other.kind}",
        labels=(Label(first.term.span, f"used as a {first.kind} here"),),
    )


def _wrong_kind(
    term: nodes.Term, declared: nodes.Resource, demand: Demand
) -> Diagnostic:
    name = declared.variable.name
    labels = [Label(declared.variable.span, f"declared as a {declared.kind} here")]
    if demand.term is not term:
        labels.append(Label(demand.term.span, f"used as a {demand.kind} here"))
    return WRONG_KIND.at(
        term.span,
        f"`{name}` is a {declared.kind}, not a {demand.kind}",
        labels=tuple(labels),
        about=(Subject(term.span, name),),
    )


def _no_resource(
    run: Pass, demand: Demand, given: nodes.Term | None = None
) -> Diagnostic:
    term = given or demand.term
    labels: tuple[Label, ...] = ()
    if given is not None:
        labels = (Label(demand.term.span, f"used as a {demand.kind} here"),)
    what, name, near = "this", "", None
    if isinstance(term, nodes.Var):
        name = term.name
        what = f"`{name}`"
        near = nearest(term.name, (r.variable.name for r in demand.rap.resources))
    return NOT_A_RESOURCE.at(
        term.span,
        f"{what} is not a {demand.kind}",
        labels=labels,
        help=f"did you mean `{near}`?"
        if near
        else f"declare the resource: `(resources ({demand.kind} ?name))`",
        fix=renaming(run.library.files, name, near, [term.span]),
        about=tuple(Subject(term.span, name) for name in _mixed_up(term, demand)),
    )


def _mixed_up(term: nodes.Term, demand: Demand) -> Iterator[str]:
    """Yield the terms in place of a resource, or beside the resource."""
    for one in (term, demand.amount):
        if isinstance(one, nodes.Var):
            yield one.name


RESOURCE_AS_VALUE = Rule(
    code="RAP066",
    name="resource-as-value",
    severity=Severity.ERROR,
    summary="a set or counter is used where a plain value is required",
    fix="unsafe: writes the `value` of the counter",
    source="T 4.8.1",
)


@check(RESOURCE_AS_VALUE, needs_whole="method")
def resource_as_value(run: Pass) -> Iterator[Diagnostic]:
    """Find sets and counters where a plain value is needed."""
    index = run.result(INDEX)
    resources: dict[tuple[int, str], tuple[str, nodes.Var]] = {
        (id(use.owner), use.node.variable.name): (use.node.kind, use.node.variable)
        for use in index.of(nodes.Resource)
    }
    resources.update(_inputs(index))
    effects = {id(use.node.pattern) for use in index.of(nodes.DeclaredEffect)}
    for use in index.of(nodes.Var) if resources else ():
        key = (id(use.owner), use.node.name)
        if key not in resources or id(use.parent) in effects:
            continue
        kind, declared = resources[key]
        if use.node is declared or isinstance(use.parent, nodes.DefineRap):
            continue
        if _needs_value(use.node, use.parent, run.library.functions):
            yield _as_value(use.node, kind, declared)
    for term, kind, declared in _handed_on(run, resources):
        yield _as_value(term, kind, declared)


_Known = Mapping[tuple[int, str], tuple[str, nodes.Var]]
"""Resources by their form and name: the kind, and the declaration."""


def _handed_on(
    run: Pass, resources: _Known
) -> Iterator[tuple[nodes.Var, str, nodes.Var]]:
    """Yield resources that steps pass to inputs that are used only as plain values."""
    handed: dict[_Input, list[tuple[nodes.Var, _Input]]] = {}
    for owner, term, to in _handed(run) if resources else ():
        if isinstance(term, nodes.Var) and (id(owner), term.name) in resources:
            handed.setdefault(to, []).append((term, (id(owner), term.name)))
    uses: dict[_Input, set[bool]] = {}
    for use in run.result(INDEX).of(nodes.Var) if handed else ():
        key = (id(use.owner), use.node.name)
        if key in handed and not isinstance(use.parent, nodes.DefineRap):
            plain = _needs_value(use.node, use.parent, run.library.functions)
            uses.setdefault(key, set()).add(plain)
    for to, terms in handed.items():
        for term, resource in terms if uses.get(to) == {True} else ():
            yield term, *resources[resource]


def _inputs(index: Index) -> Iterator[tuple[tuple[int, str], tuple[str, nodes.Var]]]:
    """Yield the inputs that their RAP changes as sets or counters."""
    for use in index.of(nodes.ResourceChange):
        rap, term = use.owner, use.node.resource
        if isinstance(rap, nodes.DefineRap) and isinstance(term, nodes.Var):
            for variable in rap.inputs:
                if variable.name == term.name:
                    kind = use.node.op.split("-")[0]
                    yield (id(rap), term.name), (kind, variable)


def _needs_value(
    variable: nodes.Var, parent: nodes.Node, functions: Container[str]
) -> bool:
    """Return whether the parent of a variable accepts only plain values."""
    match parent:
        case nodes.Goal() | nodes.Resource():
            needed = False
        case nodes.Pattern():
            needed = parent.name not in functions
        case nodes.Call():
            needed = parent.function in CALLS and parent.function not in _LOOK_INSIDE
        case nodes.SetTest():
            needed = variable is not parent.args[0]
        case nodes.ResourceChange():
            needed = variable is parent.amount
        case nodes.DefineRap():
            needed = variable is parent.duration
        case _:
            needed = True
    return needed


_LOOK_INSIDE = ("size-of", "value")


def _as_value(variable: nodes.Var, kind: str, declared: nodes.Var) -> Diagnostic:
    counter = kind == "counter"
    content = f"(value {variable.name})"
    fix = Fix(
        Applicability.UNSAFE,
        "write the value of the counter",
        (Edit(variable.span, content),),
    )
    return RESOURCE_AS_VALUE.at(
        variable.span,
        f"expected a plain value, not the {kind} `{variable.name}`",
        labels=(Label(declared.span, "declared here"),),
        help=f"write `{content}` for the value of the counter"
        if counter
        else f"query `(member {variable.name} x)` or `(size-of {variable.name})`",
        fix=fix if counter else None,
        about=(Subject(variable.span, variable.name),),
    )


IDLE = Rule(
    code="RAP124",
    name="idle-resource",
    severity=Severity.WARNING,
    summary="a set or counter is queried, but never changed in the required way",
    ignore="where a host or a problem solver changes the resource",
    source="T 4.8.1",
)


UNREAD = Rule(
    code="RAP164",
    name="unread-resource",
    severity=Severity.INFO,
    opt_in=True,
    summary="a set or counter is changed, but never queried",
    ignore="where a counter shows the progress of a loop to the "
    "interpreter or to the user",
    source="T 4.8",
)


UNLIMITED = Rule(
    code="RAP180",
    name="unlimited-loop",
    severity=Severity.WARNING,
    summary="a RAP counts or collects its rounds, but no formula limits the rounds",
    ignore="where another task ends the task",
    source="T 4.8",
)


@check(IDLE, UNREAD, UNLIMITED, needs_whole="form")
def idle_resource(run: Pass) -> Iterator[Diagnostic]:
    """Find resources without a change, or with a change in the wrong direction."""
    index = run.result(INDEX)
    if not index.of(nodes.Resource):
        return
    every = flows(index)
    always = Always(run.signatures)
    ended = _ended_by_others(run.library)
    for rap in run.library.raps.values():
        limited = rap.name in ended or _is_limited(run, rap)
        for resource in rap.resources:
            own = every[id(rap), resource.variable.name]
            uses = overall_use(own, every, run.library)
            yield from _judge(resource, uses, rap, None if limited else always)


def _judge(
    resource: nodes.Resource, uses: Flow, rap: nodes.DefineRap, always: Always | None
) -> Iterator[Diagnostic]:
    """Yield the findings about a resource; `always` is None if rounds are limited."""
    name = resource.variable.name
    if uses.escapes:
        return
    if not uses.asked:
        if not uses.changes:
            message = f"nothing uses the {resource.kind} `{name}`"
            yield _idle(resource, uses, message)
        elif always is not None and _is_unlimited(resource, uses, rap, always):
            yield _unlimited(resource, uses, rap)
        else:
            yield _unread(resource, uses)
        return
    if not uses.changes and resource.initial is None:
        what = "adds to" if resource.kind == "set" else "changes"
        yield _idle(resource, uses, f"nothing {what} `{name}`")
    elif not uses.changes and _is_awaited(uses, rap):
        message = f"nothing changes `{name}`, and `succeed` waits for a change"
        yield _idle(resource, uses, message)
    elif resource.kind == "set" and resource.initial is None:
        if all(change.op == "set-sub" for change in uses.changes):
            yield _idle(resource, uses, f"nothing adds to `{name}`")
    elif resource.kind == "counter":
        yield from _wrong_way(resource, uses, rap)


def _wrong_way(
    resource: nodes.Resource, uses: Flow, rap: nodes.DefineRap
) -> Iterator[Diagnostic]:
    """Yield a finding if a counter only moves away from the goal of a clause."""
    name, first = resource.variable.name, FirstValues((resource,))
    for clause, formula, sign in (
        ("succeed", rap.succeed, 1),
        ("repeat-while", rap.repeat_while, -1),
    ):
        way = sign * _wanted(formula, name, first if sign > 0 else FirstValues(()))
        if sign < 0 and first.fails(formula) is not None:
            continue
        if way and all(_way(change) == -way for change in uses.changes):
            turn = "fall" if way < 0 else "rise"
            yield _idle(
                resource,
                uses,
                f"`{clause}` waits for `{name}` to {turn}, but `{name}` never does",
            )
            return


def _unread(resource: nodes.Resource, uses: Flow) -> Diagnostic:
    return UNREAD.at(
        resource.variable.span,
        f"nothing queries the members of `{resource.variable.name}`"
        if resource.kind == "set"
        else f"nothing queries the value of `{resource.variable.name}`",
        labels=tuple([Label(c.span, "changed here") for c in uses.changes[:2]]),
        about=(Subject(resource.variable.span, resource.variable.name),),
    )


def _ended_by_others(library: Library) -> set[str]:
    """Return the RAPs that another step or a signal may end."""
    return {
        step.goal.name
        for rap in library.raps.values()
        for method in rap.methods
        for step in steps(method)
        for note in step.annotations
        if may_end(note) and not isinstance(note, nodes.Window)
    }


def _is_limited(run: Pass, rap: nodes.DefineRap) -> bool:
    """Return whether constraints, or contexts of changing facts, limit the rounds."""
    if rap.constraints is not None:
        return True
    changed = {effect.name for effect in run.result(EFFECTS).known(rap.name)}
    if rap.succeed is not None:
        changed -= asked_by(run.library, rap.succeed)
    return bool(rap.methods) and all(
        method.context is not None
        and not changed.isdisjoint(asked_by(run.library, method.context))
        for method in rap.methods
    )


def _is_unlimited(
    resource: nodes.Resource, uses: Flow, rap: nodes.DefineRap, always: Always
) -> bool:
    """Return whether a resource makes each round differ, and nothing limits these."""
    if rap.succeed is None or is_never(rap.succeed):
        return False
    given = given_names(rap)
    limits = [one for one in (rap.succeed, rap.repeat_while) if one is not None]
    own = {other.variable.name for other in rap.resources}
    if not own.isdisjoint(variable_names(*limits)):
        return False
    if resource.kind == "set":
        return any(
            isinstance(change.amount, nodes.Var) and change.amount.name not in given
            for change in uses.changes
        )
    loop = rap.repeat_while
    return loop is None or always.holds(loop, given)


def _unlimited(
    resource: nodes.Resource, uses: Flow, rap: nodes.DefineRap
) -> Diagnostic:
    """Return a finding: each change makes a round differ, so that none is futile."""
    name = resource.variable.name
    query = f"(member {name} x)" if resource.kind == "set" else f"(value {name})"
    return UNLIMITED.at(
        uses.changes[0].span,
        f"`{rap.name}` repeats without a limit: no formula queries `{name}`",
        labels=(Label(resource.variable.span, "declared here"),),
        help=f"query `{query}` in `repeat-while` or in `succeed`",
        about=(Subject(resource.variable.span, name),),
    )


def _idle(resource: nodes.Resource, uses: Flow, message: str) -> Diagnostic:
    changes = [Label(change.span, "changed here") for change in uses.changes]
    asked = [Label(one.span, "queried here") for one in uses.asked[:1]]
    return IDLE.at(
        uses.changes[0].span if uses.changes else resource.variable.span,
        message,
        labels=(*changes[1:3], *asked),
        about=(Subject(resource.variable.span, resource.variable.name),),
    )


def _is_awaited(uses: Flow, rap: nodes.DefineRap) -> bool:
    goal = rap.succeed
    if goal is None or isinstance(goal, nodes.Or):
        return False
    own = [one.span.start for one in uses.asked if one.span.file == goal.span.file]
    return any(goal.span.start <= start < goal.span.end for start in own)


def _wanted(goal: nodes.Formula | None, name: str, first: FirstValues) -> int:
    """Return the direction of a counter towards `succeed`: -1, 1, or 0 if unknown."""
    for literal in (one for way in ways(goal) for one in literals(way)):
        test = literal.formula
        if not isinstance(test, nodes.Compare) or not literal.holds:
            continue
        if first.holds(test):
            continue
        for one, other, sign in (
            (test.left, test.right, 1),
            (test.right, test.left, -1),
        ):
            if _is_value(one, name) and number_of(other) is not None:
                return sign * _SIGNS.get(test.op, 0)
    return 0


_SIGNS = {"<": -1, "<=": -1, ">": 1, ">=": 1}


def _is_value(term: nodes.Term, name: str) -> bool:
    if not isinstance(term, nodes.Call) or term.function != "value":
        return False
    (arg,) = term.args if len(term.args) == 1 else (None,)
    return isinstance(arg, nodes.Var) and arg.name == name


def _way(change: nodes.ResourceChange) -> int:
    """Return the direction of a change of a counter; 0 if the amount is unknown."""
    amount = number_of(change.amount)
    if amount is None or amount <= 0:
        return 0
    return 1 if change.op == "counter-add" else -1


IDLE_AMOUNT = Rule(
    code="RAP172",
    name="idle-amount",
    severity=Severity.WARNING,
    summary="a counter changes by 0",
    ignore="never: remove the change if the counter must not change",
    source="T 4.8.2",
)


@check(IDLE_AMOUNT)
def idle_amount(run: Pass) -> Iterator[Diagnostic]:
    """Find changes of counters by 0."""
    for change in run.result(INDEX).of(nodes.ResourceChange):
        if number_of(change.node.amount) == 0:
            yield IDLE_AMOUNT.at(
                change.node.span,
                "a change by 0 leaves the counter as it is",
                help="give the amount of the change",
            )
