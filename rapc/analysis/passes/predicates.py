"""The declared propositions, properties and functions, gathered once for all passes."""

from __future__ import annotations

from collections.abc import Mapping

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.vocabulary import Predicate, predicates


def _run(run: Pass) -> Mapping[str, Predicate]:
    return predicates(run.library)


PREDICATES = Analyzer(
    name="predicates",
    doc="Gathers the declared propositions, properties and functions by name.",
    run=_run,
)
