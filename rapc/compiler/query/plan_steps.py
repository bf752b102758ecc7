"""Steps of a compiled query, for explanations.

The writers of generated code record each step while they write it, so the explanation
equals the execution; `rapc.compiler.explain` formats the steps.
"""

from __future__ import annotations

from enum import Enum

import msgspec

from rapc.ir import nodes


class AccessPath(Enum):
    """The access path of a part of a formula."""

    MEMBER = "look whether it is in memory"
    VALUE = "look up the value"
    INDEX = "run through an index"
    SMALLEST = "run through the smallest of some indexes"
    ALL = "run through all facts"
    TEST = "test"
    ITEMS = "run through the items within reach"
    EITHER = "each branch in turn"
    NEITHER = "there is no solution of"
    LATER = "compiled when it is asked, for what then is bound"
    NAMED = "what the query says"
    OTHERWISE = "look whether a method before this one holds"
    NEVER = "never holds"


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
    default: str | None = None

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
