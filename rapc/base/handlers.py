"""Handlers, which turn results and data into changes of memory [T 3.3].

Authors of worlds import the names from `rapc.world`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import msgspec

from rapc.base.messages import Time
from rapc.base.values import Atom, Fact


class AskedMemory(Protocol):
    """The interface through which a problem solver queries memory."""

    def query(self, *pattern: Atom | None) -> list[Fact]:
        """Return the facts that match, oldest first; None matches any value.

        Defaults are not used.
        """


class HandlerMemory(AskedMemory, Protocol):
    """The operations of a handler on memory (T A.3 to A.5).

    Facts are tuples of a declared name and atoms; symbols are `str`, strings of the
    language `rapc.base.values.Text`. All methods take memory names of items.
    """

    @property
    def now(self) -> Time:
        """The time of the clock."""

    @property
    def place(self) -> Atom | None:
        """The robot's own place: the argument of the last `arrive`."""

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact with all its arguments; a property replaces its old value.

        Raises:
            ValueError: for an undeclared name, a wrong number of arguments, a
                built-in name, or an item's location and introducing class.
        """

    def erase(self, *prefix: Atom) -> None:
        """Erase each fact that starts with `prefix`; ValueError as `assert_fact`."""

    def value(self, *index: Atom) -> Atom | None:
        """Return the asserted value of a property for an index, or None."""

    def ask(
        self, formula: str, given: Mapping[str, Atom] | None = None
    ) -> list[dict[str, Any]]:
        """Return all solutions of a formula of the language, in their order.

        A solution maps variable names, with question marks, to values; the variables
        in `given` are left out. A true formula without variables has one empty
        solution. The formula is evaluated as in a clause, with defaults and named
        queries. An error in the formula, for example an unbound variable, is traced,
        and there is no solution. The formula is compiled once, at the first call:
        values that change between calls belong in `given`.

        Raises:
            ValueError: for a text that is not a formula, or has a name that the library
                does not declare.
        """

    def introduce(self, sensor_name: str, kind: str, place: Atom) -> str:
        """Make an item that is seen accessible, and return its memory name.

        Asserts `(class item kind true)` and `(location item place)`. If the item is
        accessible already, it stays the same item; a different place is a move. The
        name may become an alias of an older name when the batch ends.
        """

    def move(self, item: str, place: Atom) -> None:
        """Put an accessible item at `place`; it stays accessible."""

    def lose(self, item: str) -> None:
        """Set the place of a lost item to `unknown`; the item is out of reach."""

    def fix_cardinality(self, place: Atom) -> None:
        """Declare that `place` has no items except the introduced items.

        This takes effect when the batch ends: the handler of a result may call it
        before the data are handled. Items believed at `place` and not accessible get
        the place `unknown`; of indistinct classes only the surplus items do.
        """

    def expire(self) -> None:
        """Forget all sensor names, since the robot has moved."""

    def arrive(self, place: Atom) -> None:
        """Set the place of the robot, the new meaning of `external`."""


ResultHandler = Callable[[HandlerMemory, Fact, str], str | None]
"""The handler of a primitive: `(memory, request with memory names, result symbol)`.

The interpreter uses the returned result, which must be declared, in place of the
world's result; None keeps the world's result [T 3.3.2]."""

DatumHandler = Callable[[HandlerMemory, Fact], None]
"""The handler of a datum: `(memory, datum)`, known sensor names already replaced."""


class Handlers(msgspec.Struct, frozen=True):
    """The handlers of a world package, by primitive and by datum name.

    A result or datum without a handler has its declared effects (`:on`), if the
    declaration names all facts. Otherwise the result changes nothing, and the datum is
    an error of the world package.
    """

    results: Mapping[str, ResultHandler] = {}
    data: Mapping[str, DatumHandler] = {}
