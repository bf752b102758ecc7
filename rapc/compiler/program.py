"""A checked library in executable form."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

from msgspec.structs import replace

from rapc.base.resources import Value
from rapc.compiler.compiler import Compiler
from rapc.compiler.query.query import Query
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.compiler.rules import event_rules
from rapc.ir import nodes
from rapc.library.library import Library, digest
from rapc.library.saved_check import Verifier

Opened = tuple[str, Query, dict[str, Value]]
"""A query inside a part of another query: in words, ready, with its bindings."""


class Program:
    """A checked library in executable form, for the interpreter.

    Args:
        library: linked, and without findings of severity error.
        name: the name of the library in traces.
    """

    def __init__(self, library: Library, name: str = "library") -> None:
        self.library = library
        self.name = name
        #: Also compiles methods of problem solvers during a run.
        self.compiler = Compiler(library)
        #: The declarations of the library.
        self.signatures = self.compiler.signatures
        #: The rules that belong to no RAP.
        self.event_rules = event_rules(self.compiler)
        #: Whether any RAP has a rule for signals.
        self.hears_events = any(rule.when == "event" for rule in library.memory_rules)
        self._plans: dict[str, RapPlan] = {}
        self._opened: dict[nodes.Formula, Query] = {}

    @cached_property
    def digest(self) -> str:
        """Return the digest of the texts of the library."""
        return digest(self.library)

    def rap(self, name: str) -> RapPlan | None:
        """Return the plan of a RAP, compiled at the first request."""
        plan = self._plans.get(name)
        if plan is None:
            node = self.library.raps.get(name)
            if node is None:
                return None
            plan = self._plans[name] = RapPlan(self.compiler, node)
        return plan

    def known_rap(self, name: str) -> RapPlan:
        """Return the plan of a RAP that a checked library must have.

        Raises:
            LookupError: if the RAP is missing.
        """
        plan = self.rap(name)
        if plan is None:
            raise LookupError(f"unknown RAP `{name}`")
        return plan

    def opened(self, part: nodes.Formula, env: Mapping[str, Value]) -> list[Opened]:
        """Return the queries inside a part of a query, with their bindings.

        These are the formula of a named query at a use, and the branches of an `or`.
        """
        if isinstance(part, nodes.Or):
            return [("branch", self._inner("branch", b), dict(env)) for b in part.parts]
        node = None
        if isinstance(part, nodes.Proposition):
            node = self.library.queries.get(part.name)
        if node is None or not isinstance(part, nodes.Proposition):
            return []
        words = f"query `{node.name}`"
        given = zip(node.args, part.args, strict=True)
        values = {arg.variable.name: value_in(term, env) for arg, term in given}
        bound = {name: value for name, value in values.items() if value is not None}
        return [(words, self._inner(words, node.formula), bound)]

    def _inner(self, words: str, formula: nodes.Formula) -> Query:
        """Return a formula inside another formula as a query, made once."""
        query = self._opened.get(formula)
        if query is None:
            query = self.compiler.query(formula, words, formula.span)
            self._opened[formula] = query
        return query

    def added_method(self, rap: RapPlan, node: nodes.Method, index: int) -> MethodPlan:
        """Return the plan of a method that is not in the text of the library.

        Raises:
            UnsoundError: for a method with names that the library does not declare.
        """
        Verifier(self.signatures).rap(replace(rap.node, methods=(node,)))
        return MethodPlan(self.compiler, rap.node, node, index)


def value_in(term: nodes.Term, env: Mapping[str, Value]) -> Any:
    """Return the value of a constant or a variable; None without a value."""
    if isinstance(term, nodes.Const):
        return term.value
    return env.get(term.name) if isinstance(term, nodes.Var) else None
