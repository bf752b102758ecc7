"""The nodes of `define-rap`: clauses, methods, task-nets, annotations (T 4, S 3)."""

from __future__ import annotations

from typing import Literal

from rapc.base.source import NOWHERE, Span
from rapc.ir.formulas import Formula, Node, Pattern, Term, Var


class MonitorTime(Node, frozen=True, eq=False):
    """`(monitor-time now|absolute start stop)`; start and stop in time units."""

    reference: Literal["now", "absolute"]
    start: Term
    stop: Term
    span: Span = NOWHERE


class Resource(Node, frozen=True, eq=False):
    """`(set ?name [set])` or `(counter ?name [number-or-counter])`."""

    kind: Literal["set", "counter"]
    variable: Var
    initial: Term | None
    span: Span = NOWHERE


class Effect(Node, frozen=True, eq=False):
    """A fact a RAP brings about (or, negated, takes away), for planner and checker."""

    pattern: Pattern
    negated: bool
    span: Span = NOWHERE


class Goal(Node, frozen=True, eq=False):
    """`(rap args... [=> outs...])`: what a step or a top-level task asks for."""

    name: str
    args: tuple[Term, ...]
    outputs: tuple[Term, ...]
    span: Span = NOWHERE


class For(Node, frozen=True, eq=False):
    """`(formula for tag)`, or `(for tag)` with no formula."""

    formula: Formula | None
    tag: str
    span: Span = NOWHERE


class UntilStart(Node, frozen=True, eq=False):
    """`(until-start tag)`."""

    tag: str
    span: Span = NOWHERE


class UntilEnd(Node, frozen=True, eq=False):
    """`(until-end tag)`."""

    tag: str
    span: Span = NOWHERE


class Window(Node, frozen=True, eq=False):
    """`(window tag|now|absolute start stop)`.

    `reference` is a tag; the words `now` and `absolute` are never tags here.
    """

    reference: str
    start: Term
    stop: Term
    span: Span = NOWHERE


class WaitFor(Node, frozen=True, eq=False):
    """`(wait-for (:signal args...) [:proceed|:succeed|:fail])`."""

    signal: str
    args: tuple[Term, ...]
    mode: Literal["proceed", "succeed", "fail"]
    span: Span = NOWHERE


class ResourceEffect(Node, frozen=True, eq=False):
    """`(set-add ?s x)`, `(set-sub ?s x)`, `(counter-add ?c n)`, `(counter-sub ...)`."""

    op: Literal["set-add", "set-sub", "counter-add", "counter-sub"]
    resource: Term
    amount: Term
    span: Span = NOWHERE


Annotation = For | UntilStart | UntilEnd | Window | WaitFor | ResourceEffect


class Step(Node, frozen=True, eq=False):
    """`(tag [priority] goal annotation...)`; the priority adds to the parent's."""

    tag: str
    priority: int
    goal: Goal
    annotations: tuple[Annotation, ...]
    span: Span = NOWHERE


class TaskNet(Node, frozen=True, eq=False):
    """The steps of a method; none means the method ends well at once."""

    steps: tuple[Step, ...]
    span: Span = NOWHERE


class Primitive(Node, frozen=True, eq=False):
    """`(primitive (name args...))`: one request to the world."""

    request: Pattern
    span: Span = NOWHERE


class Skills(Node, frozen=True, eq=False):
    """`(primitive (enable ...) (wait-for ...)... (disable ...))` (S 3.2, semantics 8).

    Skills are patterns whose names are keywords. Each wait's mode is `succeed` or
    `fail`.
    """

    enable: tuple[Pattern, ...]
    waits: tuple[WaitFor, ...]
    disable: tuple[Pattern, ...]
    span: Span = NOWHERE


Body = TaskNet | Primitive | Skills


class Method(Node, frozen=True, eq=False):
    """One way to carry a RAP out. `position` counts from 1 in the text."""

    name: str | int | None
    position: int
    context: Formula | None
    notations: tuple[Pattern, ...]
    body: Body
    span: Span = NOWHERE


class DefineRap(Node, frozen=True, eq=False):
    """A RAP. `name_span` is where its name stands in the index."""

    name: str
    inputs: tuple[Var, ...]
    outputs: tuple[Var, ...]
    duration: Term | None
    monitor_state: Formula | None
    monitor_time: MonitorTime | None
    repeat_while: Formula | None
    succeed: Formula | None
    preconditions: Formula | None
    constraints: Formula | None
    resources: tuple[Resource, ...]
    effects: tuple[Effect, ...]
    methods: tuple[Method, ...]
    name_span: Span = NOWHERE
    span: Span = NOWHERE
