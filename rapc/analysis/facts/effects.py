"""What RAPs call, request and bring about, and which of them never end.

`Effects` holds for each RAP every fact that something below it may put into memory or
take out of it, as far as declarations say so (`:on`, `:tells`), and whether that is all
there is. It is not where a primitive does not say what its `okay` does, where skills
are enabled or signals awaited, where a method is empty or a step has no RAP. Rules over
memory add to the RAPs that they are about; with rules over events nothing is certain.

`Outcomes` sums up failures and events in the same way. A RAP whose failures cannot be
known has a method that is still to be written, asks for a primitive or a RAP that
nobody declares, or leaves its methods to a problem solver. Failures that the
interpreter itself gives a task are in `rapc.analysis.checks.unknown_result`.

`done` returns guaranteed effects: facts that hold, or do not, once a goal has been
reached. That is what its RAP declares as `effects`, asks for in `succeed` or, without
that, what all of its primitives do if they end `okay`.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence
from functools import cached_property

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.analysis.facts.logic import Literal, fact_name, literals, number_of
from rapc.base.graph import components, reachable_bits
from rapc.base.source import Span
from rapc.base.values import Number
from rapc.ir import nodes
from rapc.ir.walk import steps, substitute, variables
from rapc.library.library import Library

Values = tuple[object, ...]
"""The arguments of a fact: constants, or None where they are not known."""


class Effect(msgspec.Struct, frozen=True, gc=False):
    """A fact that may come or, if `gone`, go."""

    name: str
    values: Values
    gone: bool


class Effects:
    """The summaries of the RAPs of a library.

    Args:
        library: the library.
        unread: the RAPs of which not all is known what they do.
    """

    def __init__(self, library: Library, unread: Container[str] = ()) -> None:
        self._library = library
        self._unread = unread
        self._numbers: dict[Effect, int] = {}
        self._own: dict[str, int] = {}
        self._calls: dict[str, tuple[str, ...]] = {}
        self._open: set[str] = set()
        self._primitives = {
            name: self._of_primitive(form) for name, form in library.primitives.items()
        }
        for rap in library.raps.values():
            self._gather(rap)
        for rule in library.memory_rules:
            bits = self._of_rules(rule)
            self._own[rule.index.name] = self._own.get(rule.index.name, 0) | bits
        self._sums = reachable_bits(self._own, self._calls)
        self._unsure = reachable_bits(
            {name: int(name in self._open) for name in self._own}, self._calls
        )
        self._effects = tuple(self._numbers)

    def of(self, name: str) -> Sequence[Effect] | None:
        """Return all that a RAP may bring about; None if that is not known."""
        if self._unsure.get(name, 1) or self._library.event_rules:
            return None
        return self.known(name)

    def is_open(self, name: str) -> bool:
        """Whether a RAP may itself do more than what is known, steps aside."""
        return name in self._open

    def known(self, name: str) -> Sequence[Effect]:
        """Return what is known that a RAP may bring about, whether it is all or not."""
        return self._listed(self._sums[name])

    def _listed(self, bits: int) -> Sequence[Effect]:
        """Return the effects of a set of bits, by their numbers."""
        found = list[Effect]()
        while bits:
            low = bits & -bits
            found.append(self._effects[low.bit_length() - 1])
            bits ^= low
        return found

    def _number(self, effect: Effect) -> int:
        return 1 << self._numbers.setdefault(effect, len(self._numbers))

    def of_method(self, method: nodes.Method) -> tuple[Sequence[Effect], bool]:
        """Return what is known that a method may bring about, and whether it is all."""
        bits, is_open = self._of_method(method)
        for step in steps(method):
            bits |= self._sums.get(step.goal.name, 0)
            is_open |= bool(self._unsure.get(step.goal.name, 1))
        return self._listed(bits), not is_open and not self._library.event_rules

    def _gather(self, rap: nodes.DefineRap) -> None:
        bits, is_open = 0, not rap.methods or rap.name in self._unread
        for method in rap.methods:
            own, unknown = self._of_method(method)
            bits |= own
            is_open |= unknown
        if is_open:
            self._open.add(rap.name)
        self._own[rap.name] = bits
        self._calls[rap.name] = calls_of(rap)

    def _of_method(self, method: nodes.Method) -> tuple[int, bool]:
        """Return what a method does, its steps aside, and whether it may do more."""
        bits, is_open = 0, does_nothing(method)
        for fact in method.notations:
            bits |= self._number(Effect(fact.name, _values(fact, {}), False))
            bits |= self._number(Effect(fact.name, _values(fact, {}), True))
        if isinstance(method.body, nodes.Primitive):
            told = self._of_request(method.body.request)
            is_open |= told is None
            bits |= told or 0
        elif isinstance(method.body, nodes.Skills) or method.skills:
            is_open = True
        for step in steps(method):
            if step.goal.name not in self._library.raps or _awaits(step):
                is_open = True
        return bits, is_open

    def _of_primitive(self, form: nodes.DeclarePrimitive) -> _Told | None:
        """All that a primitive may do with any result; None if `okay` says nothing."""
        if not any(on.result == "okay" for on in form.on):
            return None
        effects = [effect for on in form.on for effect in on.effects]
        data: list[nodes.DeclaredEffect] = []
        for name in form.tells:
            datum = self._library.data.get(name)
            if datum is None or datum.on is None:
                return None
            data += datum.on
        names = [arg.variable.name for arg in form.args]
        return _Told(tuple(names), tuple(effects), tuple(data))

    def _of_request(self, request: nodes.Request) -> int | None:
        told = self._primitives.get(request.name)
        if told is None:
            return None
        given = {
            name: term.value
            for name, term in zip(told.names, request.args, strict=False)
            if isinstance(term, nodes.Const)
        }
        bits = 0
        for effects, known in ((told.effects, given), (told.data, {})):
            for one in effects:
                values = _values(one.pattern, known)
                bits |= self._number(Effect(one.pattern.name, values, one.negated))
                if one.possible and not one.negated:
                    bits |= self._number(Effect(one.pattern.name, values, True))
        return bits

    def _of_rules(self, rule: nodes.MemoryRule) -> int:
        bits = 0
        for case in rule.cases:
            for one in case.rules:
                for alternative in one.alternatives:
                    for action in alternative.actions:
                        gone = action.op == "mem-del"
                        values = _values(action.pattern, {})
                        bits |= self._number(Effect(action.pattern.name, values, gone))
        return bits


class _Told(msgspec.Struct, frozen=True):
    """What the declaration of a primitive says that it does."""

    names: tuple[str, ...]
    effects: tuple[nodes.DeclaredEffect, ...]
    #: What the data that may come with it do.
    data: tuple[nodes.DeclaredEffect, ...]


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


def does_nothing(method: nodes.Method) -> bool:
    """Whether a method leaves it to others, or to be written later."""
    return isinstance(method.body, nodes.TaskNet) and not method.body.steps


def _awaits(step: nodes.Step) -> bool:
    return any(isinstance(note, nodes.WaitFor) for note in step.annotations)


def calls_of(rap: nodes.DefineRap) -> tuple[str, ...]:
    """Return the RAPs that a RAP asks for, each once."""
    return tuple(dict.fromkeys(s.goal.name for m in rap.methods for s in steps(m)))


def _run(run: Pass) -> Effects:
    raps = run.library.raps.values()
    unread = {rap.name for rap in raps if _is_broken(rap) or run.unsure(rap.span)}
    return Effects(run.library, unread)


_NAMING = nodes.For | nodes.UntilStart | nodes.UntilEnd
"""The annotations that name a step and nothing else."""


def _is_broken(rap: nodes.DefineRap) -> bool:
    """Whether a task-net of a RAP lacks a step that it names, or has the RAP itself."""
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
"""Sums up what each RAP may bring about, from what is declared of primitives."""


_ANY_FAILURE = 1
"""The bit of what may fail with anything."""

_ANY_EVENT = 2
"""The bit of what may tell any event."""


class Outcomes:
    """The failures and events of the RAPs of a library.

    Args:
        library: the library.
        unread: the RAPs of which not all is known what they do.
    """

    def __init__(self, library: Library, unread: Container[str] = ()) -> None:
        self._library = library
        self._bits: dict[str, int] = {}
        own = {
            rap.name: self._of(rap, rap.name in unread) for rap in library.raps.values()
        }
        calls = {
            rap.name: tuple(
                step.goal.name for method in rap.methods for step in steps(method)
            )
            for rap in library.raps.values()
        }
        self._sums = reachable_bits(own, calls)

    def fails_with(self, name: str, failure: str) -> bool:
        """Whether a task of the RAP `name` may fail with `failure`, a symbol."""
        return self._has(name, _ANY_FAILURE, failure)

    def tells(self, name: str, event: str) -> bool:
        """Whether skills of the RAP `name`, or below it, may tell `event`."""
        return self._has(name, _ANY_EVENT, event)

    def _has(self, name: str, anything: int, told: str) -> bool:
        bits = self._sums.get(name, anything)
        return bool(bits & (anything | self._bits.get(told, 0)))

    def _of(self, rap: nodes.DefineRap, unread: bool) -> int:
        """Return what a RAP does by itself, its steps aside."""
        found = _ANY_FAILURE | _ANY_EVENT if unread or not rap.methods else 0
        for method in rap.methods:
            if does_nothing(method):
                found |= _ANY_FAILURE | _ANY_EVENT
            found |= self._of_skills(method.skills)
            if isinstance(method.body, nodes.Primitive):
                found |= self._of_primitive(method.body.request.name)
            elif isinstance(method.body, nodes.Skills):
                found |= self._of_skills(method.body.enable)
                found |= self._of_waits(method.body.waits)
            for step in steps(method):
                notes = step.annotations
                waits = [note for note in notes if isinstance(note, nodes.WaitFor)]
                found |= self._of_waits(waits)
                if step.goal.name not in self._library.raps:
                    found |= _ANY_FAILURE | _ANY_EVENT
        return found

    def _of_primitive(self, name: str) -> int:
        form = self._library.primitives.get(name)
        if form is None:
            return _ANY_FAILURE | _ANY_EVENT
        found = 0 if form.atomic else _ANY_EVENT
        for result in form.results:
            found |= self._bit(result)
        return found

    def _of_skills(self, skills: Iterable[nodes.Skill]) -> int:
        found = 0
        for skill in skills:
            form = self._library.skills.get(skill.name)
            if form is None or form.events is None:
                found |= _ANY_EVENT
            else:
                for event in form.events:
                    found |= self._bit(event)
        return found

    def _of_waits(self, waits: Iterable[nodes.WaitFor]) -> int:
        """Return the bits of events that are awaited, and of failures by them."""
        found = 0
        for wait in waits:
            found |= self._bit(wait.signal)
            if wait.mode == "fail":
                found |= self._bit(wait.signal.removeprefix(":"))
        return found

    def _bit(self, name: str) -> int:
        """Return the bit of a failure, or of an event by its name with the colon."""
        return self._bits.setdefault(name, 4 << len(self._bits))


def is_never(formula: nodes.Formula) -> bool:
    """Whether a formula says itself that it never holds: `nil`, `(not true)`."""
    if isinstance(formula, nodes.Not):
        return isinstance(formula.part, nodes.Truth) and formula.part.value
    return isinstance(formula, nodes.Truth) and not formula.value


def endless(raps: Mapping[str, nodes.DefineRap]) -> Mapping[str, Span]:
    """Return those of `raps` that stand by for good, each with the clause that says so.

    Steps for other RAPs count as done some time. A RAP without `succeed` is done when a
    method has ended well: never, if each of its methods has a step that is never done
    and that nothing ends.
    """
    found: dict[str, Span] = {}
    for rap in raps.values():
        waits = rap.monitor_state is not None or rap.monitor_time is not None
        if waits and rap.succeed is not None and is_never(rap.succeed):
            found[rap.name] = rap.succeed.span
    if not found:
        return found
    calls = {rap.name: calls_of(rap) for rap in raps.values()}
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
    """The RAPs that never end well by themselves; all are looked at when one is asked.

    Args:
        raps: the RAPs of a library.
    """

    def __init__(self, raps: Mapping[str, nodes.DefineRap]) -> None:
        self._raps = raps

    def __contains__(self, name: object) -> bool:
        rap = self._raps.get(name) if isinstance(name, str) else None
        if rap is None:
            return False
        goal = rap.succeed
        return (goal is not None and is_never(goal)) or name in self._endless

    @cached_property
    def _endless(self) -> Mapping[str, Span]:
        return endless(self._raps)


def reached(library: Library, names: Iterable[str]) -> dict[str, nodes.DefineRap]:
    """Return the RAPs called `names` and all that their steps lead to.

    Others are not looked at: a compiled library need not read them.
    """
    found: dict[str, nodes.DefineRap] = {}
    stack = list(names)
    while stack:
        name = stack.pop()
        if name not in found and name in library.raps:
            found[name] = library.raps[name]
            stack.extend(calls_of(found[name]))
    return found


def below_agendas(library: Library) -> dict[str, nodes.DefineRap]:
    """Return the RAPs that tasks of agendas lead to."""
    agendas = library.agendas.values()
    return reached(library, [one.goal.name for a in agendas for one in a.tasks])


def _endless_step(method: nodes.Method, found: Mapping[str, Span]) -> Span | None:
    for step in steps(method):
        if step.goal.name in found and not any(map(may_end, step.annotations)):
            return found[step.goal.name]
    return None


def may_end(note: nodes.Annotation) -> bool:
    """Whether an annotation of a step may end it before it is done."""
    if isinstance(note, nodes.WaitFor):
        return note.mode != "proceed"
    return isinstance(note, nodes.UntilStart | nodes.UntilEnd | nodes.Window)


class Pause(msgspec.Struct, frozen=True, gc=False):
    """How long a standing RAP surely waits between two rounds, and what says so."""

    every: Number
    start: int
    end: int


class Asking(msgspec.Struct, frozen=True, gc=False):
    """What a RAP asks for by itself, each once."""

    rap: str
    #: The RAPs that its steps ask for.
    calls: tuple[str, ...]
    #: The primitives that its methods request.
    requests: tuple[str, ...]
    #: The names of the facts that its methods note.
    notes: tuple[str, ...]
    pause: Pause | None


def asking(rap: nodes.DefineRap) -> Asking:
    """Return what a RAP asks for by itself."""
    calls: dict[str, None] = {}
    requests: dict[str, None] = {}
    notes: dict[str, None] = {}
    for method in rap.methods:
        if isinstance(method.body, nodes.Primitive):
            requests[method.body.request.name] = None
        for step in steps(method):
            calls[step.goal.name] = None
        for note in method.notations:
            notes[note.name] = None
    return Asking(rap.name, tuple(calls), tuple(requests), tuple(notes), _pause(rap))


def _pause(rap: nodes.DefineRap) -> Pause | None:
    if rap.succeed is None or not is_never(rap.succeed):
        return None
    timed = rap.monitor_time
    if timed is not None and timed.reference == "now":
        start = number_of(timed.start)
        if start is not None and start > 0:
            return Pause(start, timed.span.start, timed.span.end)
    for one in literals(rap.monitor_state):
        if isinstance(one.formula, nodes.Believe) and not one.holds:
            age = number_of(one.formula.age)
            if age is not None and age > 0:
                return Pause(age, one.span.start, one.span.end)
    return None


def done(library: Library, goal: nodes.Goal) -> list[Literal]:
    """Return what surely comes of a goal that is reached, in the caller's terms."""
    rap = library.raps.get(goal.name)
    if rap is None:
        return []
    found = [_effect(effect) for effect in rap.effects]
    found += [one for one in literals(rap.succeed) if fact_name(one)]
    if rap.succeed is None:
        found += _of_methods(library, rap)
    return put_in(
        found, {v.name: t for v, t in zip(rap.inputs, goal.args, strict=False)}
    )


