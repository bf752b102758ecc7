"""Variables without a value in some order of the steps.

Every clause is walked with the variables that are bound at the clause [L 3.64]
to [L 3.68]:

- everywhere: inputs and resources;
- in a method: also the variables that `repeat-while` and its context surely bind;
- in a step: also the bindings of the steps ordered before, the bindings of the `for`
  formulas that point at the step or at these steps, and the signals that the steps
  wait for.

A step that an `until` may end early surely passes on no bindings, not even the bindings
of the steps before, because those steps may still run. A step that a signal may end
passes on the common bindings of all possible ends: its own work, if the work can end
the step, and each such signal. `rapc.analysis.facts.bindings` determines the variables
that a formula binds; the checks of `unbound-variable`, `anonymous-variable` and
`age-in-monitor` report the findings.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping
from typing import NamedTuple

import msgspec

from rapc.analysis.check import Fact, Pass, RapFact
from rapc.analysis.facts.bindings import (
    BindingWalker,
    Bound,
    Findings,
    names_of,
    query_arguments,
    rules_over_memory,
)
from rapc.analysis.facts.effects import NeverDone
from rapc.analysis.facts.task_nets import TASK_NETS, Net, Nets
from rapc.ir import clauses, nodes


class Missing(msgspec.Struct, frozen=True):
    """A variable that needs a value and is not surely bound.

    `clause` is the name of the clause; `step` is the position of the step.
    """

    variable: nodes.Var
    clause: str
    method: nodes.Method | None = None
    step: int | None = None


class Bindings(msgspec.Struct, frozen=True):
    """The variables without a value in all clauses of a library.

    `missing` is by the `id` of the RAP, rule or test; `anonymous` are bare `?` where a
    value is needed; `ages` are the `believe` forms of monitors that bind an age.
    """

    missing: Mapping[int, tuple[Missing, ...]]
    anonymous: tuple[nodes.Var, ...]
    ages: tuple[nodes.Believe, ...]


def _run(run: Pass) -> Bindings:
    walk = run.result(_WALK)
    missing: dict[int, tuple[Missing, ...]] = {}
    anonymous: list[nodes.Var] = []
    ages: list[nodes.Believe] = []
    for form in run.library.forms:
        if type(form) is nodes.DefineRap:
            found = run.of(_OF_RAP, form)
        else:
            _form(walk, form)
            found = walk.taken()
        if found.missing:
            missing[id(form)] = found.missing
        anonymous.extend(found.anonymous)
        ages.extend(found.ages)
    for test in run.library.tests:
        _test(walk, test)
        found = walk.taken()
        if found.missing:
            missing[id(test)] = found.missing
        anonymous.extend(found.anonymous)
    return Bindings(missing, tuple(anonymous), tuple(ages))


BINDINGS = Fact(_run)
"""The variables without a value, for any order that a task-net allows."""


class _Found(NamedTuple):
    """The faults of a form; see `Bindings`."""

    missing: tuple[Missing, ...]
    anonymous: tuple[nodes.Var, ...]
    ages: tuple[nodes.Believe, ...]


def _of_rap(run: Pass, rap: nodes.DefineRap) -> _Found:
    walk = run.result(_WALK)
    _rap(walk, rap)
    return walk.taken()


_OF_RAP = RapFact(_of_rap)


def _form(walk: _Walk, form: nodes.TopForm) -> None:
    """Walk a form that is no RAP."""
    if isinstance(form, nodes.MemoryRule | nodes.EventRule):
        for rules, names in rules_over_memory(form):
            _rules(walk, rules, Bound(None, names))
    elif type(form) is nodes.DefineQuery:
        walk.walker.formula(form.formula, Bound(None, query_arguments(form)))
        walk.note("query")
    elif isinstance(form, nodes.DeclarePrimitive | nodes.DeclareSkill):
        own = Bound(None, (arg.variable.name for arg in form.args))
        walk.values(_arguments(form.uses), own, ":uses")


class _Walk:
    """The walk through the RAPs and rules, with the faults of the current form.

    `missing` has the variables without a value, `ages` the ages that monitors bind.
    """

    def __init__(
        self, walker: BindingWalker, nets: Nets, never_done: Container[str]
    ) -> None:
        self.walker = walker
        self.nets = nets
        self.never_done = never_done
        self.missing: list[Missing] = []
        self.ages: list[nodes.Believe] = []

    def taken(self) -> _Found:
        """Return the faults of the current form, and forget them."""
        anonymous = self.walker.findings.anonymous
        found = _Found(tuple(self.missing), tuple(anonymous), tuple(self.ages))
        for faults in (self.missing, anonymous, self.ages):
            faults.clear()
        return found

    def note(
        self, clause: str, method: nodes.Method | None = None, step: int | None = None
    ) -> None:
        """Assign the faults since the last call to a clause."""
        found = self.walker.findings.unbound
        if not found:
            return
        self.missing.extend(Missing(v, clause, method, step) for v in found)
        found.clear()

    def values(
        self,
        terms: Iterable[nodes.Term],
        bound: Bound,
        clause: str,
        method: nodes.Method | None = None,
    ) -> None:
        """Walk the terms of a clause that need values."""
        self.walker.values(terms, bound)
        self.note(clause, method)


def _walk(run: Pass) -> _Walk:
    library = run.library
    walker = BindingWalker(library.functions, library.queries, Findings())
    return _Walk(walker, run.result(TASK_NETS), NeverDone(library.raps))


_WALK = Fact(_walk)


# --- a RAP -------------------------------------------------------------------------


def _rap(walk: _Walk, rap: nodes.DefineRap) -> None:
    walker = walk.walker
    base = Bound(None, (v.name for v in rap.inputs))
    for resource in rap.resources:
        if resource.initial is not None:
            walk.values((resource.initial,), base, "resources")
        base.names.add(resource.variable.name)
    if rap.monitor_time is not None:
        times = (rap.monitor_time.start, rap.monitor_time.stop)
        walk.values(times, base, "monitor-time")
    handed, asked = Bound(base), Bound(base)
    for clause, formula in clauses.held(clauses.RAP, rap):
        walker.findings.ages.clear()
        own = asked if clause.word == "preconditions" else Bound(base)
        walker.formula(formula, handed if clause.hands_on else own)
        walk.note(clause.word)
        if clause.when == "wake":
            walk.ages.extend(walker.findings.ages)
    if rap.duration is not None:
        walk.values((rap.duration,), asked, "duration")
    known = Bound(asked, (v.name for v in rap.outputs))
    for arg in _arguments(effect.pattern for effect in rap.effects):
        if not isinstance(arg, nodes.Var) or not arg.anonymous:
            walk.values((arg,), known, "effects")
    for method in rap.methods:
        _method(walk, method, Bound(handed))


def _arguments(patterns: Iterable[nodes.Pattern]) -> Iterator[nodes.Term]:
    return (arg for pattern in patterns for arg in pattern.args)


def _method(walk: _Walk, method: nodes.Method, bound: Bound) -> None:
    for clause, formula in clauses.held(clauses.METHOD, method):
        walk.walker.formula(formula, bound if clause.hands_on else Bound(bound))
        walk.note(clause.word, method)
    walk.values(_arguments(method.notations), bound, "notations", method)
    walk.values(_arguments(method.claims), bound, "claims", method)
    walk.values(_arguments(method.skills), bound, "skills", method)
    body = method.body
    if type(body) is nodes.TaskNet:
        _task_net(walk, method, body, bound)
    elif type(body) is nodes.Primitive:
        walk.values(body.request.args, bound, "primitive", method)
    elif type(body) is nodes.Skills:
        _skills(walk, method, body, bound)


def _skills(
    walk: _Walk, method: nodes.Method, body: nodes.Skills, bound: Bound
) -> None:
    walk.walker.values(_arguments(body.enable), bound)
    awaited = [names_of(wait.args) for wait in body.waits]
    if awaited:
        bound.names.update(set.intersection(*awaited))
    walk.values(_arguments(body.disable), bound, "primitive", method)


# --- a task-net ----------------------------------------------------------------------


def _task_net(
    walk: _Walk, method: nodes.Method, body: nodes.TaskNet, base: Bound
) -> None:
    net = walk.nets[id(body)]
    if net.order is None:
        _cyclic_net(walk, method, body, base)
        return
    handed = _OrderedBindings(base, net)
    for at in net.order:
        before = handed.before(at)
        bound = Bound(before)
        _step(walk, body.steps[at], bound, net, at)
        walk.note("step", method, at)
        if at in net.by_until:
            continue
        sure = bound.names
        if at in net.early:
            sure = _sure_at_the_end(walk, body.steps[at], bound.names)
        handed.after(at, before, sure)


def _cyclic_net(
    walk: _Walk, method: nodes.Method, body: nodes.TaskNet, base: Bound
) -> None:
    """Walk steps in a cycle: each step may use the bindings of all steps."""
    net = walk.nets[id(body)]
    everything = Bound(base)
    quiet = _Walk(walk.walker.apart(), walk.nets, walk.never_done)
    for at, step in enumerate(body.steps):
        _step(quiet, step, everything, net, at)
    for at, step in enumerate(body.steps):
        _step(walk, step, Bound(everything), net, at)
        walk.note("step", method, at)


def _step(walk: _Walk, step: nodes.Step, bound: Bound, net: Net, at: int) -> None:
    """Walk all clauses of a step, and add the sure bindings to `bound`."""
    for note in step.annotations:
        if type(note) is nodes.Window:
            walk.walker.values((note.start, note.stop), bound)
    if net.edges[at]:
        _formulas(walk, net, at, bound)
    if step.annotations:
        bound.names.update(_signals(step))
    walk.walker.values(step.goal.args, bound)
    if step.goal.outputs:
        walk.walker.match(step.goal.outputs, bound)
    for note in step.annotations:
        if type(note) is nodes.ResourceChange:
            walk.walker.values((note.resource, note.amount), bound)


def _formulas(walk: _Walk, net: Net, at: int, bound: Bound) -> None:
    """Walk the `for` formulas that point at a step, and add the sure bindings."""
    for edge in net.edges[at]:
        annotation = edge.annotation
        if type(annotation) is nodes.For and annotation.formula is not None:
            scope = Bound(bound)
            walk.walker.formula(annotation.formula, scope)
            if edge.before not in net.by_until:
                bound.names |= scope.names


def _signals(step: nodes.Step) -> set[str]:
    """Return the variables of the signals that a step waits for before the start."""
    names: set[str] = set()
    for annotation in step.annotations:
        if type(annotation) is nodes.WaitFor and annotation.mode == "proceed":
            names |= names_of(annotation.args)
    return names


def _sure_at_the_end(walk: _Walk, step: nodes.Step, bound: set[str]) -> set[str]:
    """Return the variables with values at each possible end of a step."""
    ways = [
        names_of(note.args)
        for note in step.annotations
        if isinstance(note, nodes.WaitFor) and note.mode == "succeed"
    ]
    if step.goal.name not in walk.never_done:
        ways.append(bound)
    return set.intersection(*ways)


class _OrderedBindings:
    """The bindings that steps pass to the steps ordered after, as bit sets.

    With sets of names, a long chain of steps would need quadratic time and memory. A
    bit set is dropped after every direct successor has been processed.
    """

    def __init__(self, base: Bound, net: Net) -> None:
        self._base = base
        self._edges = net.edges
        self._bits: dict[str, int] = {}
        self._sets: dict[int, int] = {}
        self._left = [0] * len(net.edges)
        for into in net.edges:
            for before in {edge.before for edge in into} if into else ():
                self._left[before] += 1

    def before(self, at: int) -> _Names:
        """Return the names surely bound by the steps ordered before a step."""
        here, into = 0, self._edges[at]
        for before in {edge.before for edge in into} if into else ():
            here |= self._sets.get(before, 0)
            self._left[before] -= 1
            if not self._left[before]:
                self._sets.pop(before, None)
        return _Names(self._base, self._bits, here)

    def after(self, at: int, before: _Names, sure: Iterable[str]) -> None:
        """Record the sure bindings at the end of the step just processed."""
        if self._left[at]:
            here = before.set
            for name in sure:
                here |= 1 << self._bits.setdefault(name, len(self._bits))
            self._sets[at] = here


class _Names(Container[str]):
    """The names of some bits, and all names of a base."""

    def __init__(self, base: Bound, bits: Mapping[str, int], chosen: int) -> None:
        self._base = base
        self._bits = bits
        self.set = chosen

    def __contains__(self, name: object) -> bool:
        bit = self._bits.get(name) if isinstance(name, str) else None
        return (bit is not None and self.set >> bit & 1 == 1) or name in self._base


# --- rules over memory --------------------------------------------------------------


def _rules(walk: _Walk, rules: Iterable[nodes.Rule], bound: Bound) -> None:
    for rule in rules:
        for alternative in rule.alternatives:
            scope = Bound(bound)
            walk.walker.formula(alternative.query, scope)
            patterns = (action.pattern for action in alternative.actions)
            walk.values(_arguments(patterns), scope, "rule")


# --- tests ---------------------------------------------------------------------------


def _test(walk: _Walk, test: nodes.DefineTest) -> None:
    """Walk a test: bind a row's request for its effects, and a formula for itself."""
    for row in test.script:
        bound = Bound(None, names_of(row.request.args))
        told = (*row.asserts, *row.erases, *row.data, *row.signals)
        walk.walker.values(_arguments(told), bound)
        for moved in row.moves:
            walk.walker.values((moved.item, moved.place), bound)
        walk.values(row.loses, bound, "script")
    later = [action for at in test.ats for action in at.actions]
    inner = [one.expectations for one in later if isinstance(one, nodes.Expect)]
    for expectations in (*inner, test.expectations):
        for one in expectations:
            if isinstance(one, nodes.MemoryHolds):
                walk.walker.formula(one.formula, Bound(None))
                walk.note("memory")
