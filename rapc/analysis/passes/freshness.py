"""RAP157: beliefs that are to be younger than the time between two sensings.

A fact is sensed as often as the tasks come up that ask for the primitives that tell it.
Where all of these stand below standing tasks that wait between their rounds, the
shortest of these times is how old the belief may well be.
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.asked import through
from rapc.analysis.endless import is_never
from rapc.analysis.index import INDEX, Index
from rapc.analysis.literals import literals, number
from rapc.analysis.passes.standing import is_described
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.base.values import Number, format_atom
from rapc.ir import nodes
from rapc.ir.walk import Clause, formulas, steps
from rapc.library.library import Library

_GAUGE = """\
(declare-memory-property pressure (?bar) unknown)
(declare-primitive read-gauge () (okay) :tells (gauge) :on (okay))
(declare-sensor-datum gauge (?bar) :on ((pressure ?bar)))
(declare-primitive open-valve () (okay) :on (okay))
(define-rap (watch-gauge)
  (succeed nil)
  (monitor-time now 60 90)
  (method (primitive (read-gauge))))
(define-rap (let-off-steam)
  (preconditions (believe (pressure ?) {}))
  (method (primitive (open-valve))))
(define-agenda day
  (task (watch-gauge) :priority 4 :background true)
  (task (let-off-steam)))
