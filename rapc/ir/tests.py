"""The nodes of `define-test`: what a test of a library says, without judging it.

What the clauses and expectations mean is in `docs/testing.md`; `rapc.testing` runs
them. As with all nodes the span comes last and is not compared.
"""

from __future__ import annotations

from typing import Literal

from rapc.base.source import NOWHERE, Span
from rapc.base.values import Number
from rapc.ir.nodes import Const, Formula, Goal, Node, Pattern, Require, Term, Var

# --- what is given -----------------------------------------------------------------


RowKind = Literal["request", "enable", "disable"]


class ScriptRow(Node, frozen=True, eq=False):
    """`((request) [result] option...)`: what the world answers, and what comes of it.

    `request` may hold variables; with `kind` `enable` or `disable` its name is that of
    a skill. `after` is None for an atomic primitive, `times` for a row without limit.
    """

    kind: RowKind
    request: Pattern
    result: str | None
    times: int | None
    takes: Number
    after: Number | None
    asserts: tuple[Pattern, ...]
    erases: tuple[Pattern, ...]
    data: tuple[Pattern, ...]
    signals: tuple[Pattern, ...]
    refused: bool
    span: Span = NOWHERE


class GivenTask(Node, frozen=True, eq=False):
    """`(task goal [:priority n] [:deadline t] [:background true])`."""

    goal: Goal
    priority: int
    deadline: Number | None
    background: bool
    span: Span = NOWHERE


class Asserts(Node, frozen=True, eq=False):
    """`(asserts fact...)`."""

    facts: tuple[Pattern, ...]
    span: Span = NOWHERE


class Erases(Node, frozen=True, eq=False):
    """`(erases prefix...)`."""

    prefixes: tuple[Pattern, ...]
    span: Span = NOWHERE


class Signals(Node, frozen=True, eq=False):
    """`(signals (:name args...)...)`."""

    signals: tuple[Pattern, ...]
    span: Span = NOWHERE


class Cancel(Node, frozen=True, eq=False):
    """`(cancel goal)`: every live top-level task that matches it."""

    goal: Goal
    span: Span = NOWHERE


class Until(Node, frozen=True, eq=False):
    """`(until t)` or, with `cycles`, `(until (cycles n))` and `(cycles n)`."""

    time: Number | None
    cycles: int | None
    span: Span = NOWHERE


# --- what is expected --------------------------------------------------------------


class ListPattern(Node, frozen=True, eq=False):
    """A list in an event pattern: a goal, a fact, a list of data."""

    items: tuple[TracePattern, ...]
    span: Span = NOWHERE


TracePattern = Const | Var | ListPattern


class EventPattern(Node, frozen=True, eq=False):
    """`(task-failed :goal (x ?a) ...)`: an event's name and some of its keys.

    Keys are named without the colon.
    """

    event: str
    keys: tuple[tuple[str, TracePattern], ...]
    span: Span = NOWHERE


class Succeeds(Node, frozen=True, eq=False):
    """`(succeeds goal [output...])`."""

    goal: Goal
    outputs: tuple[Term, ...]
    span: Span = NOWHERE


class Fails(Node, frozen=True, eq=False):
    """`(fails goal [result])`; the result is a symbol or a variable."""

    goal: Goal
    result: Const | Var | None
    span: Span = NOWHERE


class Active(Node, frozen=True, eq=False):
    """`(active goal)`."""

    goal: Goal
    span: Span = NOWHERE


class Primitives(Node, frozen=True, eq=False):
    """`(primitives request...)`: all of them, in order."""

    requests: tuple[Pattern, ...]
    span: Span = NOWHERE


class PrimitivesInclude(Node, frozen=True, eq=False):
    """`(primitives-include request...)`: in order, with others between."""

    requests: tuple[Pattern, ...]
    span: Span = NOWHERE


class Never(Node, frozen=True, eq=False):
    """`(never request)`."""

    request: Pattern
    span: Span = NOWHERE


class MemoryHolds(Node, frozen=True, eq=False):
    """`(memory formula)`."""

    formula: Formula
    span: Span = NOWHERE


class MethodChosen(Node, frozen=True, eq=False):
    """`(method rap name [n times])`.

    `method` is written as the trace has it: a name, or `#1` for one without;
    `times` is None where any number from one will do.
    """

    rap: str
    method: str
    times: int | None
    span: Span = NOWHERE


class SelectedBefore(Node, frozen=True, eq=False):
    """`(selected-before goal goal)`."""

    first: Goal
    second: Goal
    span: Span = NOWHERE


class EndsBy(Node, frozen=True, eq=False):
    """`(ends-by time goal)`."""

    time: Number
    goal: Goal
    span: Span = NOWHERE


class TraceHas(Node, frozen=True, eq=False):
    """`(trace event-pattern...)`: in order, with others between."""

    events: tuple[EventPattern, ...]
    span: Span = NOWHERE


Expectation = (
    Succeeds
    | Fails
    | Active
    | Primitives
    | PrimitivesInclude
    | Never
    | MemoryHolds
    | MethodChosen
    | SelectedBefore
    | EndsBy
    | TraceHas
)


class Expect(Node, frozen=True, eq=False):
    """`(expect expectation...)`."""

    expectations: tuple[Expectation, ...]
    span: Span = NOWHERE


# --- the whole -----------------------------------------------------------------------

Action = Asserts | Erases | Signals | GivenTask | Cancel | Expect


class At(Node, frozen=True, eq=False):
    """`(at time action...)`, the actions in the order of the text."""

    time: Number
    actions: tuple[Action, ...]
    span: Span = NOWHERE


class DefineTest(Node, frozen=True, eq=False):
    """`(define-test name ["doc"] clause...)`.

    `name_span` is where its name stands.
    """

    name: str
    doc: str
    requires: tuple[Require, ...]
    world: str | None
    facts: tuple[Pattern, ...]
    script: tuple[ScriptRow, ...]
    ats: tuple[At, ...]
    tasks: tuple[GivenTask, ...]
    until: Until | None
    expectations: tuple[Expectation, ...]
    name_span: Span = NOWHERE
    span: Span = NOWHERE
