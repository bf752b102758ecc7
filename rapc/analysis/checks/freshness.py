"""RAP157: beliefs that are to be younger than the time between two sensings.

A fact is sensed as often as the tasks come up that ask for the primitives that tell it.
Where all of these stand below standing tasks that wait between their rounds, the
shortest of these times is how old the belief may well be.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.standing import is_described
from rapc.analysis.facts.effects import calls_of, request_effects, rule_effects
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.logic import is_never, literals, number_of, through
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.base.values import Number, format_atom
from rapc.ir import nodes
from rapc.ir.walk import formulas
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

_AT_ANY_TIME = 0
"""How often what anybody may ask for is done."""


class _Sensed(msgspec.Struct, frozen=True):
    """How often a fact is sensed at best, and what says so."""

    every: Number
    said: Span


@check(FRESHER, needs_whole="form")
def freshness(run: Pass) -> Iterator[Diagnostic]:
    """Find beliefs that are to be younger than the time between two sensings."""
    library = run.library
    believed = [
        one for one in run.result(INDEX).of(nodes.Believe) if number_of(one.node.age)
    ]
    if not believed or not run.complete or not is_described(library):
        return
    sensing = _Sensing(library)
    for part in _told(run):
        found, age = sensing.of(part.pattern.name), number_of(part.age)
        if found is not None and age is not None and 0 < age < found.every:
            yield _finding(part, age, found)


def _told(run: Pass) -> Iterator[nodes.Believe]:
    """Yield the beliefs in conditions of RAPs, and in queries that those name."""
    for rap in run.library.raps.values():
        for whole in formulas(rap):
            if whole.clause.is_condition:
                for part in through(run.library, whole.formula):
                    if isinstance(part, nodes.Believe):
                        yield part


def _finding(believe: nodes.Believe, age: Number, sensed: _Sensed) -> Diagnostic:
    every = format_atom(sensed.every)
    return FRESHER.at(
        believe.age.span,
        f"`{believe.pattern.name}` is sensed every {every} at best, and is "
        f"seldom younger than {format_atom(age)}",
        labels=(Label(sensed.said, "the task that looks waits here"),),
        help="ask for an older belief, or look more often",
    )


class _Sensing:
    """How often facts are sensed.

    Args:
        library: the library.
    """

    def __init__(self, library: Library) -> None:
        raps = [form for form in library.forms if isinstance(form, nodes.DefineRap)]
        self._sources = _sources(library, raps)
        self._callers: dict[str, dict[str, None]] = {}
        self._pauses = {rap.name: _pause(rap) for rap in raps}
        for rap in raps:
            for callee in calls_of(rap):
                self._callers.setdefault(callee, {})[rap.name] = None
        agendas = (f for f in library.forms if isinstance(f, nodes.DefineAgenda))
        self._given = {task.goal.name for form in agendas for task in form.tasks}
        self._known: dict[str, _Sensed | None] = {}

    def of(self, fact: str) -> _Sensed | None:
        """Return how often a fact is sensed; None if at any time, or never."""
        if fact not in self._known:
            self._known[fact] = self._of(fact)
        return self._known[fact]

    def _of(self, fact: str) -> _Sensed | None:
        sources = self._sources.get(fact, {None: None})
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
            own = self._pauses[name]
            if own is not None:
                if best is None or own.every < best.every:
                    best = own
                continue
            callers = self._callers.get(name, {})
            if not callers or name in self._given:
                return None
            waiting += [one for one in callers if one not in seen]
            seen.update(callers)
        return best


def _pause(rap: nodes.DefineRap) -> _Sensed | None:
    """Return how long a standing RAP surely waits between two rounds."""
    if rap.succeed is None or not is_never(rap.succeed):
        return None
    timed = rap.monitor_time
    if timed is not None and timed.reference == "now":
        start = number_of(timed.start)
        if start is not None and start > 0:
            return _Sensed(start, timed.span)
    for one in literals(rap.monitor_state):
        if isinstance(one.formula, nodes.Believe) and not one.holds:
            age = number_of(one.formula.age)
            if age is not None and age > 0:
                return _Sensed(age, one.span)
    return None


def _sources(
    library: Library, raps: Sequence[nodes.DefineRap]
) -> dict[str, dict[str | None, None]]:
    """Return the RAPs that may bring facts; None among them: what comes unasked."""
    asked = {name for form in library.primitives.values() for name in form.tells}
    found: dict[str, dict[str | None, None]] = {}

    def bring(facts: Iterable[str], by: str | None) -> None:
        for fact in facts:
            found.setdefault(fact, {})[by] = None

    for name, datum in library.data.items():
        if name not in asked:
            bring((e.pattern.name for e in datum.on or () if not e.negated), None)
    for rap in raps:
        for method in rap.methods:
            bring((note.name for note in method.notations), rap.name)
            if isinstance(method.body, nodes.Primitive):
                effects, _ = request_effects(library, method.body.request)
                bring((one.name for one in effects if not one.gone), rap.name)
    known = {rap.name for rap in raps}
    rules: list[tuple[str | None, Sequence[nodes.Rule]]] = [
        (None, form.rules) for form in library.event_rules
    ]
    for form in library.memory_rules:
        by = form.index.name if form.index.name in known else None
        rules += [(by, case.rules) for case in form.cases]
    for by, there in rules:
        bring((one.name for one in rule_effects(there) if not one.gone), by)
    return found
