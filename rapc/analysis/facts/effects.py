"""Calls, requests and effects of RAPs, and the RAPs that never end.

`Effects` holds, for each RAP, the facts that the RAP and its descendants may assert or
erase as far as declared (`:on`, `:tells`), and whether these facts are complete. The
facts are not complete in these cases:

- a primitive does not declare the effects of `okay`,
- a method enables skills or waits for signals,
- a method is empty, or a step has no RAP.

Rules over memory add to the effects of their RAP. With rules over events no effect is
certain. `Effects` also holds failures and events; `rapc.analysis.checks.results` has
the failures that the interpreter itself sets on a task.

`done` returns guaranteed effects: facts that hold, or do not hold, after a goal has
been reached. Guaranteed effects are the declared `effects` of the RAP and the facts
that its `succeed` clause queries. Without a `succeed` clause, the common effects of all
its primitives that end `okay` count.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Literal as OneOf

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.analysis.facts.logic import (
    Literal,
    apart,
    asked_by,
    fact_name,
    is_computed,
    is_known,
    is_never,
    literals,
)
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.base.graph import Reachable, components, reachable
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import input_terms, steps, substitute, variables
from rapc.library.library import Library, calls_of

# --- calls of RAPs --------------------------------------------------------------------


def reached(library: Library, names: Iterable[str]) -> dict[str, nodes.DefineRap]:
    """Return the RAPs called `names`, and all RAPs that their steps reach.

    Other RAPs are not looked at: a compiled library need not read the other RAPs.
    """
    raps = library.raps
    found = reachable(
        names, lambda name: calls_of(raps[name], raps) if name in raps else ()
    )
    return {name: raps[name] for name in found if name in raps}


def _acts(rap: nodes.DefineRap) -> bool:
    """Return whether a task of a RAP acts or waits itself, without its steps."""
    if rap.monitor_state is not None or rap.monitor_time is not None:
        return True
    if not rap.methods:
        # A problem solver may add methods, unless the RAP succeeds at once.
        return not (isinstance(rap.succeed, nodes.Truth) and rap.succeed.value)
    return any(map(acts_itself, rap.methods))


def _only_waits(rap: nodes.DefineRap) -> bool:
    """Return whether a RAP without methods waits for a state or succeeds at once.

    A problem solver may add methods to another RAP without methods.
    """
    return rap.monitor_state is not None or not _acts(rap)


def acts_itself(method: nodes.Method) -> bool:
    """Return whether a method acts or waits itself, without its steps."""
    if method.notations or method.skills or not isinstance(method.body, nodes.TaskNet):
        return True
    return any(
        isinstance(note, nodes.Window | nodes.WaitFor)
        for step in method.body.steps
        for note in step.annotations
    )


def _acting(run: Pass) -> Container[str]:
    raps = run.library.raps
    callers: dict[str, list[str]] = {}
    for rap in raps.values():
        for name in calls_of(rap, raps):
            callers.setdefault(name, []).append(rap.name)
    own = {rap.name for rap in raps.values() if _acts(rap) or run.unsure(rap.span)}
    own.update(rule.index.name for rule in run.library.memory_rules)
    own.update(name for name in callers if name not in raps)
    return set(reachable(own, lambda name: callers.get(name, ())))


ACTING = Fact(_acting)
"""The RAPs whose tasks may act or wait, also by their descendants.

