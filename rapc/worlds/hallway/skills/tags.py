"""Watching for all landmarks.

Not here: watching for a certain landmark and going to it, see `landmarks`.
"""

from __future__ import annotations

import math

import msgspec

from rapc.base.values import Atom
from rapc.worlds.hallway.channels import POSE, SEEN, TAGS, Tag
from rapc.worlds.skills.declarations import Event, Parameter, Ports, Skill

EACH = 1.0
"""Seconds for which each of several landmarks in view is reported."""


class TagsSeen(Event):
    """A pair of tags has come into view, of any landmark."""

    name = "tags-seen"
    inputs = (SEEN, POSE)
    carries = (
        Parameter("left", "number", "", "the code of the left tag"),
        Parameter("right", "number", "", "the code of the right tag"),
        Parameter("spread", "number", "rad", "the angle between them"),
        Parameter("heading", "number", "rad", "in the frame of dead reckoning"),
    )
    again = EACH

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return the data of the pair that has its turn, or None."""
        seen = ports[SEEN]
        if not seen:
            return None
        left, right = seen[:2]
        heading = ports[POSE].heading + between(left, right)
        spread = math.remainder(left.bearing - right.bearing, 2 * math.pi)
        heading = math.remainder(heading, 2 * math.pi)
        return left.code, right.code, round(spread, 3), round(heading, 2)


class Turns(msgspec.Struct):
    """The state of `see-tags`."""

    #: The left codes of the pairs in view; the pair that has its turn is last.
    queue: list[int] = []
    #: The start of this turn.
    since: float = 0.0


class SeeTags(Skill):
    """Watch for any landmark: an even tag and the next one.

    Those in view take turns.
    """

    name = "see-tags"
    inputs = (TAGS,)
    outputs = (SEEN,)
    events = (TagsSeen,)
    State = Turns
    state: Turns

    def step(self, now: float, ports: Ports) -> None:
        """Write the pair that has its turn, left tag first."""
        tags, state = {tag.code: tag for tag in ports[TAGS]}, self.state
        pairs = [code for code in sorted(tags) if code % 2 == 0 and code + 1 in tags]
        if not pairs:
            state.queue = []
            ports[SEEN] = ()
            return
        last = state.queue[-1:]
        waiting = [code for code in state.queue if code in pairs]
        state.queue = [code for code in pairs if code not in waiting] + waiting
        if state.queue[-1:] != last or now - state.since >= EACH - 0.05:
            state.queue.append(state.queue.pop(0))
            state.since = now
        left = state.queue[-1]
        ports[SEEN] = (tags[left], tags[left + 1])


def between(left: Tag, right: Tag) -> float:
    """Return the bearing half-way between two tags."""
    off = math.remainder(left.bearing - right.bearing, 2 * math.pi)
    return right.bearing + off / 2
