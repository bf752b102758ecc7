"""Steps of a compiled query, for explanations.

The writers of generated code record each step while they write it, so the explanation
equals the execution; `rapc.compiler.explain` formats the steps.
"""

from __future__ import annotations

from enum import Enum

import msgspec

from rapc.base.values import Atom
from rapc.ir import nodes


class AccessPath(Enum):
    """The access path of a part of a formula."""

    MEMBER = "check whether the fact is in memory"
    VALUE = "look up the value"
    INDEX = "search an index"
    SMALLEST = "search the smallest of several indexes"
    ALL = "search all facts"
    TEST = "test"
    ITEMS = "search the accessible items"
    EITHER = "each branch in order"
    NEITHER = "no solution exists of"
    LATER = "compiled at evaluation, for the variables bound then"
    NAMED = "the formula of the query"
    OTHERWISE = "check whether a preceding method holds"
    NEVER = "never true"


class PlanStep(msgspec.Struct, frozen=True):
    """One part of a formula, and its access path.

    `depth` is the number of `or` and `not` around it. `by` are the places of the
    arguments that select facts, from 1; `tested` the places of known arguments that are
    compared; `binds` the variables that have a value after it. `default` is the default
    of a property, None if no default may apply.
    """

    formula: nodes.Formula
    depth: int
    way: AccessPath
    by: tuple[int, ...] = ()
    tested: tuple[int, ...] = ()
    binds: tuple[str, ...] = ()
    default: Atom | None = None

    @property
    def most(self) -> int | None:
        """Return the highest number of facts read: 0, 1, or None if it is open."""
        return _MOST.get(self.way)


_MOST = {
    AccessPath.MEMBER: 1,
    AccessPath.VALUE: 1,
    AccessPath.TEST: 0,
    AccessPath.NEVER: 0,
}
