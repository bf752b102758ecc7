"""What is wrong with a test, as against the library: found before it is run.

A name that nobody declares would make an expectation fail for the wrong reason, or, in
`never`, hold for none.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping

import msgspec

from rapc.base.names import counted, nearest
from rapc.base.source import Span
from rapc.compiler.vocabulary import Vocabulary
from rapc.errors import FactError
from rapc.ir import nodes, walk
from rapc.library.library import Library
from rapc.runtime.events import events
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.memory import Memory
from rapc.testing.patterns import flat
from rapc.worlds.script import Row, offer_of, row_problems


class Problem(msgspec.Struct, frozen=True):
    """What is wrong with a test, and where: one line."""

    span: Span
    message: str


def problems(
    test: nodes.DefineTest,
    library: Library,
    handled: Collection[str],
    solved: Collection[str],
) -> list[Problem]:
    """All that is wrong with a test of a library.

    Args:
        test: the test.
        library: what it runs.
        handled: the sensor data that there are handlers for.
        solved: the RAPs that have problem solvers, whose methods nobody knows before.
    """
    validator = _Validator(library, handled, solved)
    return list(validator.test(test))


def row_of(row: nodes.ScriptRow) -> Row:
    """A row of a test's script as the scripted world takes it."""
    return Row(
        pattern=flat(row.request),
        result=row.result or "okay",
        times=row.times,
        takes=row.takes,
        after=row.after,
        asserts=tuple(map(flat, row.asserts)),
        erases=tuple(map(flat, row.erases)),
        data=tuple(map(flat, row.data)),
        signals=tuple(map(flat, row.signals)),
    )


