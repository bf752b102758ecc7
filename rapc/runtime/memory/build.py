"""A memory put together: facts, exclusions, recognition and the handlers' way in."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from rapc.base.values import Atom
from rapc.library.library import Library
from rapc.library.signatures import Signatures
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.gate import Gate
from rapc.runtime.memory.memory import Memory, Observer
from rapc.runtime.memory.recognition.recognizer import MAX_LAYERS, Recognizer
from rapc.runtime.memory.recognition.scoring import Comparator, Scores
from rapc.runtime.memory.recognition.sets import ExpectationSet


class Assembled(msgspec.Struct, frozen=True):
    """The parts of a memory: `access` is what handlers are given."""

    memory: Memory
    recognizer: Recognizer
    access: Gate

    def observe(self, *others: Observer) -> None:
        """Register all that is told of changes: the recogniser, then `others`.

        The one place where observers of memory are registered; without indistinct
        classes there is nothing to recognise.
        """
        first = () if self.memory.mentions is None else (self.recognizer,)
        self.memory.observe(*first, *others)


def assemble(
    library: Library,
    signatures: Signatures,
    recorder: Recorder,
    comparators: Mapping[str, Comparator],
    max_layers: int = MAX_LAYERS,
) -> Assembled:
    """Return the memory of a linked library; nobody observes it yet.

    `comparators` holds every comparator in Python that the library names.
    """
    classes = library.indistinct
    sets: dict[tuple[str, Atom], ExpectationSet] = {}
    declared = library.properties.values()
    memory = Memory(signatures, recorder, declared, classes, sets)
    scores = Scores(classes.values(), library.comparators, comparators)
    recognizer = Recognizer(memory, recorder, tuple(classes), scores, max_layers, sets)
    gate = Gate(memory, recorder, recognizer, library.files)
    return Assembled(memory, recognizer, gate)
