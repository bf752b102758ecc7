"""RAP064 to RAP066: sets, counters and plain values taken for each other (T 4.8).

A RAP knows the kinds of the resources that it declares. What an input is, only the
caller knows: how the RAP itself uses the input is held against what its steps are
given elsewhere.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from typing import Literal

import msgspec

from rapc.analysis.check import Fact, Pass, Reported, check
from rapc.analysis.checks.bindings import BINDINGS
from rapc.analysis.facts.index import INDEX, Form, Index, Occurrence
from rapc.analysis.renaming import renaming
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
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


class Mistaken(msgspec.Struct, frozen=True):
    """The resources that are mixed up, each by the id of its RAP and its name."""

    #: Those that are taken for something else.
    wrong: set[tuple[int, str]]
    #: Those that may be meant where something else stands.
    meant: set[tuple[int, str]]


def _run(run: Pass) -> Reported[Mistaken]:
    """Return the findings, and the resources that are mixed up."""
    found: list[Diagnostic] = []
    index = run.result(INDEX)
    missing = run.result(BINDINGS).missing
    unbound = {(rap, m.variable.name) for rap, all_ in missing.items() for m in all_}
    by_input: dict[tuple[str, str], list[Demand]] = {}
    wrong: set[tuple[int, str]] = set()
    meant: set[tuple[int, str]] = set()
    for demand in _demands(index):
        rap, term = demand.rap, demand.term
        if isinstance(term, nodes.Var) and (
            term.anonymous or (id(rap), term.name) in unbound
        ):
            continue
        declared = _resource(rap, term)
        if declared is not None:
            if declared.kind != demand.kind:
                found.append(_wrong_kind(term, declared, demand))
                wrong.add((id(rap), declared.variable.name))
        elif isinstance(term, nodes.Var) and _is_input(rap, term):
            by_input.setdefault((rap.name, term.name), []).append(demand)
        else:
            found.append(_no_resource(run, demand))
            meant |= _meant(rap, demand)
    steps = [
        (goal.owner, goal.node)
        for goal in index.of(nodes.Goal)
        if isinstance(goal.owner, nodes.DefineRap)
    ]
    wanted: dict[tuple[str, str], Demand] = {}
    if by_input:
        wanted, mixed = _settled(run, by_input, steps)
        found += mixed
    for owner, goal in steps if wanted else ():
        for one, taken_for in _check_step(run, owner, goal, wanted):
            found.append(one)
            meant |= _meant(owner, taken_for)
    return Reported(found, Mistaken(wrong | _in_place_of(index), meant))


RESOURCES = Fact(_run)


@check(WRONG_KIND, NOT_A_RESOURCE, needs_whole="method")
def resources(run: Pass) -> Iterable[Diagnostic]:
    """Find sets used as counters, counters as sets, and plain values as either."""
    return run.result(RESOURCES).findings


def _meant(rap: nodes.DefineRap, demand: Demand) -> set[tuple[int, str]]:
    """Return the resources of a RAP that may be meant where none of the kind stands."""
    own = [one for one in rap.resources if one.kind == demand.kind]
    return {(id(rap), one.variable.name) for one in own}


def _demands(index: Index) -> Iterator[Demand]:
    for term, kind, owner in _places(index):
        if isinstance(owner, nodes.DefineRap):
            yield Demand(term, kind, owner)


def _places(
    index: Index,
) -> Iterator[tuple[nodes.Term, Kind, Form]]:
    """Every term that has to be a resource, with the kind it has to be."""
    for test in index.of(nodes.SetTest):
        yield test.node.args[0], "set", test.owner
    for call in index.of(nodes.Call):
        # A call whose argument could not be read has none; the reader has said so.
        if call.node.function in ("size-of", "value") and call.node.args:
            kind: Kind = "set" if call.node.function == "size-of" else "counter"
            yield call.node.args[0], kind, call.owner
    for effect in index.of(nodes.ResourceChange):
        kind = "set" if effect.node.op in ("set-add", "set-sub") else "counter"
        yield effect.node.resource, kind, effect.owner
    for resource in index.of(nodes.Resource):
        first = resource.node.initial
        if first is not None and not _may_be_number(resource, first):
            yield first, resource.node.kind, resource.owner


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


_CHANGE = nodes.ResourceChange


def _in_place_of(index: Index) -> set[tuple[int, str]]:
    """The resources that stand as an amount beside what is no resource."""
    found = set()
    pairs = [
        *((u.owner, u.node.amount, u.node.resource) for u in index.of(_CHANGE)),
        *((u.owner, u.node.args[-1], u.node.args[0]) for u in index.of(nodes.SetTest)),
    ]
    for rap, amount, term in pairs:
        if not isinstance(rap, nodes.DefineRap):
            continue
        known = _resource(rap, term) is not None
        if isinstance(term, nodes.Var):
            known = known or _is_input(rap, term)
        if not known and isinstance(amount, nodes.Var):
            found.add((id(rap), amount.name))
    return found


def _check_step(
    run: Pass,
    rap: nodes.DefineRap,
    goal: nodes.Goal,
    by_input: Mapping[tuple[str, str], Demand],
) -> Iterator[tuple[Diagnostic, Demand]]:
    """Yield the demands of a RAP that a step gives something else for."""
    callee = run.library.raps.get(goal.name)
    for term, taken in zip(goal.args, callee.inputs if callee else (), strict=False):
        demand = by_input.get((goal.name, taken.name))
        if demand is None:
            continue
        declared = _resource(rap, term)
        if declared is not None and declared.kind != demand.kind:
            yield _wrong_kind(term, declared, demand), demand
        elif isinstance(term, nodes.Const):
            yield _no_resource(run, demand, term), demand


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
    )
