"""The events about items of indistinct classes, as in docs/reference/trace.md."""

from __future__ import annotations

from rapc.base.values import Atom, Number
from rapc.events import ItemEvent, ItemMerged
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.recognition.departure import Collection
from rapc.runtime.memory.recognition.matching import Match
from rapc.runtime.memory.recognition.sets import Description


class ItemEvents:
    """Emits the events about items of indistinct classes."""

    def __init__(self, recorder: Recorder) -> None:
        self._recorder = recorder

    def emit(
        self,
        kind: type[ItemEvent],
        item: Description,
        place: Atom,
        other: str | None = None,
        score: Number | None = None,
        rival: Number | None = None,
    ) -> None:
        """Emit an event about an item that is at `place` now."""
        if self._recorder.on:
            self._recorder.emit(
                kind,
                item=item.name,
                sensor=item.sensor if item.accessible else None,
                kind=item.kind,
                location=place,
                with_=other,
                score=score,
                rival=rival,
            )

    def merged(self, kept: Description, match: Match) -> None:
        """Emit `item-merged`, unless one of the two descriptions was empty."""
        other = match.other if kept is match.one else match.one
        if not other.empty and kept.home is not None:
            place = kept.home.place
            self.emit(
                ItemMerged, kept, place, other.name, match.score, match.rival or None
            )

    def moved(
        self,
        kind: type[ItemEvent],
        item: Description,
        place: Atom,
        before: str,
        gone: Collection | None,
    ) -> None:
        """Emit that an item left its set.

        `before` is the item's name in the set, `gone` the collection that may contain
        it.
        """
        if gone is None or not gone.leaving:
            self.emit(kind, item, place)
            return
        named = [member.name for member in gone.leaving if member.name != item.name]
        other = before if before not in ("", item.name) else None
        other = other or next((name for name in named if name), None)
        self.emit(kind, item, place, other, gone.score, gone.rival or None)
