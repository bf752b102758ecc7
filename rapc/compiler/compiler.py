"""What compiling clauses shares: signatures, queries, and places in the source."""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.graph import components
from rapc.base.source import Span
from rapc.compiler.query.query import Query
from rapc.compiler.query.term_value import TermValue
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import Library
from rapc.library.signatures import Signatures


class RequestPlan:
    """A proposition to be filled in: a primitive's request or a notation.

    `bare` is all of it where there are no arguments.
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
    """The recursive RAPs of a library: the only ones tested for recursion [T 3.2.5].

    A RAP is recursive if it is called, directly or through others, by itself. Only RAPs
    that can be reached from those asked about are read, for a library that was compiled
    decodes a RAP when it is first looked at. What methods of problem solvers call is
    not known here.
    """

    def __init__(self, library: Library) -> None:
        self._raps = library.raps
        self._known: dict[str, bool] = {}

    def covers(self, name: str) -> bool:
        """Return whether the RAP `name` may come up among its own subtasks."""
        if name not in self._known:
            for members in components([name], self._calls, self._known):
                is_circle = len(members) > 1 or members[0] in self._calls(members[0])
                self._known.update(dict.fromkeys(members, is_circle))
        return self._known[name]

    def _calls(self, name: str) -> dict[str, None]:
        """Return the RAPs that the methods of a RAP call, each once, in order."""
        methods = self._raps[name].methods
        goals = (step.goal.name for method in methods for step in steps(method))
        return dict.fromkeys(called for called in goals if called in self._raps)


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