"""

FRESHER = Rule(
    code="RAP157",
    name="fresher-than-sensed",
    severity=Severity.WARNING,
    summary="a belief is to be younger than the time between two sensings of the fact",
    why="""`(believe fact n)` holds if the fact came less than n time units ago (T
4.1.1). Here only standing tasks look, and they wait longer than that between two looks:
most of the time the belief is too old, whatever the world is like. Ask for an older
one, look more often, or look in the RAP itself before it asks. Told of contexts,
conditions and `repeat-while`, where the times are numbers; not of monitors, which may
well wait for the next look, nor of facts that data bring unasked or that a RAP senses
which anybody may ask for.""",
    ignore="where the belief is to hold only just after a look",
    source="T 4.1.1",
    example=_GAUGE.format(10),
    better=_GAUGE.format(90),
)

_WHERE: frozenset[Clause] = frozenset(
    ("context", "preconditions", "constraints", "repeat-while", "for")
)
"""The clauses in which a belief has to hold when its task comes up."""

_AT_ANY_TIME = 0
"""How often what anybody may ask for is done."""


class _Sensed(msgspec.Struct, frozen=True):
    """How often a fact is sensed at best, and what says so."""

    every: Number
    said: Span


def _run(run: Pass) -> None:
    library = run.library
    believed = [
        one for one in run.result(INDEX).of(nodes.Believe) if number(one.node.age)
    ]
    if not believed or not run.complete or not is_described(library):
        return
    sensing = _Sensing(library, run.result(INDEX))
    told: set[int] = set()
    for rap in library.raps.values():
        for whole in formulas(rap):
            if whole.clause not in _WHERE:
                continue
            for part in through(library, whole.formula):
                if isinstance(part, nodes.Believe) and id(part) not in told:
                    found = sensing.of(part.pattern.name)
                    age = number(part.age)
                    if found is not None and age is not None and 0 < age < found.every:
                        told.add(id(part))
                        run.report(_finding(part, age, found))


ANALYZER = Analyzer(
    name="freshness",
    doc="Finds beliefs that are to be younger than the time between two sensings.",
    run=_run,
    needs=(INDEX,),
    rules=(FRESHER,),
    needs_whole="form",
)


def _finding(believe: nodes.Believe, age: Number, sensed: _Sensed) -> Diagnostic:
    every = format_atom(sensed.every)
    return Diagnostic(
        rule=FRESHER.name,
        message=f"`{believe.pattern.name}` is sensed every {every} at best, and is "
        f"seldom younger than {format_atom(age)}",
        span=believe.age.span,
        labels=(Label(sensed.said, "the task that looks waits here"),),
        help="ask for an older belief, or look more often",
    )


class _Sensing:
    """How often facts are sensed.

    Args:
        library: the library.
        index: its nodes.
    """

    def __init__(self, library: Library, index: Index) -> None:
        self._library = library
        self._index = index
        self._sources = _sources(library)
        self._callers: dict[str, set[str]] = {}
        for rap in library.raps.values():
            for method in rap.methods:
                for step in steps(method):
                    self._callers.setdefault(step.goal.name, set()).add(rap.name)
        self._given = {
            goal.node.name
            for goal in index.of(nodes.Goal)
            if type(goal.owner) is nodes.DefineAgenda
        }
        self._known: dict[str, _Sensed | None] = {}

    def of(self, fact: str) -> _Sensed | None:
        """Return how often a fact is sensed; None if at any time, or never."""
        if fact not in self._known:
            self._known[fact] = self._of(fact)
        return self._known[fact]

    def _of(self, fact: str) -> _Sensed | None:
        sources = self._sources.get(fact, {None})
        best: _Sensed | None = None
        for name in sources:
            found = None if name is None else self._every(name)
            if found is None:
                return None
            if best is None or found.every < best.every:
                best = found
        return best

    def _every(self, start: str) -> _Sensed | None:
        """Return how often tasks of a RAP come up; None if at any time."""
        best: _Sensed | None = None
        waiting, seen = [start], {start}
        while waiting:
            name = waiting.pop()
            own = _pause(self._library.raps[name])
            if own is not None:
                if best is None or own.every < best.every:
                    best = own
                continue
            callers = self._callers.get(name, set())
            if not callers or name in self._given:
                return None
            waiting += [one for one in callers if one not in seen]
            seen |= callers
        return best


def _sources(library: Library) -> dict[str, set[str | None]]:
    """Return the RAPs that may bring facts; None among them: what comes unasked."""
    by_primitive: dict[str, set[str]] = {}
    told = {name for form in library.primitives.values() for name in form.tells}
    found: dict[str, set[str | None]] = {}
    for name, datum in library.data.items():
        for fact in _brought(datum.on or ()):
            if name not in told:
                found.setdefault(fact, set()).add(None)
    for form in library.primitives.values():
        facts = {fact for on in form.on for fact in _brought(on.effects)}
        for name in form.tells:
            known = library.data.get(name)
            facts |= set(_brought(known.on or ())) if known is not None else set()
        by_primitive[form.name] = facts
    for rap in library.raps.values():
        for method in rap.methods:
            for note in method.notations:
                found.setdefault(note.name, set()).add(rap.name)
            if isinstance(method.body, nodes.Primitive):
                for fact in by_primitive.get(method.body.request.name, ()):
                    found.setdefault(fact, set()).add(rap.name)
    for fact, by in _by_rules(library):
        found.setdefault(fact, set()).add(by)
    return found


def _brought(effects: tuple[nodes.DeclaredEffect, ...]) -> Iterator[str]:
    for effect in effects:
        if not effect.negated:
            yield effect.pattern.name


def _by_rules(library: Library) -> Iterator[tuple[str, str | None]]:
    """Yield the facts that rules over memory bring, with the RAPs they are about."""
    rules: dict[str | None, list[nodes.Rule]] = {
        None: [one for form in library.event_rules for one in form.rules]
    }
    for form in library.memory_rules:
        own = [one for case in form.cases for one in case.rules]
        name = form.index.name if form.index.name in library.raps else None
        rules.setdefault(name, []).extend(own)
    for by, there in rules.items():
        for one in there:
            for alternative in one.alternatives:
                for action in alternative.actions:
                    if action.op == "mem-add":
                        yield action.pattern.name, by


def _pause(rap: nodes.DefineRap) -> _Sensed | None:
    """Return how long a standing RAP surely waits between two rounds, if it does."""
    if rap.succeed is None or not is_never(rap.succeed):
        return None
    timed = rap.monitor_time
    if timed is not None and timed.reference == "now":
        start = number(timed.start)
        if start is not None and start > 0:
            return _Sensed(start, timed.span)
    for one in literals(rap.monitor_state):
        if isinstance(one.formula, nodes.Believe) and not one.holds:
            age = number(one.formula.age)
            if age is not None and age > 0:
                return _Sensed(age, one.span)
    return None
