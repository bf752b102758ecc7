"""What every node has, and the nodes of terms and formulas (semantics 2).

Nodes are frozen; sequences are tuples; the span is the last field and takes no part in
comparison, so two spellings of one definition are equal.
"""

from __future__ import annotations

from typing import Literal

import msgspec

from rapc.base.source import NOWHERE, Span
from rapc.base.values import Atom


class Node(msgspec.Struct, frozen=True, eq=False, tag=True, gc=False, array_like=True):
    """The base of all nodes: compared by type and fields, the span left out.

    Nodes are trees, so the garbage collector need not look after them. In a compiled
    library a node is a list: its type's name, then its fields.
    """

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return all(
            getattr(self, name) == getattr(other, name)
            for name in self.__struct_fields__
            if not name.endswith("span")
        )

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        names = (n for n in self.__struct_fields__ if not n.endswith("span"))
        return hash((type(self).__name__, *(getattr(self, n) for n in names)))


# --- terms -------------------------------------------------------------------


class Const(Node, frozen=True, eq=False):
    """A symbol, number or string. A `:keyword` is a symbol that starts so."""

    value: Atom
    span: Span = NOWHERE


class Var(Node, frozen=True, eq=False):
    """A variable by its name with the question mark; a bare `?` matches anything."""

    name: str
    span: Span = NOWHERE

    @property
    def anonymous(self) -> bool:
        """Whether this is the bare `?`, a new variable at each place."""
        return self.name == "?"


class Call(Node, frozen=True, eq=False):
    """A computed term: `+ - * /`, `size-of`, `value` or a declared function."""

    function: str
    args: tuple[Term, ...]
    span: Span = NOWHERE


Term = Const | Var | Call


# --- formulas (semantics 2) ----------------------------------------------------


class Truth(Node, frozen=True, eq=False):
    """`t` or `true` (always succeeds), `nil` or `false` (never does)."""

    value: bool
    span: Span = NOWHERE


class Pattern(Node, frozen=True, eq=False):
    """A proposition with terms for arguments, as query, assertion or declared test.

    Which of these it is follows from where it stands and from what its name is
    declared to be: a property, a proposition, or a function used as a test.
    """

    name: str
    args: tuple[Term, ...]
    span: Span = NOWHERE


class And(Node, frozen=True, eq=False):
    """All parts hold, left to right with backtracking; without parts: true."""

    parts: tuple[Formula, ...]
    span: Span = NOWHERE


class Or(Node, frozen=True, eq=False):
    """One part holds, tried in order; without parts: false."""

    parts: tuple[Formula, ...]
    span: Span = NOWHERE


class Not(Node, frozen=True, eq=False):
    """The part has no solution (negation as failure)."""

    part: Formula
    span: Span = NOWHERE


class Compare(Node, frozen=True, eq=False):
    """`=`, `n=`, `<`, `>`, `<=` or `>=` between two terms; binds nothing."""

    op: Literal["=", "n=", "<", ">", "<=", ">="]
    left: Term
    right: Term
    span: Span = NOWHERE


class Believe(Node, frozen=True, eq=False):
    """`(believe p n)`: p is believed with an age below n, or n becomes its age."""

    pattern: Pattern
    age: Term
    span: Span = NOWHERE


class SetTest(Node, frozen=True, eq=False):
    """`(member ?set thing)` or `(empty ?set)`."""

    test: Literal["member", "empty"]
    args: tuple[Term, ...]
    span: Span = NOWHERE


class History(Node, frozen=True, eq=False):
    """`method-tried`, `last-result` or `result-with-method` (T 4.1.2)."""

    query: Literal["method-tried", "last-result", "result-with-method"]
    args: tuple[Term, ...]
    span: Span = NOWHERE


class SensorName(Node, frozen=True, eq=False):
    """`(know-sensor-name x)`, `(know-sensor-name x true)` or `... false)`."""

    item: Term
    value: Term
    span: Span = NOWHERE


class Count(Node, frozen=True, eq=False):
    """`(count class place ?n)`: the size all layers of a set share (semantics 7)."""

    kind: Term
    place: Term
    number: Term
    span: Span = NOWHERE


Formula = (
    Truth
    | Pattern
    | And
    | Or
    | Not
    | Compare
    | Believe
    | SetTest
    | History
    | SensorName
    | Count
)