Tasks of the other RAPs only succeed or fail; a step for such a RAP counts or orders.
"""


def below_agendas(library: Library) -> dict[str, nodes.DefineRap]:
    """Return the RAPs that tasks of agendas reach."""
    agendas = library.agendas.values()
    return reached(library, [one.goal.name for a in agendas for one in a.tasks])


# --- effects of requests and rules ----------------------------------------------------

Values = tuple[object, ...]
"""The arguments of a fact: constants, or None for unknown arguments."""


class Effect(msgspec.Struct, frozen=True, gc=False):
    """A fact that may be asserted or, if `gone`, erased."""

    name: str
    values: Values
    gone: bool


def request_effects(
    library: Library, request: nodes.Request
) -> tuple[list[Effect], bool]:
    """Return the possible effects of a request, and whether no effect is missing."""
    form = library.primitives.get(request.name)
    if form is None:
        return [], False
    given = {
        arg.variable.name: term.value
        for arg, term in zip(form.args, request.args, strict=False)
        if isinstance(term, nodes.Const)
    }
    whole = any(on.result == "okay" for on in form.on)
    found = [one for on in form.on for one in declared_effects(on.effects, given)]
    for name in form.tells:
        datum = library.data.get(name)
        if datum is None or datum.on is None:
            whole = False
        else:
            found += declared_effects(datum.on)
    return found, whole


def rule_effects(rules: Iterable[nodes.Rule]) -> Iterator[Effect]:
    """Yield the possible effects of rules over memory."""
    for rule in rules:
        for alternative in rule.alternatives:
            for action in alternative.actions:
                fact = action.pattern
                yield Effect(fact.name, _values(fact, {}), action.op == "mem-del")


def request_done(library: Library, request: nodes.Request) -> list[Literal]:
    """Return the guaranteed effects of a request that ends `okay`."""
    form = library.primitives.get(request.name)
    if form is None:
        return []
    given = dict(zip([a.variable.name for a in form.args], request.args, strict=False))
    okay = [on for on in form.on if on.result == "okay"]
    sure = [_literal(e) for on in okay for e in on.effects if not e.possible]
    return put_in(sure, given)


def declared_effects(
    effects: Iterable[nodes.DeclaredEffect],
    given: Mapping[str, object] = MappingProxyType({}),
) -> Iterator[Effect]:
    """Yield the possible effects that a declaration states."""
    for one in effects:
        values = _values(one.pattern, given)
        yield Effect(one.pattern.name, values, one.negated)
        if one.possible and not one.negated:
            yield Effect(one.pattern.name, values, True)


def _values(fact: nodes.Proposition, given: Mapping[str, object]) -> Values:
    return tuple(
        [
            term.value
            if isinstance(term, nodes.Const)
            else given.get(term.name)
            if isinstance(term, nodes.Var)
            else None
            for term in fact.args
        ]
    )


# --- possible effects of RAPs ---------------------------------------------------------


def is_described(library: Library) -> bool:
    """Return whether a library declares the effects of most of its primitives."""
    forms = library.primitives.values()
    told = sum(bool(form.on or form.tells) for form in forms)
    if not told and not library.memory_rules and not library.event_rules:
        return False
    silent = any(datum.on is None for datum in library.data.values())
    share, whole = THRESHOLDS.described
    return not silent and told * whole >= len(forms) * share


class _Outcome(msgspec.Struct, frozen=True, gc=False):
    """A failure or an event of a RAP; without a name, any failure or event."""

    kind: OneOf["effect", "untold", "world", "failure", "event"]
    name: str = ""


_ANY_EFFECT = _Outcome("effect")
_ANY_FAILURE = _Outcome("failure")
_ANY_EVENT = _Outcome("event")
_UNTOLD = _Outcome("untold")
"""The effects of a request that the primitive does not declare."""

_BY_WORLD = _Outcome("world")
"""The effects of the world while a step waits for a signal."""

_OPEN = (_ANY_EFFECT, _UNTOLD, _BY_WORLD)

_ANYTHING = (_ANY_EFFECT, _ANY_FAILURE, _ANY_EVENT)

_Item = Effect | _Outcome


class Effects:
    """The possible effects of the RAPs of a library, including all descendants.

    Args:
        library: the library.
        unread: the RAPs without any certain knowledge.
        broken: the RAPs with incomplete knowledge of effects.
    """

    def __init__(
        self,
        library: Library,
        unread: Container[str] = (),
        broken: Container[str] = (),
    ) -> None:
        self._library = library
        self._own: dict[str, list[_Item]] = {}
        for rap in library.raps.values():
            own = [one for method in rap.methods for one in self._of_method(method)]
            if rap.name in unread or not (rap.methods or _only_waits(rap)):
                own += _ANYTHING
            elif rap.name in broken:
                own.append(_ANY_EFFECT)
            self._own[rap.name] = own
        raps = library.raps
        calls = {rap.name: calls_of(rap, raps) for rap in raps.values()}
        for at, rule in enumerate(library.memory_rules):
            name, vertex = rule.index.name, f"rule {at}"
            rules = [one for case in rule.cases for one in case.rules]
            self._own[vertex] = list(rule_effects(rules))
            self._own.setdefault(name, [])
            calls[name] = (*calls.get(name, ()), vertex)
        self._below = Reachable(self._own, calls)
        self._changes: dict[str, frozenset[str] | None] = {}
        self._described = is_described(library)

    def of(self, name: str) -> Sequence[Effect] | None:
        """Return all possible effects of a RAP; None if some are unknown."""
        return self.known(name) if self._is_whole([name]) else None

    def known(self, name: str) -> Sequence[Effect]:
        """Return the known possible effects of a RAP, complete or not."""
        return _effects(self._below.items([name]))

    def changes(self, name: str) -> frozenset[str] | None:
        """Return the names of facts that a RAP may change; None if some are unknown.

        Rules over events do not count: the world decides when they apply. If most
        primitives declare their effects, the others have none.
        """
        if name not in self._changes:
            unknown = [_ANY_EFFECT] if self._described else [_ANY_EFFECT, _UNTOLD]
            whole = not self._may(name, *unknown)
            names = frozenset(one.name for one in self.known(name)) if whole else None
            self._changes[name] = names
        return self._changes[name]

    def is_open(self, name: str) -> bool:
        """Return whether a RAP itself, without its steps, may have unknown effects."""
        return any(one in self._own[name] for one in _OPEN)

    def of_method(self, method: nodes.Method) -> tuple[Sequence[Effect], bool]:
        """Return the known effects of a method, and whether no effect is missing."""
        own = list(self._of_method(method))
        below = [step.goal.name for step in steps(method)]
        found = dict.fromkeys(_effects([*own, *self._below.items(below)]))
        open_ = any(one in own for one in _OPEN)
        return list(found), not open_ and self._is_whole(below)

    def fails_with(self, name: str, failure: str) -> bool:
        """Return whether a task of the RAP `name` may fail with `failure`, a symbol."""
        return self._may(name, _ANY_FAILURE, _Outcome("failure", failure))

    def tells(self, name: str, event: str) -> bool:
        """Return whether skills of the RAP `name`, or below, may emit `event`."""
        return self._may(name, _ANY_EVENT, _Outcome("event", event))

    def _may(self, name: str, *outcomes: _Outcome) -> bool:
        return name not in self._own or any(
            self._below.has(name, one) for one in outcomes
        )

    def _is_whole(self, names: Iterable[str]) -> bool:
        return not self._library.event_rules and not any(
            self._may(name, *_OPEN) for name in names
        )

    def _of_method(self, method: nodes.Method) -> Iterator[_Item]:
        """Yield the effects of a method itself, without its steps."""
        library, body = self._library, method.body
        if does_nothing(method):
            yield from _ANYTHING
        for fact in method.notations:
            for gone in (False, True):
                yield Effect(fact.name, _values(fact, {}), gone)
        if isinstance(body, nodes.Primitive):
            yield from self._of_request(body.request)
        elif isinstance(body, nodes.Skills) or method.skills:
            yield _ANY_EFFECT
        yield from self._of_skills(method.skills)
        if isinstance(body, nodes.Skills):
            yield from self._of_skills(body.enable)
            yield from _of_waits(body.waits)
        for step in steps(method):
            waits = [n for n in step.annotations if isinstance(n, nodes.WaitFor)]
            if waits:
                yield _BY_WORLD
            yield from _of_waits(waits)
            if step.goal.name not in library.raps:
                yield from _ANYTHING

    def _of_request(self, request: nodes.Request) -> Iterator[_Item]:
        form = self._library.primitives.get(request.name)
        effects, whole = request_effects(self._library, request)
        yield from effects
        if not whole:
            yield _UNTOLD
        if form is None or not form.atomic:
            yield _ANY_EVENT
        if form is None:
            yield _ANY_FAILURE
        else:
            yield from (_Outcome("failure", result) for result in form.results)

    def _of_skills(self, skills: Iterable[nodes.Skill]) -> Iterator[_Outcome]:
        for skill in skills:
            form = self._library.skills.get(skill.name)
            if form is None or form.events is None:
                yield _ANY_EVENT
            else:
                yield from (_Outcome("event", event) for event in form.events)


def _effects(items: Iterable[_Item]) -> list[Effect]:
    return [one for one in items if isinstance(one, Effect)]


def _of_waits(waits: Iterable[nodes.WaitFor]) -> Iterator[_Outcome]:
    """Yield the events of waits, and the failures that the waits may cause."""
    for wait in waits:
        yield _Outcome("event", wait.signal)
        if wait.mode == "fail":
            yield _Outcome("failure", wait.signal.removeprefix(":"))


def does_nothing(method: nodes.Method) -> bool:
    """Return whether a method has no action of its own."""
    return isinstance(method.body, nodes.TaskNet) and not method.body.steps


def _run(run: Pass) -> Effects:
    raps = run.library.raps.values()
    unread = {rap.name for rap in raps if run.unsure(rap.span)}
    broken = {rap.name for rap in raps if _is_broken(rap)}
    return Effects(run.library, unread, broken)


_NAMING = nodes.For | nodes.UntilStart | nodes.UntilEnd
"""The annotations that only name a step."""


def _is_broken(rap: nodes.DefineRap) -> bool:
    """Return whether a task-net names a missing step, or calls its own RAP."""
    for method in rap.methods:
        tags = {step.tag for step in steps(method)}
        for step in steps(method):
            if step.goal.name == rap.name and step.goal.args == rap.inputs:
                return True
            for note in step.annotations:
                if isinstance(note, _NAMING) and note.tag not in tags:
                    return True
    return False


EFFECTS = Fact(_run)
"""The possible effects of each RAP, from the declarations of primitives."""


# --- RAPs that never end ------------------------------------------------------------


def endless(raps: Mapping[str, nodes.DefineRap]) -> Mapping[str, Span]:
    """Return the RAPs of `raps` that never end, each with the clause that is the cause.

    A step for another RAP counts as a step that ends. A RAP without `succeed` ends when
    a method has succeeded. Such a RAP never ends if each of its methods has a step that
    never ends, and no annotation ends that step.
    """
    found: dict[str, Span] = {}
    for rap in raps.values():
        waits = rap.monitor_state is not None or rap.monitor_time is not None
        if waits and rap.succeed and is_never(rap.succeed):
            found[rap.name] = rap.succeed.span
    if not found:
        return found
    calls = {rap.name: calls_of(rap, raps) for rap in raps.values()}
    order = [
        raps[name]
        for members in components(calls, lambda name: calls.get(name, ()))
        for name in members
        if name in raps
    ]
    grown = True
    while grown:
        grown = False
        for rap in order:
            if rap.name in found or rap.succeed is not None or not rap.methods:
                continue
            causes = [_endless_step(method, found) for method in rap.methods]
            if all(causes):
                found[rap.name] = next(cause for cause in causes if cause)
                grown = True
    return found


class NeverDone(Container[str]):
    """The RAPs that never succeed by themselves; all are computed on the first query.

    Args:
        raps: the RAPs of a library.
    """

    def __init__(self, raps: Mapping[str, nodes.DefineRap]) -> None:
        self._raps = raps

    def __contains__(self, name: object) -> bool:
        rap = self._raps.get(name) if isinstance(name, str) else None
        if rap is None:
            return False
        return is_never(rap.succeed) or name in self._endless

    @cached_property
    def _endless(self) -> Mapping[str, Span]:
        return endless(self._raps)


def _endless_step(method: nodes.Method, found: Mapping[str, Span]) -> Span | None:
    for step in steps(method):
        if step.goal.name in found and not any(map(may_end, step.annotations)):
            return found[step.goal.name]
    return None


def may_end(note: nodes.Annotation) -> bool:
    """Return whether an annotation of a step may end the step early."""
    if isinstance(note, nodes.WaitFor):
        return note.mode != "proceed"
    return isinstance(note, nodes.UntilStart | nodes.UntilEnd | nodes.Window)


# --- guaranteed effects of RAPs -------------------------------------------------------


def done(library: Library, goal: nodes.Goal) -> list[Literal]:
    """Return the guaranteed effects of a reached goal, in the terms of the caller."""
    rap = library.raps.get(goal.name)
    if rap is None:
        return []
    found = [_literal(effect) for effect in rap.effects if not effect.possible]
    found += [one for one in literals(rap.succeed) if fact_name(one)]
    if rap.succeed is None:
        found += _of_methods(library, rap)
    return put_in(found, input_terms(rap, goal))


class Guaranteed:
    """The guaranteed effects of goals, each computed once; see `done`."""

    def __init__(self, library: Library) -> None:
        self._library = library
        #: By the `id` of a goal, which is kept with its effects.
        self._made: dict[int, tuple[nodes.Goal, Sequence[Literal]]] = {}

    def of(self, goal: nodes.Goal) -> Sequence[Literal]:
        """Return the guaranteed effects of a goal in the library."""
        made = self._made.get(id(goal))
        if made is None:
            made = self._made[id(goal)] = goal, done(self._library, goal)
        return made[1]


GUARANTEED = Fact(lambda run: Guaranteed(run.library))
"""The guaranteed effects of goals."""


def _of_methods(library: Library, rap: nodes.DefineRap) -> list[Literal]:
    """Return the common effects of all methods of a RAP, if each is a primitive."""
    every: list[list[Literal]] = []
    for method in rap.methods:
        if not isinstance(method.body, nodes.Primitive):
            return []
        every.append(request_done(library, method.body.request))
    return (
        [one for one in every[0] if all(one in row for row in every)] if every else []
    )


def _literal(effect: nodes.DeclaredEffect) -> Literal:
    return Literal(effect.pattern, not effect.negated)


def put_in(found: Sequence[Literal], given: Mapping[str, nodes.Term]) -> list[Literal]:
    """Return facts with terms for variables; drop facts with other variables."""
    made = []
    for one in found:
        if all(variable.name in given for variable in variables(one.formula)):
            fact = substitute(one.formula, given)
            assert isinstance(fact, nodes.Proposition)
            if all(isinstance(arg, nodes.Var | nodes.Const) for arg in fact.args):
                made.append(Literal(fact, one.holds))
    return made


def done_by_method(library: Library, method: nodes.Method) -> list[Literal]:
    """Return the facts that surely hold after a method has succeeded.

    For a task-net, the facts are the guaranteed effects of its steps. Contradictory
    facts of two steps, and steps that may be ended early, are left out.
    """
    if isinstance(method.body, nodes.Primitive):
        return request_done(library, method.body.request)
    whole = [step for step in steps(method) if not any(map(_ends, step.annotations))]
    found = [one for step in whole for one in done(library, step.goal)]
    often: dict[str, set[bool]] = {}
    for one in found:
        often.setdefault(fact_name(one), set()).add(one.holds)
    return [one for one in found if len(often[fact_name(one)]) == 1]


def goals_of_method(library: Library, method: nodes.Method) -> Iterator[Literal]:
    """Yield what `succeed` of each step requires, in the terms of the method.

    Steps that may be ended early, and steps with several ways to succeed, are left out.
    """
    for step in steps(method):
        rap = library.raps.get(step.goal.name)
        if rap is None or any(map(_ends, step.annotations)):
            continue
        if rap.succeed is None or isinstance(rap.succeed, nodes.Or | nodes.Truth):
            continue
        inputs = {variable.name for variable in rap.inputs}
        goal = apart(rap.succeed, inputs, f"@{step.tag}")
        yield from literals(substitute(goal, input_terms(rap, step.goal)))


def _ends(note: nodes.Annotation) -> bool:
    """Return whether an annotation may end its step well before the work is done."""
    if isinstance(note, nodes.WaitFor):
        return note.mode == "succeed"
    return isinstance(note, nodes.UntilStart | nodes.UntilEnd)


def may_establish(library: Library, one: Literal, done: Sequence[Effect]) -> bool:
    """Return whether an effect may make a literal hold; True if unknown."""
    fact = one.formula
    if isinstance(fact, nodes.Believe):
        fact = fact.pattern
    if isinstance(fact, nodes.Proposition) and not _is_declared(library, fact.name):
        return True
    if not isinstance(fact, nodes.Proposition) or is_computed(library, fact.name):
        if not is_known(library, fact):
            return True
        asked = asked_by(library, fact)
        return any(effect.name in asked for effect in done)
    return any(_serves(library, effect, fact, one.holds) for effect in done)


def _serves(
    library: Library, effect: Effect, fact: nodes.Proposition, holds: bool
) -> bool:
    """Return whether an effect may make a fact hold, or keep the fact from holding."""
    if effect.name != fact.name:
        return False
    property_ = library.properties.get(fact.name)
    pairs = list(zip(effect.values, fact.args, strict=False))
    same = [
        value is None or not isinstance(term, nodes.Const) or value == term.value
        for value, term in pairs
    ]
    if property_ is None:
        return effect.gone is not holds and all(same)
    if effect.gone or len(effect.values) != len(fact.args):
        return True
    return all(same) if holds else all(same[:-1])


def _is_declared(library: Library, name: str) -> bool:
    stored = name in library.properties or name in library.propositions
    return stored or is_computed(library, name)


def things_needed(library: Library, method: nodes.Method) -> Iterator[nodes.Thing]:
    """Yield the things that a method claims before the start, without variables."""
    asked = [*method.claims]
    if isinstance(method.body, nodes.Primitive):
        form = library.primitives.get(method.body.request.name)
        asked += form.uses if form is not None else ()
    for thing in asked:
        if all(isinstance(term, nodes.Const) for term in thing.args):
            yield thing
