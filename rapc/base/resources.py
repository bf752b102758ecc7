"""Resources: the sets and counters that a task owns and passes by reference.

Resources are compared by identity. `frozen` returns the value for the futile-loop
detector and the recursion test. The interpreter decides when a resource changes
[T 4.8] [L 6.1].
"""

from __future__ import annotations

from collections.abc import Iterable

from rapc.base.values import Atom, Number, format_atom, number


class Counter:
    """A number that steps may add to and subtract from; it may go below zero."""

    __slots__ = ("value",)

    def __init__(self, value: Number = 0) -> None:
        self.value = value

    def add(self, amount: Number) -> None:
        """Add an amount (negative to subtract)."""
        self.value = number(self.value + amount)

    def frozen(self) -> tuple[str, Number]:
        """Return the value, hashable and distinct from any plain number."""
        return ("#counter", self.value)

    def __str__(self) -> str:
        return f"#counter({format_atom(self.value)})"


class SetResource:
    """A set of ground values, in the order in which they were first added."""

    __slots__ = ("members",)

    def __init__(self, members: dict[Atom, None] | None = None) -> None:
        self.members: dict[Atom, None] = dict(members or {})

    def add(self, member: Atom) -> None:
        """Add a member; a duplicate changes nothing."""
        self.members.setdefault(member)

    def remove(self, member: Atom) -> None:
        """Remove a member; a missing member is no error."""
        self.members.pop(member, None)

    def frozen(self) -> tuple[str, frozenset[Atom]]:
        """Return the value, hashable and independent of order."""
        return ("#set", frozenset(self.members))

    def __str__(self) -> str:
        return f"#set({' '.join(format_atom(m) for m in self.members)})"


Resource = Counter | SetResource

Value = Atom | Resource
"""The value of a variable."""


def frozen(values: Iterable[Value]) -> list[object]:
    """Return values for comparison: resources by their present content."""
    return [
        value.frozen() if isinstance(value, _RESOURCES) else value for value in values
    ]


_RESOURCES = (Counter, SetResource)
