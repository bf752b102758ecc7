"""RAP064 to RAP066: sets, counters and plain values taken for each other (T 4.8).

A RAP knows the kinds of the resources that it declares. What an input is, only the
caller knows: how the RAP itself uses the input is held against what its steps are
given elsewhere.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from typing import Literal

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Form, Index, Occurrence
from rapc.analysis.renaming import renaming
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity, Subject
from rapc.base.names import nearest
from rapc.ir import nodes

WRONG_KIND = Rule(
    code="RAP064",
    name="wrong-resource-kind",
    severity=Severity.ERROR,
    summary="a set is used as a counter, or a counter as a set",
    why="""`set-add`, `set-sub`, `member`, `empty` and `size-of` work on sets;
`counter-add`, `counter-sub` and `value` on counters. On the other kind a test fails,
and an effect fails its step.""",
    source="T 4.8.1",
    example="""\
(define-rap (load ?thing))
(define-rap (load-all ?thing)
  (resources (set ?loaded))
  (method (task-net (t1 (load ?thing) (counter-add ?loaded 1)))))
""",
    better="""\
(define-rap (load ?thing))
(define-rap (load-all ?thing)
  (resources (set ?loaded))
  (method (task-net (t1 (load ?thing) (set-add ?loaded ?thing)))))
""",
)

NOT_A_RESOURCE = Rule(
    code="RAP065",
    name="not-a-resource",
    severity=Severity.ERROR,
    summary="something is used as a set or counter that cannot be one",
    why="""Only the `resources` clause makes sets and counters, and only inputs hand
them on. What a formula or a step binds is a plain value: it cannot be added to, and has
neither members nor a `value`.""",
    fix="unsafe: writes the resource that is spelled almost so, where there is one",
    source="T 4.8.1",
    example="""\
(declare-memory-proposition wanted (?number))
(define-rap (load))
(define-rap (load-all)
  (method
    (context (wanted ?number))
    (task-net (t1 (load) (counter-add ?number 1)))))
""",
    better="""\
(declare-memory-proposition wanted (?number))
(define-rap (load))
(define-rap (load-all)
  (resources (counter ?count 0))
  (method
    (context (and (wanted ?number) (< (value ?count) ?number)))
    (task-net (t1 (load) (counter-add ?count 1)))))
