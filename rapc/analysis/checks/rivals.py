"""RAP136 and RAP137: standing tasks of an agenda that get in each other's way."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.crossed_claims import things
from rapc.analysis.facts.effects import done_by_method, reached
from rapc.analysis.facts.logic import (
    Literal,
    asked_through,
    entails,
    through,
)
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import input_terms, substitute
from rapc.library.library import Library

_CART = """\
(declare-memory-property battery (?level) unknown)
(declare-memory-proposition called (?room))
(declare-primitive drive (?room) (okay) :uses (wheels))
(declare-primitive plug-in () (okay) :uses (wheels))
(define-rap (go ?room) (method (primitive (drive ?room))))
(define-rap (answer)
  (succeed nil)
  (monitor-state (and (called ?room) (battery ?level) (> ?level 10)))
  (repeat-while (called ?room))
  (method (task-net (t1 (go ?room)))))
(define-rap (recharge)
  (succeed nil)
  (monitor-state (and (battery ?level) (< ?level 20)))
  (method (primitive (plug-in))))
(define-agenda day
  (task (answer) :priority 4 :background true)
  (task (recharge) :priority {} :background true))
"""

RIVALS = Rule(
    code="RAP136",
    name="rival-reactions",
    severity=Severity.WARNING,
    summary="two standing tasks of one priority wake by one fact and need one thing",
    why="""Standing tasks that one fact can wake are often awake together. Of one
priority, neither interrupts the other: which of them gets the thing that both need is
chance, and the other waits until it is free (T 5.4.1). Say by priorities which one is
more urgent.""",
    ignore="where either of the two may wait for the other",
    source="T 5.4.1",
    example=_CART.format(4),
    better=_CART.format(6),
)

_LAMP = """\
(declare-memory-proposition lit (?lamp))
(declare-primitive press (?lamp) (okay) :on (okay (lit ?lamp)))
(declare-primitive release (?lamp) (okay) :on (okay (not (lit ?lamp))))
(define-rap (keep-lit)
  (succeed nil)
  (monitor-state (not (lit hall)))
  (method (primitive (press hall))))
(define-rap (keep-dark)
  (succeed nil)
  (monitor-state (lit {}))
  (method (primitive (release {}))))
(define-agenda night
  (task (keep-lit) :priority 4 :background true)
  (task (keep-dark) :priority 6 :background true))
"""

UNDOING = Rule(
    code="RAP137",
    name="undoing-reactions",
    severity=Severity.WARNING,
    summary="each of two standing tasks brings about what wakes the other one",
    why="""What one of the two does wakes the other, and the other way round: they undo
each other's work for good, as fast as the world lets them (T 4.7.1). Let the monitor of
one of them ask for more, so that there is a state in which both sleep.""",
    ignore="where the two take turns on purpose, as a lamp that blinks",
    source="T 4.7.1",
    example=_LAMP.format("hall", "hall"),
    better=_LAMP.format("attic", "attic"),
)


@check(RIVALS, UNDOING)
def rivals(run: Pass) -> Iterator[Diagnostic]:
    """Find standing tasks of an agenda that get in each other's way."""
    told: set[tuple[str, str]] = set()
    for agenda in run.library.agendas.values():
        tasks = [one for one in agenda.tasks if one.background]
        for one, other in combinations(tasks[:_MOST], 2):
            if one.goal.name == other.goal.name:
                continue
            if (agenda.name, other.goal.name) in told:
                continue
            for found in _between(run, one, other):
                told.add((agenda.name, other.goal.name))
                yield found


_MOST = 40
"""So many standing tasks of an agenda are held against each other."""


def _between(
    run: Pass, one: nodes.GivenTask, other: nodes.GivenTask
) -> Iterator[Diagnostic]:
    library = run.library
    first, second = library.raps.get(one.goal.name), library.raps.get(other.goal.name)
    if first is None or second is None:
        return
    if first.monitor_state is None or second.monitor_state is None:
        return
    if _wakes(run, one.goal, other.goal) and _wakes(run, other.goal, one.goal):
        yield UNDOING.at(
            second.monitor_state.span,
            f"`{first.name}` and `{second.name}` wake each other for good",
            labels=(Label(first.monitor_state.span, "this one comes true in turn"),),
            help="let one of them ask for more",
        )
    elif one.priority == other.priority:
        shared = _shared_facts(library, one.goal, other.goal)
        both = sorted(
            _needed(library, first) & _needed(library, second), key=format_formula
        )
        if shared and both:
            yield RIVALS.at(
                other.span,
                f"`{first.name}` and `{second.name}` wake by `{shared[0]}`, "
                f"need `{format_formula(both[0])}`, and have one priority",
                labels=(Label(one.span, f"priority {one.priority} too"),),
                help="give the more urgent one the higher priority",
            )


def _monitor(library: Library, goal: nodes.Goal) -> nodes.Formula:
    """The monitor of the RAP of a goal, with the arguments of the goal in it."""
    rap = library.raps[goal.name]
    assert rap.monitor_state is not None
    return substitute(rap.monitor_state, input_terms(rap, goal))


def _shared_facts(
    library: Library, first: nodes.Goal, second: nodes.Goal
) -> Sequence[str]:
    """The facts that can wake both."""
    monitor = _monitor(library, first)
    if asked_through(library, monitor) is None:
        return ()
    others = list(_facts(library, _monitor(library, second)))
    return sorted(
        {
            one.name
            for one in _facts(library, monitor)
            if any(_may_be_one(one, other) for other in others)
        }
    )


def _facts(library: Library, monitor: nodes.Formula) -> Iterator[nodes.Proposition]:
    for one in through(library, monitor):
        if isinstance(one, nodes.Proposition) and one.name not in library.queries:
            yield one


def _may_be_one(one: nodes.Proposition, other: nodes.Proposition) -> bool:
    """Whether one fact may match both, as far as their constants tell."""
    return one.name == other.name and not any(
        isinstance(left, nodes.Const)
        and isinstance(right, nodes.Const)
        and left != right
        for left, right in zip(one.args, other.args, strict=False)
    )


def _needed(library: Library, rap: nodes.DefineRap) -> frozenset[nodes.Thing]:
    """The things that methods of a RAP, or of those it asks for, take."""
    methods = [m for rap in reached(library, [rap.name]).values() for m in rap.methods]
    return frozenset(thing for method in methods for thing in things(library, method))


def _wakes(run: Pass, one: nodes.Goal, other: nodes.Goal) -> bool:
    """Whether what a task does surely brings about what another one waits for."""
    library, relations = run.library, run.signatures.relations
    monitor, rap = _monitor(library, other), library.raps[one.name]
    given = input_terms(rap, one)
    return bool(rap.methods) and all(
        entails(
            [
                Literal(substitute(fact.formula, given), fact.holds)
                for fact in done_by_method(library, method)
            ],
            monitor,
            (),
            relations,
        )
        for method in rap.methods
    )
