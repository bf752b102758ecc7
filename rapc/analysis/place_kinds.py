"""The kinds of argument places: declared, or learned from the use of an input."""

from __future__ import annotations

from collections.abc import Sequence

from rapc.analysis.inferred_kinds import InferredKinds
from rapc.analysis.places import Place, place_parts
from rapc.library.signatures import Signatures


class PlaceKinds:
    """Tells of which kinds the values at argument places are, declared or learned.

    Args:
        signatures: what is declared.
        inferred: what was learned of inputs for which nothing is.
    """

    def __init__(self, signatures: Signatures, inferred: InferredKinds) -> None:
        self._tables = {
            "RAP": signatures.raps,
            "predicate": signatures.predicates,
            "primitive": signatures.primitives,
            "datum": signatures.data,
            "skill": signatures.skills,
            "event": signatures.events,
        }
        self._inputs = inferred.inputs
        self._known: dict[Place, str | None] = {}

    def of(self, places: Sequence[Place]) -> tuple[str, ...]:
        """Return the kinds of places of which one is known, each once."""
        found = [self._one(place) for place in places]
        return tuple(dict.fromkeys(kind for kind in found if kind is not None))

    def _one(self, place: Place) -> str | None:
        if place not in self._known:
            self._known[place] = self._look_up(place)
        return self._known[place]

    def _look_up(self, place: Place) -> str | None:
        space, name, position = place_parts(place)
        declared = self._tables[space].get(name)
        args = declared.args if declared is not None else None
        if args is None or position >= len(args):
            return None
        kind = args[position].kind
        if kind is None and space == "RAP":
            learned = self._inputs.get(name, ())
            one = learned[position] if position < len(learned) else None
            kind = one.kind if one is not None else None
        return kind
