"""What RAPs may bring about, summed up from primitives, data, notations and rules.

The summary of a RAP holds every fact that something below it may put into memory or
take out of it, as far as declarations say so (`:on`, `:tells`), and whether that is all
there is. It is not where a primitive does not say what its `okay` does, where skills
are enabled or signals awaited, where a method is empty or a step has no RAP. Rules over
memory add to the RAPs that they are about; with rules over events nothing is certain.

Facts are told by numbers, and a summary is a set of bits: summaries are put together
along the calls, callees first, and again as long as circles of calls add to them.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence

import msgspec

from rapc.analysis.check import Fact, Pass
from rapc.base.graph import reachable_bits
from rapc.ir import nodes
from rapc.ir.walk import steps
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
