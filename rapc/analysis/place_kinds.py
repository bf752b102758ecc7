"""The kinds of argument places: declared, or learned from the use of an input."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from rapc.analysis.check import Fact, Pass
from rapc.analysis.inferred_kinds import INFERRED, InferredKinds
from rapc.analysis.places import Place, place_parts
from rapc.ir import nodes
from rapc.library.signatures import Signatures

Inputs = Mapping[str, tuple[str | None, ...]]
"""The kinds of the inputs of RAPs by name; RAPs of whose inputs none is known lack."""


def kinds_of_inputs(raps: Iterable[nodes.DefineRap], inferred: InferredKinds) -> Inputs:
    """Return the kinds of the inputs of some RAPs, declared or learned.

    Args:
        raps: the RAPs.
        inferred: what was learned of inputs for which no kind is declared.
    """
    found: dict[str, tuple[str | None, ...]] = {}
    for rap in raps:
        learned = inferred.inputs.get(rap.name, ())
        if rap.kinds or any(learned):
            declared = {one.variable: one.kind for one in rap.kinds}
            kinds = [one.kind if one is not None else None for one in learned]
            kinds += [None] * len(rap.inputs)  # of one defined twice fewer are learned
            pairs = zip(rap.inputs, kinds, strict=False)
            found[rap.name] = tuple([declared.get(v.name, kind) for v, kind in pairs])
    return found


class PlaceKinds:
    """Tells of which kinds the values at argument places are, declared or learned.

    Args:
        signatures: what is declared.
        inputs: the kinds of the inputs of RAPs.
    """

    def __init__(self, signatures: Signatures, inputs: Inputs) -> None:
        self.inputs = inputs
        self._tables = {
            "predicate": signatures.predicates,
            "primitive": signatures.primitives,
            "datum": signatures.data,
            "skill": signatures.skills,
            "event": signatures.events,
        }
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
        if space == "RAP":
            kinds = self.inputs.get(name, ())
            return kinds[position] if position < len(kinds) else None
        declared = self._tables[space].get(name)
        args = declared.args if declared is not None else None
        if args is None or position >= len(args):
            return None
        return args[position].kind


def _run(run: Pass) -> PlaceKinds:
    inputs = kinds_of_inputs(run.library.raps.values(), run.result(INFERRED))
    return PlaceKinds(run.signatures, inputs)


PLACE_KINDS = Fact(_run)
"""Works out of which kinds the values at argument places are."""
