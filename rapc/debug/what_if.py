"""What would be chosen if memory were another: tried aside, and undone."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from rapc import events
from rapc.debug.acts import Act
from rapc.debug.history import History
from rapc.debug.log import ToldEvent

_TOLD = (
    events.TaskSelected,
    events.MethodChosen,
    events.TaskSucceeded,
    events.TaskFailed,
    events.TaskBlocked,
    events.TaskWoken,
    events.PrimitiveRequested,
    events.RunEnded,
)
"""The events that tell what is chosen."""


class WhatIf(msgspec.Struct, frozen=True):
    """What happens next as things stand, and what would happen."""

    as_it_is: tuple[ToldEvent, ...]
    would_be: tuple[ToldEvent, ...]

    @property
    def differs(self) -> bool:
        """Whether anything else would be done."""
        return [_key(one) for one in self.as_it_is] != [
            _key(one) for one in self.would_be
        ]


def _key(told: ToldEvent) -> tuple[object, ...]:
    return told.kind, told.time, tuple(told.keys.items())


def what_if(history: History, acts: Iterable[Act], cycles: int = 1) -> WhatIf:
    """Return what the next cycles bring, with and without some acts.

    Raises:
        Error: if an act cannot be done.
        StateError: if the run cannot be taken back in time.
    """
    return WhatIf(_next(history, (), cycles), _next(history, acts, cycles))


def _next(history: History, acts: Iterable[Act], cycles: int) -> tuple[ToldEvent, ...]:
    return tuple([o for o in history.ahead(acts, cycles) if o.kind in _TOLD])
