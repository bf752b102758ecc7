"""Checks of handlers against their declared effects: the setting `rapc.strict`.

`:on` declares the changes of memory by the handler of a result, or of a datum [L 1]. In
strict mode a handler gets a memory that records its changes. After the handler has run,
its declared effects must hold, and its changes must be declared. Otherwise the run
ends, because planner and checker rely on the declarations. The changes that memory
makes at the end of the batch (merging, counting, expiry) need no declaration, nor do
removals by an exclusion.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import msgspec

from rapc.base.code_places import place_of
from rapc.base.values import Atom, Fact, format_list, match_pattern
from rapc.errors import PortError
from rapc.ir import nodes
from rapc.runtime.changes import changing
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.run import Run
from rapc.world import Change, DatumHandler, Handlers, ResultHandler, Time

Question = Callable[[nodes.Formula, Sequence[str]], Callable[..., bool]]
"""A function that compiles a formula with given variables into a test."""


class _Change(msgspec.Struct, frozen=True):
    """A fact that a handler has asserted or erased, with the line of the handler."""

    fact: Fact
    place: str


class NotingMemory:
    """The memory of a handler in strict mode, which records the handler's changes.

    It implements `rapc.world.HandlerMemory` and reads the memory of the run.
    """

    def __init__(self, run: Run) -> None:
        self._access: MemoryAccess = run.access
        self._memory = run.beliefs
        #: The asserted facts, and the erased facts that memory contained, in order.
        self.made: list[_Change] = []
        self.taken: list[_Change] = []

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of `MemoryAccess`, for methods that only read."""
        return getattr(self._access, name)

    @property
    def now(self) -> Time:
        """Return the time of the clock."""
        return self._access.now

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact now, and record the change."""
        self._access.assert_fact(*fact)
        self._note(self._memory.checked(fact))

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts with `prefix`, and record each."""
        place = _place_of_caller()
        known = self._memory.signatures.relations
        there = []
        if prefix and prefix[0] in known:
            there = self._memory.facts.starting(self._memory.canonical(prefix))
        self._access.erase(*prefix)
        self.taken += [_Change(fact, place) for fact in there]

    def introduce(self, sensor_name: str, kind: str, place: Atom) -> str:
        """Introduce an item, and record its class and place."""
        name = self._access.introduce(sensor_name, kind, place)
        self._note(("class", name, kind, "true"))
        self._note_place(name)
        return name

    def move(self, item: str, place: Atom) -> None:
        """Move an item, and record its place."""
        self._access.move(item, place)
        self._note_place(item)

    def lose(self, item: str) -> None:
        """Lose an item, and record its place."""
        self._access.lose(item)
        self._note_place(item)

    def _note_place(self, item: str) -> None:
        name = self._memory.items.canonical(item)
        place = self._access.value("location", name)
        if place is not None:
            self._note(("location", name, place), 3)

    def _note(self, fact: Fact, depth: int = 2) -> None:
        self.made.append(_Change(fact, _place_of_caller(depth)))


def _place_of_caller(depth: int = 1) -> str:
    """Return the line of the handler, `depth` calls above the caller, as text."""
    frame = sys._getframe(depth + 1)
    if frame.f_globals.get("__name__") == changing.__module__:
        return "without Python code"
    return f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}"


class _Told(msgspec.Struct, frozen=True):
    """The declaration of a primitive or a datum, for the checks of its handlers."""

    form: nodes.DeclarePrimitive | nodes.DeclareDatum
    #: The name of the handler in messages: `the handler of `look``.
    whose: str

    def effects(self, result: str) -> Sequence[nodes.DeclaredEffect] | None:
        """Return the declared effects of `result`; None without a declaration."""
        if isinstance(self.form, nodes.DeclareDatum):
            return self.form.on
        told = {one.result: one.effects for one in self.form.on}
        return told.get(result)


