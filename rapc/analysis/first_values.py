"""What a formula says of resources before anything has changed them.

A set without a beginning is empty when its task begins, a counter stands at its number,
at 0 if none is given (T 4.8.1). Nothing but what the task's methods ask for changes
them, so what has to hold before the first method is asked of these values.
"""

from __future__ import annotations

from collections.abc import Iterable

from rapc.analysis.literals import Literal, holds_between, literals, number_of
from rapc.base.values import Number
from rapc.ir import nodes


class FirstValues:
    """The values of the resources of one RAP as its task begins.

    Args:
        resources: what the RAP declares; those that begin as another one are not known.
    """

    def __init__(self, resources: Iterable[nodes.Resource]) -> None:
        self._counters: dict[str, Number] = {}
        self._sets: set[str] = set()
        for one in resources:
            first = 0 if one.initial is None else number_of(one.initial)
            if one.kind == "counter" and first is not None:
                self._counters[one.variable.name] = first
            elif one.kind == "set" and one.initial is None:
                self._sets.add(one.variable.name)

    def fails(self, formula: nodes.Formula | None) -> Literal | None:
        """Return a literal of a conjunction that does not hold at first, if any."""
        if not self._counters and not self._sets:
            return None
        for literal in literals(formula):
            if self._holds(literal) is False:
                return literal
        return None

    def holds(self, formula: nodes.Formula) -> bool:
        """Whether all parts of a conjunction are about resources, and hold at first."""
        if not self._counters and not self._sets:
            return False
        found = [self._holds(literal) for literal in literals(formula)]
        return bool(found) and all(one is True for one in found)

    def _holds(self, literal: Literal) -> bool | None:
        formula, value = literal.formula, None
        if isinstance(formula, nodes.SetTest) and formula.args:
            if self._is_empty(formula.args[0]):
                value = formula.test == "empty"
        elif isinstance(formula, nodes.Compare):
            left, right = self._number(formula.left), self._number(formula.right)
            if left is not None and right is not None:
                value = holds_between(formula.op, left, right)
        return value if value is None else value is literal.holds

    def _is_empty(self, term: nodes.Term) -> bool:
        return isinstance(term, nodes.Var) and term.name in self._sets

    def _number(self, term: nodes.Term) -> Number | None:
        if not isinstance(term, nodes.Call) or len(term.args) != 1:
            return number_of(term)
        (arg,) = term.args
        if not isinstance(arg, nodes.Var):
            return None
        if term.function == "size-of":
            return 0 if self._is_empty(arg) else None
        return self._counters.get(arg.name) if term.function == "value" else None
