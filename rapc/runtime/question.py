"""Questions of a host: a formula made ready once and asked of a run's memory often.

What a task asks is compiled with its RAP; here no task asks, so a question about the
history of methods has no answer (semantics 2).
"""

from __future__ import annotations

from collections.abc import Mapping

from rapc.compiler.query import Query
from rapc.ir.nodes import Formula
from rapc.resources import Value
from rapc.runtime.context import QueryContext
from rapc.runtime.machine import Machine
from rapc.runtime.renaming import with_names

Bindings = Mapping[str, Value]
"""Variables, with their question marks, and what they stand for."""


class Question:
    """A formula that can be asked again and again; made by `Interpreter.question`."""

    __slots__ = ("_aliases", "_formula", "_machine", "_query")

    def __init__(self, machine: Machine, formula: Formula) -> None:
        self._machine = machine
        self._formula = formula
        self._aliases = -1
        self._query = self._compiled()

    def holds(self, given: Bindings | None = None) -> bool:
        """Whether there is an answer, with some variables given."""
        return self.first(given) is not None

    def first(self, given: Bindings | None = None) -> dict[str, Value] | None:
        """What the first answer binds besides what is given; None without one."""
        query, context, known = self._put(given)
        asking, context.task = context.task, None
        found = query.first(context, known)
        context.task = asking
        return found

    def all(self, given: Bindings | None = None) -> list[dict[str, Value]]:
        """What each answer binds, in the order of semantics 2."""
        query, context, known = self._put(given)
        asking, context.task = context.task, None
        found = list(query.solutions(context, known))
        context.task = asking
        return found

    def _put(self, given: Bindings | None) -> tuple[Query, QueryContext, Bindings]:
        """What is asked, of whom, and what is given in the names that stand now."""
        known = given or {}
        items = self._machine.memory.items
        if items.aliases:
            known = {
                n: items.canonical(v) if isinstance(v, str) else v
                for n, v in known.items()
            }
        return self._compiled(), self._machine.context, known

    def _compiled(self) -> Query:
        """The query; made anew once items named in it have got other names."""
        items = self._machine.memory.items
        if len(items.aliases) != self._aliases:
            self._aliases = len(items.aliases)
            formula = self._formula
            if items.aliases:
                formula = with_names(formula, items.canonical)
            compiler = self._machine.library.compiler
            self._query = compiler.query(formula, "question", formula.span)
        return self._query
