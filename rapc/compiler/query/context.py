"""What compiled queries and terms ask of a run: its memory, and the task that asks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol

from rapc.base.resources import Value
from rapc.base.values import Fact, Number

Bindings = Mapping[str, Value]


class QuestionContext(Protocol):
    """What generated code asks of memory and of the task whose clause it is."""

    #: How often a question may go back, and how often the one at hand still may.
    most_steps: int
    steps_left: int

    @property
    def facts(self) -> Any:
        """The facts by name: `rapc.runtime.memory.facts.FactStore`."""

    @property
    def functions(self) -> Mapping[str, Callable[..., Any]]:
        """The registered functions."""

    @property
    def view(self) -> object:
        """Memory to be read, as functions are given it."""

    def fault(self, where: str, what: str) -> None:
        """Trace that a clause met an unbound variable or an ill-typed value."""

    def give_up(self, where: str) -> None:
        """Trace that a question went back too often in vain [L 2.70]."""

    def young(self, stamp: Number, limit: Number) -> bool:
        """Whether a fact with that stamp is younger than `limit` time units."""

    def age(self, stamp: Number) -> Number:
        """Time units since a stamp."""

    def is_here(self, fact: Fact | None, place: object) -> bool:
        """Whether `place` is `external` and a location fact says it of an item."""

    def facts_at(self, place: object) -> Iterator[Fact]:
        """Location facts of a place, `external` among them, oldest first."""

    def method_tried(self, name: object) -> bool:
        """Whether the task has tried a method of that name."""

    def last_result(self, method: object = None) -> str | None:
        """The result of the last method, or of the last one so named, or None."""

    def accessible_items(self) -> Sequence[str]:
        """The items with a sensor name, in the order of introduction."""

    def is_accessible(self, item: object) -> bool:
        """Whether an item has a sensor name."""

    def count(self, kind: object, place: object) -> Number:
        """Return how many items of a class memory holds at a place."""
