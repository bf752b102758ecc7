"""Search for an event, backwards and forwards in the run."""

from __future__ import annotations

from collections.abc import Iterable

from rapc import events
from rapc.base.names import hint
from rapc.debug.history import History
from rapc.debug.log import ToldEvent, Want
from rapc.errors import TextError
from rapc.events import Event
from rapc.runtime.events.trace import record


def find_event(
    history: History, kind: str, said: Iterable[str] = (), *, back: bool = False
) -> ToldEvent | None:
    """Go to the cycle of the next or last matching event; return the event.

    If no event matches, the run returns to its present moment. If the run cannot go
    back, it stays at its end. Breakpoints do not stop the search.

    Args:
        history: the run.
        kind: the kind of the event, as in a trace.
        said: required values, `key=value` with keys of the trace, and words that must
            occur in the values.
        back: whether to search backwards.

    Raises:
        StateError: if the run must go back and cannot.
        TextError: for an unknown kind of event or an unknown key.
    """
    event_type, want = _wanted(kind, said)
    if not back:
        return history.seek(event_type, want=want)
    found = history.last(event_type, want=_before(history, want))
    if found is not None:
        history.goto(found.cycle)
    return found


def count_before(history: History, kind: str, said: Iterable[str]) -> int:
    """Return the number of events that match backwards; see `find_event`."""
    event_type, want = _wanted(kind, said)
    return sum(1 for _ in history.scan(event_type, want=_before(history, want)))


def _before(history: History, want: Want) -> Want:
    """Return a predicate: `want`, restricted to events before the present moment.

    After the end of a cycle, that cycle counts as before the present moment.
    """
    end = history.cycle + (history.over or history.between)
    return lambda told: told.cycle < end and want(told)


def _wanted(kind: str, said: Iterable[str]) -> tuple[type[Event], Want]:
    """Return the event type and the predicate of a search."""
    known = events.kinds()
    if kind not in known:
        raise TextError(f"unknown kind of event `{kind}`{hint(kind, known)}")
    keys: dict[str, str] = {}
    words: list[str] = []
    has = known[kind].__struct_encode_fields__
    for one in said:
        key, equals, value = one.partition("=")
        if not equals or one.startswith("("):
            words.append(one)
        elif key in has:
            keys[key] = value
        else:
            raise TextError(
                f"`{kind}` has no key `{key}`; its keys are {', '.join(has)}"
            )

    def want(told: ToldEvent) -> bool:
        values = {k: str(v) for k, v in record(told.event()).items()}
        text = " ".join(values.values())
        fits = all(values.get(key) == value for key, value in keys.items())
        return fits and all(word in text for word in words)

    return known[kind], want
