"""Gathers every node of a library by its type, once for the passes that ask for it.

Finds nothing itself.
"""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.occurrences import Occurrences


def _run(run: Pass) -> Occurrences:
    occurrences = Occurrences()
    for form in run.library.forms:
        occurrences.add(form)
    return occurrences


OCCURRENCES = Analyzer(
    name="occurrences",
    doc="Gathers every node of the library by its type.",
    run=_run,
)