class _Validator:
    """Looks at the parts of a test with a library at hand."""

    def __init__(
        self, library: Library, handled: Collection[str], solved: Collection[str]
    ) -> None:
        self._library = library
        self._handled = handled
        self._solved = solved
        self._offer = offer_of(library)
        self._memory = Memory(Vocabulary.of(library), Recorder())

    def test(self, test: nodes.DefineTest) -> Iterator[Problem]:
        """Everything, in the order of the clauses."""
        yield from self._facts(test.facts)
        for row in test.script:
            yield from self._row(row)
        for at in test.ats:
            for action in at.actions:
                yield from self._action(action)
        for task in test.tasks:
            yield from self._goal(task.goal)
        for expectation in test.expectations:
            yield from self._expectation(expectation)

    # --- what is given -------------------------------------------------------------

    def _facts(self, facts: Iterable[nodes.Proposition]) -> Iterator[Problem]:
        for fact in facts:
            values = [a.value if isinstance(a, nodes.Const) else "?" for a in fact.args]
            try:
                self._memory.checked((fact.name, *values))
            except FactError as error:
                yield Problem(fact.span, str(error))

    def _prefixes(self, prefixes: Iterable[nodes.Proposition]) -> Iterator[Problem]:
        for prefix in prefixes:
            if prefix.name not in self._memory.vocabulary.relations:
                yield Problem(prefix.span, f"`{prefix.name}` is not declared")

    def _row(self, row: nodes.ScriptRow) -> Iterator[Problem]:
        if row.kind != "request" or row.refused:
            yield Problem(row.span, "skills and conflicts cannot be run yet")
            return
        for message in row_problems(row_of(row), self._offer, self._handled):
            yield Problem(row.span, message)
        yield from self._facts(row.asserts)
        yield from self._prefixes(row.erases)

    def _action(self, action: nodes.Action) -> Iterator[Problem]:
        match action:
            case nodes.Asserts(facts):
                yield from self._facts(facts)
            case nodes.Erases(prefixes):
                yield from self._prefixes(prefixes)
            case nodes.Signals(signals):
                for signal in signals:
                    yield from self._offered(signal, "event", self._offer.events)
            case nodes.GivenTask(goal) | nodes.Cancel(goal):
                yield from self._goal(goal)
            case nodes.Expect(expectations):
                for expectation in expectations:
                    yield from self._expectation(expectation)

    # --- what is expected ------------------------------------------------------------

    def _expectation(self, node: nodes.Expectation) -> Iterator[Problem]:
        match node:
            case nodes.Succeeds() | nodes.Fails() | nodes.Active() | nodes.EndsBy():
                yield from self._goal(node.goal)
                if isinstance(node, nodes.Succeeds):
                    yield from self._outputs(node)
            case nodes.SelectedBefore(first, second):
                yield from self._goal(first)
                yield from self._goal(second)
            case nodes.Primitives(requests) | nodes.PrimitivesInclude(requests):
                for request in requests:
                    yield from self._request(request)
            case nodes.Never(request):
                yield from self._request(request)
            case nodes.MemoryHolds(formula):
                yield from self._formula(formula)
            case nodes.MethodChosen():
                yield from self._method(node)
            case nodes.TraceHas(patterns):
                for pattern in patterns:
                    yield from _event(pattern)

    def _goal(self, goal: nodes.Goal) -> Iterator[Problem]:
        rap = self._library.raps.get(goal.name)
        if rap is None:
            yield _unknown(goal.span, "there is no RAP", goal.name, self._library.raps)
        elif len(rap.inputs) != len(goal.args):
            message = f"`{goal.name}` takes {counted(len(rap.inputs), 'input')}"
            yield Problem(goal.span, f"{message}, not {len(goal.args)}")

    def _outputs(self, node: nodes.Succeeds) -> Iterator[Problem]:
        rap = self._library.raps.get(node.goal.name)
        if rap and node.outputs and len(node.outputs) != len(rap.outputs):
            message = f"`{rap.name}` has {counted(len(rap.outputs), 'output')}"
            yield Problem(node.span, f"{message}, not {len(node.outputs)}")

    def _request(self, request: nodes.Pattern) -> Iterator[Problem]:
        arities = {name: n for name, (n, _) in self._offer.primitives.items()}
        yield from self._offered(request, "primitive", arities)

    def _offered(
        self, pattern: nodes.Pattern, what: str, offered: Mapping[str, int]
    ) -> Iterator[Problem]:
        arity = offered.get(pattern.name)
        if arity is None:
            yield _unknown(pattern.span, f"there is no {what}", pattern.name, offered)
        elif arity != len(pattern.args):
            message = f"`{pattern.name}` takes {counted(arity, 'argument')}"
            yield Problem(pattern.span, f"{message}, not {len(pattern.args)}")

    def _formula(self, formula: nodes.Formula) -> Iterator[Problem]:
        functions = self._memory.vocabulary.functions
        patterns = [
            f for f in walk.subformulas(formula) if isinstance(f, nodes.Proposition)
        ]
        yield from self._facts(p for p in patterns if p.name not in functions)

    def _method(self, node: nodes.MethodChosen) -> Iterator[Problem]:
        rap = self._library.raps.get(node.rap)
        if rap is None:
            yield _unknown(node.span, "there is no RAP", node.rap, self._library.raps)
            return
        names = [
            f"#{method.position}" if method.name is None else str(method.name)
            for method in rap.methods
        ]
        if node.method not in names and node.rap not in self._solved:
            what = f"`{node.rap}` has no method"
            yield _unknown(node.span, what, node.method, names)


def _unknown(span: Span, what: str, name: str, known: Collection[str]) -> Problem:
    near = nearest(name, known)
    hint = f"; did you mean `{near}`?" if near else ""
    return Problem(span, f"{what} `{name}`{hint}")


def _event(pattern: nodes.EventPattern) -> Iterator[Problem]:
    kinds = _event_keys()
    keys = kinds.get(pattern.event)
    if keys is None:
        yield _unknown(pattern.span, "there is no event", pattern.event, kinds)
        return
    for key, _ in pattern.keys:
        if key not in keys:
            what = f"`{pattern.event}` has no key"
            yield _unknown(pattern.span, what, key, keys)


def _event_keys() -> dict[str, tuple[str, ...]]:
    """The keys of each kind of event, by the event's name."""
    found: dict[str, tuple[str, ...]] = {}
    stack: list[type[events.Event]] = [events.Event]
    while stack:
        kind = stack.pop()
        below = kind.__subclasses__()
        stack.extend(below)
        if not below:
            found[str(kind.__struct_config__.tag)] = kind.__struct_encode_fields__
    return found
