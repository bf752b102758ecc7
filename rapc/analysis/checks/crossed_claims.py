"""RAP133: methods that take two things in opposite orders, by the agendas [L 8.27].

A method holds what it claims while its steps wait. Where a step below it wants a second
thing, and another task of the agenda does so the other way round at the same priority,
the two can wait for each other for good. Things count that have no variables in them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import steps
from rapc.library.library import Library

_WORK = """\
(declare-primitive drive (?to) (okay) :uses (wheels))
(declare-primitive grasp (?thing) (okay) :uses (arm))
(define-rap (go ?to) (method (primitive (drive ?to))))
(define-rap (take ?thing) (method (primitive (grasp ?thing))))
(define-rap (fetch ?thing)
  (method (claims wheels) (task-net (t1 (take ?thing)))))
(define-agenda day (task (fetch cup)) (task (carry plate kitchen)))
"""

CROSSED = Rule(
    code="RAP133",
    name="crossed-claims",
    severity=Severity.WARNING,
    summary="two tasks of an agenda take the same two things in opposite orders",
    why="""A method holds what it claims until it ends, while its steps wait too. One
that holds a thing and wants a second, beside another of the same priority that holds
the second and wants the first, can wait for it for good: nothing breaks the circle.
Claim all that is needed at one place, where a method gets all of its claims or none; or
claim in one order everywhere.""",
    ignore="where the two tasks are never under way together",
    source="T 7.2.1",
    example=_WORK
    + """\
(define-rap (carry ?thing ?to)
  (method (claims arm) (task-net (t1 (go ?to)))))
""",
    better=_WORK
    + """\
(define-rap (carry ?thing ?to)
  (method (claims arm wheels) (task-net (t1 (go ?to)))))
""",
)

_MOST = 400
"""So many RAPs, with what is held above them, are looked at below a task."""

_Things = frozenset[nodes.Thing]


class _Taken(msgspec.Struct, frozen=True):
    """A thing that is wanted while others are held."""

    thing: nodes.Thing
    held: _Things
    rap: nodes.DefineRap


_Orders = Mapping[tuple[nodes.Thing, nodes.Thing], Sequence[_Taken]]
"""What is wanted by what is held and what is wanted."""


_Known = dict[tuple[nodes.Thing, nodes.Thing], dict[_Things, _Taken]]
"""The same of several tasks, by all that is held; of those alike the first one."""


@check(CROSSED)
def crossed_claims(run: Pass) -> Iterator[Diagnostic]:
    """Find tasks of an agenda that take two things in opposite orders."""
    raps = run.library.raps.values()
    if not any(method.claims for rap in raps for method in rap.methods):
        return
    orders: dict[str, _Orders] = {}
    told: set[_Things] = set()
    for agenda in run.library.agendas.values():
        by_priority: dict[int, _Known] = {}
        for task in agenda.tasks:
            name = task.goal.name
            if name not in orders:
                orders[name] = _orders(run.library, name)
            others = by_priority.setdefault(task.priority, {})
            for one, other in _crossed(orders[name], others):
                pair = frozenset((one.thing, other.thing))
                if pair not in told:
                    told.add(pair)
                    yield _finding(one, other)
            for key, taken in orders[name].items():
                known = others.setdefault(key, {})
                for other in taken:
                    known.setdefault(other.held, other)


def _orders(library: Library, goal: str) -> _Orders:
    """Return in which orders things are taken below a task, as far as that is sure."""
    found: dict[tuple[nodes.Thing, nodes.Thing], list[_Taken]] = {}
    waiting: list[tuple[str, _Things]] = [(goal, frozenset())]
    seen = set(waiting)
    while waiting and len(seen) < _MOST:
        name, held = waiting.pop()
        rap = library.raps.get(name)
        if rap is None or not rap.methods:
            continue
        own = [frozenset(things(library, method)) for method in rap.methods]
        always = frozenset.intersection(*own) - held
        for wanted in sorted(always, key=format_formula):
            for thing in sorted(held, key=format_formula):
                taken = _Taken(wanted, held, rap)
                found.setdefault((thing, wanted), []).append(taken)
        for method, mine in zip(rap.methods, own, strict=True):
            for step in steps(method):
                below = (step.goal.name, held | mine)
                if below not in seen:
                    seen.add(below)
                    waiting.append(below)
    return found


def things(library: Library, method: nodes.Method) -> Iterator[nodes.Thing]:
    """Yield what a method asks for before it starts, if no variable stands in it."""
    asked = [*method.claims]
    if isinstance(method.body, nodes.Primitive):
        form = library.primitives.get(method.body.request.name)
        asked += form.uses if form is not None else ()
    for thing in asked:
        if all(isinstance(term, nodes.Const) for term in thing.args):
            yield thing


def _crossed(orders: _Orders, others: _Known) -> Iterator[tuple[_Taken, _Taken]]:
    """Yield what is taken in opposite orders, unless a third thing keeps it apart."""
    for (thing, wanted), mine in orders.items():
        for other in others.get((wanted, thing), {}).values():
            one = next((one for one in mine if not one.held & other.held), None)
            if one is not None:
                yield one, other
                break


def _finding(one: _Taken, other: _Taken) -> Diagnostic:
    first, second = format_formula(one.thing), format_formula(other.thing)
    return CROSSED.at(
        one.rap.name_span,
        f"`{one.rap.name}` wants `{first}` while `{second}` is held, "
        f"`{other.rap.name}` the other way round",
        labels=(
            Label(other.rap.name_span, f"wants `{second}` while `{first}` is held"),
        ),
        help="claim both at one place, or in one order",
    )
