"""The context of compiled queries and terms: memory, and the querying task."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol

from rapc.base.resources import Value
from rapc.base.values import Fact, Number

Bindings = Mapping[str, Value]


class QuestionContext(Protocol):
    """Access of generated code to memory and to the task of the clause."""

    #: The limit of steps back of a query, and the rest for the present query.
    most_steps: int
    steps_left: int

    @property
    def facts(self) -> Any:
        """Return the facts by name: `rapc.runtime.memory.facts.FactStore`."""

    @property
    def functions(self) -> Mapping[str, Callable[..., Any]]:
        """Return the registered functions."""

    @property
    def view(self) -> object:
        """Return the read-only memory that functions receive."""

    def fault(self, where: str, what: str) -> None:
        """Trace that a clause met an unbound variable or an ill-typed value."""

    def give_up(self, where: str) -> None:
        """Trace that a query exceeded its limit of steps back [L 2.70]."""

    def young(self, stamp: Number, limit: Number) -> bool:
        """Return whether a fact with that stamp is younger than `limit` time units."""

    def age(self, stamp: Number) -> Number:
        """Return the time units since a stamp."""

    def is_here(self, fact: Fact | None, place: object) -> bool:
        """Return whether `place` is `external` and an item has that location."""

    def facts_at(self, place: object) -> Iterator[Fact]:
        """Return the location facts of a place, including `external`, oldest first."""

    def method_tried(self, name: object) -> bool:
        """Return whether the task has tried a method of that name."""

    def last_result(self, method: object = None) -> str | None:
        """Return the result of the last method, or of the named one, or None."""

    def accessible_items(self) -> Sequence[str]:
        """Return the items with a sensor name, in the order of introduction."""

    def is_accessible(self, item: object) -> bool:
        """Return whether an item has a sensor name."""

    def count(self, kind: object, place: object) -> Number:
        """Return how many items of a class memory holds at a place."""