class _Held:
    """The checks of the handlers of one run.

    Args:
        run: the run with the handlers.
        question: compiles declared effects into tests.
    """

    def __init__(self, run: Run, question: Question) -> None:
        self._run = run
        self._question = question
        self._questions: dict[int, Callable[..., bool]] = {}

    def result(
        self,
        told: _Told,
        handler: ResultHandler | None,
        _: object,
        request: Fact,
        result: str,
    ) -> str | None:
        """Run the handler of a result, then check its changes and effects.

        Raises:
            PortError: for a violation, or for an undeclared result of the handler.
        """
        noting = NotingMemory(self._run)
        other = None
        if handler is not None:
            other = handler(noting, request, result)
        if handler is not None and other is not None:
            result = other = self._run.port.result_told(request, other, handler)
        self._hold(told, handler, noting, request, result)
        return other

    def datum(self, told: _Told, handler: DatumHandler, _: object, datum: Fact) -> None:
        """Run the handler of a datum, then check its changes and effects.

        Raises:
            PortError: for a violation.
        """
        noting = NotingMemory(self._run)
        handler(noting, datum)
        self._hold(told, handler, noting, datum, "")

    def _hold(
        self, told: _Told, handler: object, noting: NotingMemory, of: Fact, result: str
    ) -> None:
        """Check that a handler made only declared changes, with all declared effects.

        The effects of a result must hold after the data of the result have been
        handled.
        """
        effects = told.effects(result)
        if effects is None:
            return
        names = [arg.variable.name for arg in told.form.args]
        given = dict(zip(names, map(self._named, of[1:]), strict=True))
        patterns = [(effect, self._filled(effect, given)) for effect in effects]
        after = f" after {format_list(of)}" + (f" - {result}" if result else "")
        for said, place in self._surplus(noting, patterns):
            raise self._breach(told, f"{told.whose} ({place}){after} {said}")

        def look() -> None:
            for said in self._missing(patterns, given):
                whose = f"{told.whose}{place_of(handler)}"
                raise self._breach(told, f"{whose}{after} {said}")

        if result:
            self._run.access.closing.append(look)
        else:
            look()

    def _breach(self, told: _Told, said: str) -> PortError:
        """Return the error for a handler that violates its declaration."""
        source = self._run.library.library.files.get(told.form.span.file)
        declared = "its declaration"
        if source is not None:
            row = source.position(told.form.span.start).row
            declared = f"{told.form.span.file}:{row}"
        world = self._run.port.name
        return PortError(f"in the world `{world}` {said}; see {declared}")

    def _surplus(
        self,
        noting: NotingMemory,
        patterns: Sequence[tuple[nodes.DeclaredEffect, Fact]],
    ) -> Iterator[tuple[str, str]]:
        """Yield a handler's undeclared changes, each with the place in the handler."""
        relations = self._run.beliefs.signatures.relations
        now_called = self._run.beliefs.canonical
        for change in noting.made:
            fact = now_called(change.fact)
            if not any(
                not effect.negated and match_pattern(pattern, fact) is not None
                for effect, pattern in patterns
            ):
                told = format_list(fact)
                yield f"asserted {told}, which `:on` does not declare", change.place
        for change in noting.taken:
            fact = now_called(change.fact)
            is_property = relations[str(fact[0])].is_property
            if not any(_takes(e, p, fact, is_property) for e, p in patterns):
                told = format_list(fact)
                yield f"erased {told}, which `:on` does not declare", change.place

    def _missing(
        self,
        patterns: Sequence[tuple[nodes.DeclaredEffect, Fact]],
        given: Mapping[str, Atom],
    ) -> Iterator[str]:
        """Yield the declared effects of a handler that do not hold."""
        for effect, pattern in patterns:
            if effect.possible:
                continue
            if effect.negated:
                left = self._matching(pattern)
                if left is not None:
                    yield f"did not erase {format_list(left)}, as `:on` declares"
            elif not self._holds(effect, given):
                yield f"did not make {format_list(pattern)} hold, as `:on` declares"

    def _named(self, value: Atom) -> Atom:
        """Return the memory name for a sensor name from the handler's arguments."""
        name_of = self._run.beliefs.items.name_of
        return name_of(value) if isinstance(value, str) else value

    def _filled(self, effect: nodes.DeclaredEffect, given: Mapping[str, Atom]) -> Fact:
        """Return the pattern of an effect with the values of the arguments."""
        pattern = effect.pattern
        signature = self._run.beliefs.signatures.relations[pattern.name]
        parts: list[Atom] = [pattern.name]
        for term in signature.full(pattern.args):
            if isinstance(term, nodes.Var):
                parts.append(given.get(term.name, term.name))
            elif isinstance(term, nodes.Const):
                parts.append(term.value)
            else:
                parts.append("?")
        return self._run.beliefs.canonical(tuple(parts))

    def _matching(self, pattern: Fact) -> Fact | None:
        """Return the oldest fact in memory that matches `pattern`."""
        facts = self._run.beliefs.facts.starting((pattern[0],))
        return next(
            (fact for fact in facts if match_pattern(pattern, fact) is not None), None
        )

    def _holds(self, effect: nodes.DeclaredEffect, given: Mapping[str, Atom]) -> bool:
        """Return whether the fact of an effect holds, evaluated like a clause."""
        formula = effect.pattern
        used = {arg.name for arg in formula.args if isinstance(arg, nodes.Var)}
        names = [name for name in given if name in used]
        ready = self._questions.get(id(effect))
        if ready is None:
            ready = self._question(formula, names)
            self._questions[id(effect)] = ready
        return ready(*[given[name] for name in names])


def _takes(
    effect: nodes.DeclaredEffect, pattern: Fact, fact: Fact, is_property: bool
) -> bool:
    """Return whether an effect allows to remove `fact`, perhaps as an old value."""
    if (effect.negated or effect.possible) and match_pattern(pattern, fact) is not None:
        return True
    replaced = is_property and not effect.negated
    return replaced and match_pattern(pattern[:-1], fact[:-1]) is not None


def hold_handlers(run: Run, question: Question) -> None:
    """Check the handlers of a run against their declarations, from now on.

    `question` compiles the formulas of declared effects into tests.
    """
    held, library = _Held(run, question), run.library.library
    results = {
        name: _Told(form, f"the handler of `{name}`")
        for name, form in library.primitives.items()
        if form.on
    }
    data = {
        name: _Told(datum, f"the handler of the datum `{name}`")
        for name, datum in library.data.items()
        if datum.on is not None
    }
    for name, told in results.items():
        handler = run.result_handlers.get(name)
        run.result_handlers[name] = partial(held.result, told, handler)
    handlers = dict(run.handlers.data)
    for name in {*data} & {*handlers}:
        handlers[name] = partial(held.datum, data[name], handlers[name])
    run.handlers = Handlers(run.handlers.results, handlers)

    def held_changing(name: str, changes: Sequence[Change], datum: bool = False) -> Any:
        handler = changing(run, name, changes, datum)
        told = (data if datum else results).get(name)
        if told is None:
            return handler
        return partial(held.datum if datum else held.result, told, handler)

    run.changing = held_changing
