"""What-if: run some cycles with changed memory, then undo."""

from __future__ import annotations

from collections.abc import Iterable

from rapc import events
from rapc.debug.acts import Act, AssertFact, EraseFacts
from rapc.debug.answer import Answer, question, say
from rapc.debug.arguments import Arguments, read_pattern, split
from rapc.debug.history import History
from rapc.debug.log import ToldEvent, in_lines
from rapc.errors import TextError

_OF_CHOICES = (
    *(events.TaskSelected, events.MethodChosen, events.TaskSucceeded),
    *(events.TaskFailed, events.TaskBlocked, events.TaskWoken),
    *(events.PrimitiveRequested, events.RunEnded),
)
"""The events of choices."""


@question(
    "(assert FACT) | (erase PREFIX) ... [CYCLES]",
    ":what-if (assert (truck-fuel 2))",
    ":what-if (erase (color item-1)) 5",
)
def what_if(history: History, args: Arguments) -> Answer:
    """Show the next cycles with changed memory, then undo the change.

    The default is 1 cycle.
    """
    acts: list[Act] = []
    cycles = 1
    for said in args.rest():
        if said.isdecimal():
            cycles = int(said)
        else:
            acts.append(_act(said))
    if not acts:
        raise TextError("missing (assert FACT) or (erase PREFIX)")
    now, then = ahead(history, (), cycles), ahead(history, acts, cycles)
    if [(o.kind, o.time, o.keys) for o in now] == [
        (o.kind, o.time, o.keys) for o in then
    ]:
        return say("no difference:", *_lines(now))
    return say("actual:", *_lines(now), "with the change:", *_lines(then))


def ahead(history: History, acts: Iterable[Act], cycles: int) -> list[ToldEvent]:
    """Return the choices in the next cycles after given acts, then undo all.

    Raises:
        Error: if an act is impossible.
        StateError: if the run cannot go back.
    """
    told = history.ahead(acts, cycles)
    return [one for one in told if one.kind in _OF_CHOICES]


def _act(text: str) -> Act:
    """Return the act for `(assert FACT)` or `(erase PREFIX)`."""
    words = split(text[1:].rstrip().removesuffix(")"))
    makes: dict[str, type[AssertFact | EraseFacts]] = {
        "assert": AssertFact,
        "erase": EraseFacts,
    }
    if len(words) != 2 or words[0] not in makes:
        raise TextError(f"expected (assert FACT) or (erase PREFIX), not {text}")
    return makes[words[0]](read_pattern(words[1]))


def _lines(told: list[ToldEvent]) -> list[str]:
    return in_lines(told) or ["  nothing"]
