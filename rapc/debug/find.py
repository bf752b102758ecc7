"""Search for an event through the whole run, back and forth."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import msgspec

from rapc import events
from rapc.base.names import hint
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.errors import TextError
from rapc.events import Event
from rapc.runtime.events.trace import record


class Finder(msgspec.Struct, frozen=True):
    """What an event is to be like."""

    kind: type[Event]
    #: Keys of the trace with the values that they must have, as text.
    keys: tuple[tuple[str, str], ...]
    #: Words that must occur in its values.
    words: tuple[str, ...]

    @classmethod
    def of(cls, kind: str, said: Iterable[str]) -> Finder:
        """Return what a search is made of.

        Raises:
            TextError: for a kind of events that there is not, or a key of it.
        """
        known = events.kinds()
        if kind not in known:
            raise TextError(f"there are no events `{kind}`{hint(kind, known)}")
        keys, words = [], []
        has = known[kind].__struct_encode_fields__
        for one in said:
            key, equals, value = one.partition("=")
            if equals and not one.startswith("("):
                if key not in has:
                    listed = ", ".join(name for name in has)
                    raise TextError(f"`{kind}` has no `{key}`; it has {listed}")
                keys.append((key, value))
            else:
                words.append(one)
        return cls(known[kind], tuple(keys), tuple(words))

    def fits(self, told: ToldEvent) -> bool:
        """Whether an event is one that is looked for."""
        if told.kind is not self.kind:
            return False
        if not (self.keys or self.words):
            return True
        values = record(told.event())
        if any(str(values.get(key)) != value for key, value in self.keys):
            return False
        text = " ".join(str(value) for value in values.values())
        return all(word in text for word in self.words)


def is_before(history: History, finder: Finder) -> Callable[[ToldEvent], bool]:
    """Return whether an event is one that a search backwards finds from here.

    At the end of a run the last cycle is a moment before it.
    """
    end = history.cycle + history.over
    return lambda told: told.cycle < end and finder.fits(told)


def find_event(
    history: History, finder: Finder, *, back: bool = False
) -> ToldEvent | None:
    """Go to the cycle of the next event that fits, or of the last one before.

    Where none is found the history stands where it stood, or at the end of the run if
    it cannot be taken back. Breakpoints do not matter meanwhile.

    Raises:
        StateError: if the run cannot be taken back in time and has to be.
    """
    if back:
        found = history.last(finder.kind, want=is_before(history, finder))
        if found is not None:
            history.goto(found.cycle)
        return found
    return history.seek(finder.kind, want=finder.fits)
