"""Saved states of one run, thinned with age: the way back is never long to replay.

The older a state is, the fewer are kept around it: of a run of any length there are a
few dozen. From the nearest one before it every moment is reached by silent replay.
"""

from __future__ import annotations

from bisect import bisect_right
from typing import NamedTuple

EVERY = 64
"""How many cycles lie between two saves at first."""

_SHARE = 12
"""A gap between saves is at most this part of their distance from now, then."""


class Moment(NamedTuple):
    """A place in a run: after a cycle, and after so many acts of the host in all."""

    cycle: int
    acts: int = 0


class Saves:
    """The saved states of a run by their moments, in order."""

    def __init__(self) -> None:
        self._moments: list[Moment] = []
        self._states: list[bytes] = []

    def __len__(self) -> int:
        return len(self._moments)

    @property
    def size(self) -> int:
        """Return how many bytes all of them take."""
        return sum(map(len, self._states))

    def add(self, moment: Moment, state: bytes) -> None:
        """Keep a state of now; states of long ago may go."""
        at = bisect_right(self._moments, moment)
        if at and self._moments[at - 1] == moment:
            return
        self._moments.insert(at, moment)
        self._states.insert(at, state)
        self._thin(moment.cycle)

    def before(self, moment: Moment) -> tuple[Moment, bytes] | None:
        """Return the last state at or before a moment; None if there is none."""
        at = bisect_right(self._moments, moment)
        return None if at == 0 else (self._moments[at - 1], self._states[at - 1])

    def until(self, moment: Moment) -> Saves:
        """Return the states up to a moment, for a branch that begins there."""
        found = Saves()
        at = bisect_right(self._moments, moment)
        found._moments, found._states = self._moments[:at], self._states[:at]
        return found

    def _thin(self, now: int) -> None:
        """Let go each state without which the gap around it is small for its age."""
        moments, states = self._moments, self._states
        kept_moments, kept_states = moments[:1], states[:1]
        for at in range(1, len(moments)):
            last = at + 1 == len(moments)
            gap = 0 if last else moments[at + 1].cycle - kept_moments[-1].cycle
            if last or gap > max(EVERY, (now - moments[at].cycle) // _SHARE):
                kept_moments.append(moments[at])
                kept_states.append(states[at])
        self._moments, self._states = kept_moments, kept_states
