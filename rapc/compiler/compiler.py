"""Shared parts of compiling clauses: signatures, queries, source positions."""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.graph import components
from rapc.base.source import Span
from rapc.compiler.query.query import Query
from rapc.compiler.query.term_value import TermValue
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import Library, usable_in_plans
from rapc.library.signatures import Signatures


class RequestPlan:
    """A proposition with arguments to compute: a request or a notation.

    `bare` is the complete proposition if there are no arguments.
    """

    def __init__(
        self, node: nodes.Pattern, args: Sequence[nodes.Term], where: str
    ) -> None:
        self.node = node
        self.name = node.name
        self.bare = (node.name,)
        self.where = where
        self.args = tuple(TermValue(arg, where) for arg in args)


class Recursion:
    """The recursive RAPs of a library: the only RAPs tested for recursion [T 3.2.5].

    A RAP is recursive if it calls itself, directly or through other RAPs. Only RAPs
    that are reachable from the queried RAPs are read, because a compiled library
    decodes a RAP at its first use. Calls in the methods of problem solvers are unknown
    here.
    """

    def __init__(self, library: Library) -> None:
        self._raps = library.raps
        self._known: dict[str, bool] = {}

    def covers(self, name: str) -> bool:
        """Return whether the RAP `name` can occur among its own subtasks."""
        if name not in self._known:
            for members in components([name], self._calls, self._known):
                is_circle = len(members) > 1 or members[0] in self._calls(members[0])
                self._known.update(dict.fromkeys(members, is_circle))
        return self._known[name]

    def _calls(self, name: str) -> dict[str, None]:
        """Return the RAPs that the methods of a RAP call, each once, in order."""
        methods = self._raps[name].methods
        goals = [step.goal.name for method in methods for step in steps(method)]
        goals += usable_in_plans(self._raps, self._raps[name])
        return dict.fromkeys(called for called in goals if called in self._raps)


class Compiler:
    """Shared state of compiling: the signatures, and positions for faults."""

    def __init__(self, library: Library) -> None:
        self.library = library
        self.signatures = Signatures.of(library)
        #: The RAPs that can occur among their own subtasks.
        self.recursion = Recursion(library)

    def place(self, what: str, span: Span) -> str:
        """Return a clause's name with its row: `succeed at arms.rap:12`."""
        row = self.row(span)
        return f"{what} at {row}" if row else what

    def row(self, span: Span) -> str:
        """Return a file and row, `arms.rap:12`; no text for a form without a file."""
        source = self.library.files.get(span.file)
        return "" if source is None else f"{span.file}:{source.row(span.start)}"

    def query(self, formula: nodes.Formula, what: str, span: Span) -> Query:
        """Return a formula of the clause `what` as a query."""
        span = formula.span if formula.span.file else span
        return Query(formula, self.signatures, self.place(what, span))

    def assertion(self, pattern: nodes.Pattern, what: str) -> RequestPlan:
        """Return a proposition whose arguments are computed at run time."""
        relation = self.signatures.relations.get(pattern.name)
        args = pattern.args
        if relation is not None and what == "notation":
            args = relation.full(args)
        return RequestPlan(pattern, args, self.place(what, pattern.span))
