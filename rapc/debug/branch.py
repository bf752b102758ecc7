"""Branches: the courses that a run has taken under the hands of its user."""

from __future__ import annotations

from rapc.debug.acts import Act
from rapc.debug.saves import Moment, Saves


class Branch:
    """One course of a run: what the user did in it, and how far it has been seen."""

    def __init__(self, name: str, saves: Saves, begun: str = "") -> None:
        self.name = name
        #: Which branch it comes from, and where, in words; empty for the first.
        self.begun = begun
        #: What was done, each with the cycle after which it was done.
        self.acts: list[tuple[int, Act]] = []
        self.saves = saves
        #: The furthest moment that was reached.
        self.end = Moment(0)
        #: Where the user was when another branch was taken up.
        self.left = Moment(0)

    def acts_by(self, cycle: int) -> int:
        """Return how many acts have been done by the end of a cycle."""
        return sum(1 for done, _ in self.acts if done <= cycle)