""",
)

Kind = Literal["set", "counter"]


class Demand(msgspec.Struct, frozen=True):
    """A term that has to be a set or a counter, and the RAP it stands in."""

    term: nodes.Term
    kind: Kind
    rap: nodes.DefineRap
    #: What is put in, taken out or looked for.
    amount: nodes.Term | None = None


@check(WRONG_KIND, NOT_A_RESOURCE, needs_whole="method")
def resources(run: Pass) -> Iterator[Diagnostic]:
    """Find sets used as counters, counters as sets, and plain values as either."""
    index = run.result(INDEX)
    by_input: dict[tuple[str, str], list[Demand]] = {}
    for demand in _demands(index):
        rap, term = demand.rap, demand.term
        if isinstance(term, nodes.Var) and term.anonymous:
            continue
        declared = _resource(rap, term)
        if declared is not None:
            if declared.kind != demand.kind:
                yield _wrong_kind(term, declared, demand)
        elif isinstance(term, nodes.Var) and _is_input(rap, term):
            by_input.setdefault((rap.name, term.name), []).append(demand)
        else:
            yield _no_resource(run, demand)
    steps = [
        (goal.owner, goal.node)
        for goal in index.of(nodes.Goal)
        if isinstance(goal.owner, nodes.DefineRap)
    ]
    wanted: dict[tuple[str, str], Demand] = {}
    if by_input:
        wanted, mixed = _settled(run, by_input, steps)
        yield from mixed
    for owner, goal in steps if wanted else ():
        yield from _check_step(run, owner, goal, wanted)


def _demands(index: Index) -> Iterator[Demand]:
    for term, kind, owner, amount in _places(index):
        if isinstance(owner, nodes.DefineRap):
            yield Demand(term, kind, owner, amount)


def _places(
    index: Index,
) -> Iterator[tuple[nodes.Term, Kind, Form, nodes.Term | None]]:
    """Every term that has to be a resource, with the kind it has to be."""
    for test in index.of(nodes.SetTest):
        yield test.node.args[0], "set", test.owner, test.node.args[-1]
    for call in index.of(nodes.Call):
        # A call whose argument could not be read has none; the reader has said so.
        if call.node.function in ("size-of", "value") and call.node.args:
            kind: Kind = "set" if call.node.function == "size-of" else "counter"
            yield call.node.args[0], kind, call.owner, None
    for effect in index.of(nodes.ResourceChange):
        kind = "set" if effect.node.op in ("set-add", "set-sub") else "counter"
        yield effect.node.resource, kind, effect.owner, effect.node.amount
    for resource in index.of(nodes.Resource):
        first = resource.node.initial
        if first is not None and not _may_be_number(resource, first):
            yield first, resource.node.kind, resource.owner, None


def _may_be_number(use: Occurrence[nodes.Resource], initial: nodes.Term) -> bool:
    """Whether a counter may begin with a number, not as a copy of another counter."""
    rap = use.owner
    assert isinstance(rap, nodes.DefineRap)
    return use.node.kind == "counter" and _resource(rap, initial) is None


def _resource(rap: nodes.DefineRap, term: nodes.Term) -> nodes.Resource | None:
    if not isinstance(term, nodes.Var):
        return None
    return next((r for r in rap.resources if r.variable.name == term.name), None)


def _is_input(rap: nodes.DefineRap, variable: nodes.Var) -> bool:
    return any(v.name == variable.name for v in rap.inputs)


_Steps = Sequence[tuple[nodes.DefineRap, nodes.Goal]]


def _settled(
    run: Pass, by_input: Mapping[tuple[str, str], Sequence[Demand]], steps: _Steps
) -> tuple[dict[tuple[str, str], Demand], list[Diagnostic]]:
    """Return for each input what it has to be, and uses that contradict the rest.

    Where all steps hand in a resource of one kind, that decides; else the first use.
    """
    given = _given(run, by_input, steps)
    wanted = {}
    found = []
    for (name, variable), demands in by_input.items():
        kinds = {one.kind for one in demands}
        handed = given.get((name, variable), [])
        sorts = {one.kind for one in handed}
        if len(sorts) == 1 and (kinds != sorts) and (len(kinds) > 1 or handed[1:]):
            wrong = [one for one in demands if one.kind not in sorts]
            found.append(_wrong_kind(wrong[0].term, handed[0], wrong[0]))
            continue
        first = demands[0]
        wanted[name, variable] = first
        other = next((one for one in demands if one.kind != first.kind), None)
        if other is not None and not handed:
            found.append(_two_kinds(first, other))
    return wanted, found


def _given(
    run: Pass, inputs: Container[tuple[str, str]], steps: _Steps
) -> dict[tuple[str, str], list[nodes.Resource]]:
    """Return the resources that steps hand in, by RAP and input."""
    found: dict[tuple[str, str], list[nodes.Resource]] = {}
    for owner, goal in steps:
        callee = run.library.raps.get(goal.name)
        taken = callee.inputs if callee is not None else ()
        for term, variable in zip(goal.args, taken, strict=False):
            declared = _resource(owner, term)
            if declared is not None and (goal.name, variable.name) in inputs:
                found.setdefault((goal.name, variable.name), []).append(declared)
    return found


def _two_kinds(first: Demand, other: Demand) -> Diagnostic:
    assert isinstance(other.term, nodes.Var)
    return WRONG_KIND.at(
        other.term.span,
        f"`{other.term.name}` is a {first.kind}, not a {other.kind}",
        labels=(Label(first.term.span, f"used as a {first.kind} here"),),
    )


def _check_step(
    run: Pass,
    rap: nodes.DefineRap,
    goal: nodes.Goal,
    by_input: Mapping[tuple[str, str], Demand],
) -> Iterator[Diagnostic]:
    """Yield what a step gives that the RAP does not use so."""
    callee = run.library.raps.get(goal.name)
    for term, taken in zip(goal.args, callee.inputs if callee else (), strict=False):
        demand = by_input.get((goal.name, taken.name))
        if demand is None:
            continue
        declared = _resource(rap, term)
        if declared is not None and declared.kind != demand.kind:
            yield _wrong_kind(term, declared, demand)
        elif isinstance(term, nodes.Const):
            yield _no_resource(run, demand, term)


def _wrong_kind(
    term: nodes.Term, declared: nodes.Resource, demand: Demand
) -> Diagnostic:
    name = declared.variable.name
    labels = [Label(declared.variable.span, f"a {declared.kind} is declared here")]
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
        f"{what} is no {demand.kind}",
        labels=labels,
        help=f"did you mean `{near}`?"
        if near
        else f"declare one: `(resources ({demand.kind} ?name))`",
        fix=renaming(run.library.files, name, near, [term.span]),
        about=tuple(Subject(term.span, name) for name in _mixed_up(term, demand)),
    )


def _mixed_up(term: nodes.Term, demand: Demand) -> Iterator[str]:
    """Yield what stands in place of a resource, or beside it."""
    for one in (term, demand.amount):
        if isinstance(one, nodes.Var):
            yield one.name
