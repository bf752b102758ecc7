"""What a compiled query does, step by step, told to a person.

The writers of generated code note each step as they write it, so what is told is what
is done; `rapc.compiler.explain` puts it in words.
"""

from __future__ import annotations

from enum import Enum

import msgspec

from rapc.ir import nodes


class AccessPath(Enum):
    """How a part of a formula is worked off."""

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
    """One part of a formula, and how it is worked off.

    `depth` counts the `or` and `not` it stands in. `by` are the places of the
    arguments that facts are looked up by, from 1; `tested` those of arguments that
    are known and compared; `binds` the variables that have a value after it.
    `default` is what a property has without a fact, None where none may answer.
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
        """Return how many facts are looked at: 0, 1, or None where memory decides."""
        return _MOST.get(self.way)


_MOST = {
    AccessPath.MEMBER: 1,
    AccessPath.VALUE: 1,
    AccessPath.TEST: 0,
    AccessPath.NEVER: 0,
}