def _of_methods(library: Library, rap: nodes.DefineRap) -> list[Literal]:
    """Return what every method of a RAP brings about, if each is a primitive."""
    every: list[list[Literal]] = []
    for method in rap.methods:
        if not isinstance(method.body, nodes.Primitive):
            return []
        every.append(_of_request(library, method.body.request))
    return (
        [one for one in every[0] if all(one in row for row in every)] if every else []
    )


def _of_request(library: Library, request: nodes.Request) -> list[Literal]:
    """Return what a request surely does if it ends `okay`."""
    form = library.primitives.get(request.name)
    if form is None:
        return []
    given = dict(zip([a.variable.name for a in form.args], request.args, strict=False))
    okay = [on for on in form.on if on.result == "okay"]
    sure = [_effect(e) for on in okay for e in on.effects if not e.possible]
    return put_in(sure, given)


def _effect(effect: nodes.DeclaredEffect) -> Literal:
    return Literal(effect.pattern, not effect.negated)


def put_in(found: Sequence[Literal], given: Mapping[str, nodes.Term]) -> list[Literal]:
    """Return facts with terms for their variables, without those that keep some."""
    made = []
    for one in found:
        if all(variable.name in given for variable in variables(one.formula)):
            fact = substitute(one.formula, given)
            assert isinstance(fact, nodes.Proposition)
            if all(isinstance(arg, nodes.Var | nodes.Const) for arg in fact.args):
                made.append(Literal(fact, one.holds))
    return made


def done_by_method(library: Library, method: nodes.Method) -> list[Literal]:
    """Return what surely holds when a method has ended well.

    Of a task-net that is what its steps bring about, without facts of which more than
    one step has something to say, and without steps that may be ended before.
    """
    if isinstance(method.body, nodes.Primitive):
        return _of_request(library, method.body.request)
    whole = [step for step in steps(method) if not any(map(_ends, step.annotations))]
    found = [one for step in whole for one in done(library, step.goal)]
    often: dict[str, set[bool]] = {}
    for one in found:
        often.setdefault(fact_name(one), set()).add(one.holds)
    return [one for one in found if len(often[fact_name(one)]) == 1]


def _ends(note: nodes.Annotation) -> bool:
    """Whether an annotation may end its step well before its work is done."""
    if isinstance(note, nodes.WaitFor):
        return note.mode == "succeed"
    return isinstance(note, nodes.UntilStart | nodes.UntilEnd)
