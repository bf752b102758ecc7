"""What compiling clauses shares: signatures, queries, and places in the source."""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.source import Span
from rapc.compiler.query.query import Query
from rapc.compiler.query.term_value import TermValue
from rapc.compiler.recursion import Recursion
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.signatures import Signatures


class RequestPlan:
    """A proposition to be filled in: a primitive's request or a notation.

    `bare` is all of it where there are no arguments.
    """

    __slots__ = ("args", "bare", "name", "node", "where")

    def __init__(
        self, node: nodes.Pattern, args: Sequence[nodes.Term], where: str
    ) -> None:
        self.node = node
        self.name = node.name
        self.bare = (node.name,)
        self.where = where
        self.args = tuple(TermValue(arg, where) for arg in args)


class Compiler:
    """What compiling shares: the signatures, and places to print in faults."""

    def __init__(self, library: Library) -> None:
        self.library = library
        self.signatures = Signatures.of(library)
        #: Which RAPs may come up among their own subtasks.
        self.recursion = Recursion(library)

    def place(self, what: str, span: Span) -> str:
        """A clause's name with the row it stands in: `succeed at arms.rap:12`."""
        row = self.row(span)
        return f"{what} at {row}" if row else what

    def row(self, span: Span) -> str:
        """A file and row, `arms.rap:12`; nothing for what stands in no file."""
        source = self.library.files.get(span.file)
        return "" if source is None else f"{span.file}:{source.row(span.start)}"

    def query(self, formula: nodes.Formula, what: str, span: Span) -> Query:
        """A formula of the clause `what` as a query."""
        span = formula.span if formula.span.file else span
        return Query(formula, self.signatures, self.place(what, span))

    def assertion(self, pattern: nodes.Pattern, what: str) -> RequestPlan:
        """A proposition whose arguments are filled in at run time."""
        relation = self.signatures.relations.get(pattern.name)
        args = pattern.args
        if relation is not None and what == "notation":
            args = relation.full(args)
        return RequestPlan(pattern, args, self.place(what, pattern.span))
