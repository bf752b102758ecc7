"""The nodes of declarations, of rules over memory, and of `require` (T A, S 4)."""

from __future__ import annotations

from typing import Literal

from rapc.base.source import NOWHERE, Span
from rapc.base.values import Atom
from rapc.ir.formulas import Const, Formula, Node, Pattern, Term, Var
from rapc.ir.raps import Goal


class Argument(Node, frozen=True, eq=False):
    """A declared argument: its variable and, if given, its kind (`number`, ...)."""

    variable: Var
    kind: str | None
    span: Span = NOWHERE


class Exclusion(Node, frozen=True, eq=False):
    """`:excludes value (pattern)` of a property (semantics 7)."""

    value: Atom
    pattern: Pattern
    span: Span = NOWHERE


class DeclareProposition(Node, frozen=True, eq=False):
    """`(declare-memory-proposition name (arg...) ["doc"])`; `args` may be missing."""

    name: str
    args: tuple[Argument, ...] | None
    doc: str
    span: Span = NOWHERE


class DeclareProperty(Node, frozen=True, eq=False):
    """`(declare-memory-property name (arg... value) default ["doc"])`.

    `default` is `unknown`, `true`, `false` or the name of a registered function;
    `args` is None in T's form without the list, else the value comes last.
    """

    name: str
    args: tuple[Argument, ...] | None
    default: str
    excludes: tuple[Exclusion, ...]
    doc: str
    span: Span = NOWHERE


class DeclareFunction(Node, frozen=True, eq=False):
    """`(declare-memory-function name (arg...) [:reads (pred...)] ["doc"])`.

    `reads` is None where nothing was said.
    """

    name: str
    args: tuple[Argument, ...] | None
    reads: tuple[str, ...] | None
    doc: str
    span: Span = NOWHERE


class DeclareIndistinctClass(Node, frozen=True, eq=False):
    """`(declare-indistinct-class name [comparator])`."""

    name: str
    comparator: str | None
    span: Span = NOWHERE


class ComparatorRow(Node, frozen=True, eq=False):
    """One property of a comparator declared in RAP: `veto`, `ignore` or a weight."""

    property: str
    treatment: Literal["veto", "ignore", "score"]
    weight: int | float
    span: Span = NOWHERE


class DeclareComparator(Node, frozen=True, eq=False):
    """`(declare-class-comparator class [place] comparator-name | rows...)` (T A.5)."""

    class_name: str
    place: str | None
    function: str | None
    rows: tuple[ComparatorRow, ...]
    span: Span = NOWHERE


class DeclarePrimitive(Node, frozen=True, eq=False):
    """`(declare-primitive name (arg...) (result...) [:atomic false] ["doc"])`."""

    name: str
    args: tuple[Argument, ...]
    results: tuple[str, ...]
    atomic: bool
    doc: str
    span: Span = NOWHERE


class DeclareDatum(Node, frozen=True, eq=False):
    """`(declare-sensor-datum name (arg...) ["doc"])`."""

    name: str
    args: tuple[Argument, ...]
    doc: str
    span: Span = NOWHERE


class DeclareSkill(Node, frozen=True, eq=False):
    """`(declare-skill :name (arg...) ["doc"])`; the name keeps its colon."""

    name: str
    args: tuple[Argument, ...]
    doc: str
    span: Span = NOWHERE


class DeclareEvent(Node, frozen=True, eq=False):
    """`(declare-event :name (arg...) ["doc"])`; the name keeps its colon."""

    name: str
    args: tuple[Argument, ...]
    doc: str
    span: Span = NOWHERE


# --- rules over memory (S 4.2, 4.3) ------------------------------------------------


class RuleAction(Node, frozen=True, eq=False):
    """`(mem-add p)` or `(mem-del prefix)`."""

    op: Literal["mem-add", "mem-del"]
    pattern: Pattern
    span: Span = NOWHERE


class Alternative(Node, frozen=True, eq=False):
    """`(query action...)` of a rule; no query is written as true."""

    query: Formula
    actions: tuple[RuleAction, ...]
    span: Span = NOWHERE


class Rule(Node, frozen=True, eq=False):
    """`(rule (query action...)...)`: the first query with a solution acts."""

    alternatives: tuple[Alternative, ...]
    span: Span = NOWHERE


class ResultCase(Node, frozen=True, eq=False):
    """`(pattern (rule ...)...)` of a `match-result`.

    `result` is a `Const` symbol (`succeed` or a failure), a `Var`, or, for
    `(signal args...)`, a `Pattern`.
    """

    result: Const | Var | Pattern
    rules: tuple[Rule, ...]
    span: Span = NOWHERE


class MemoryRule(Node, frozen=True, eq=False):
    """`(define-memory-rule index :finish|:event (match-result case...))`."""

    index: Goal
    when: Literal["finish", "event"]
    cases: tuple[ResultCase, ...]
    span: Span = NOWHERE


class EventRule(Node, frozen=True, eq=False):
    """`(define-event-rule (:signal args...) (rule ...)...)`."""

    signal: str
    args: tuple[Term, ...]
    rules: tuple[Rule, ...]
    span: Span = NOWHERE


class Require(Node, frozen=True, eq=False):
    """`(require "name")`."""

    name: str
    span: Span = NOWHERE
