"""Handlers: what turns results and data into changes of memory [T 3.3].

Authors of worlds have them from `rapc.world`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import msgspec

from rapc.base.messages import Time
from rapc.base.values import Atom, Fact


class AskedMemory(Protocol):
    """Memory, as far as a problem solver asks it."""

    def query(self, *pattern: Atom | None) -> list[Fact]:
        """The facts that match, oldest first; None matches anything.

        Defaults are not consulted.
        """


class HandlerMemory(AskedMemory, Protocol):
    """What a handler may do to memory (T A.3 to A.5).

    Facts are tuples of a declared name and atoms; symbols are `str`, strings of the
    language `rapc.base.values.Text`. All methods take memory names of items.
    """

    @property
    def now(self) -> Time:
        """The time of the clock."""

    @property
    def place(self) -> Atom | None:
        """The robot's own place: the one last given to `arrive`."""

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact now, all arguments stated; a property replaces its old value.

        Raises:
            ValueError: for an undeclared name, a wrong number of arguments, a
                built-in name, or an item's location and introducing class.
        """

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts so. Raises ValueError as `assert_fact`."""

    def value(self, *index: Atom) -> Atom | None:
        """The asserted value of a property for an index, or None."""

    def ask(
        self, formula: str, given: Mapping[str, Atom] | None = None
    ) -> list[dict[str, Any]]:
        """All answers to a formula of the language, in the order in which it has them.

        An answer holds the values of the variables by their names with question marks,
        those in `given` left out; a formula without variables that holds has one
        answer, an empty one. The formula is asked as a clause asks it, with defaults
        and named queries; a fault in it, an unbound variable say, is traced, and
        there is no answer. It is made ready once, when it is asked for the first time:
        what differs from one time to another belongs in `given`.

        Raises:
            ValueError: for a text that is no formula, or names what the library does
                not declare.
        """

    def introduce(self, sensor_name: str, kind: str, place: Atom) -> str:
        """Make an item that is seen accessible, and return its memory name.

        Asserts `(class item kind true)` and `(location item place)`. Seen again
        while accessible it is the same item; another place is a move. The name may
        become an alias of an older one when the batch ends.
        """

    def move(self, item: str, place: Atom) -> None:
        """Put an accessible item at `place`; it stays accessible."""

    def lose(self, item: str) -> None:
        """Set the place of an item that is gone to `unknown`; it is out of reach."""

    def fix_cardinality(self, place: Atom) -> None:
        """Tell memory that no items are at `place` but those that were introduced.

        This takes effect when the batch ends, so a result's handler may say it before
        the data are handled. Items believed there and not accessible get place
        `unknown`; of indistinct classes as many as are too many.
        """

    def expire(self) -> None:
        """Forget all sensor names, since the robot has moved."""

    def arrive(self, place: Atom) -> None:
        """Set the place of the robot, of which `external` speaks from now on."""


ResultHandler = Callable[[HandlerMemory, Fact, str], str | None]
"""Called with memory, the request (memory names) and the result symbol.

What it returns, unless None, is the result that the interpreter sees: another one of
those that are declared [T 3.3.2]."""

DatumHandler = Callable[[HandlerMemory, Fact], None]
"""Called with memory and the datum, known sensor names already replaced."""


class Handlers(msgspec.Struct, frozen=True):
    """The handlers of a world package, by primitive and by datum name.

    A primitive without a handler changes nothing; a datum without one is an error
    of the world package.
    """

    results: Mapping[str, ResultHandler] = {}
    data: Mapping[str, DatumHandler] = {}
