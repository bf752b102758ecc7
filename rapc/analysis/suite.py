"""Which passes there are: the one list of them, and of all rules.

A new pass is a file in `rapc/analysis/passes` and a line here; one that finds errors is
listed in `rapc.analysis.grave`, with all that it needs. The order of the list does not
matter: a pass runs when it is wanted, or when another asks for its result.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

from rapc.analysis import effects, grave, suppressions
from rapc.analysis.analyzer import Analyzer
from rapc.analysis.passes import (
    age_in_monitor,
    agenda_bands,
    constraints,
    contradictions,
    crossed_claims,
    dead_case,
    declared_effects,
    facts,
    failures,
    freshness,
    hopeless,
    idle_loops,
    idle_resources,
    joined,
    leftovers,
    marked_constant,
    missing_require,
    misspelt_variable,
    needs_itself,
    never_holds,
    nothing_awaited,
    own_results,
    rivals,
    said_twice,
    settled,
    settled_comparison,
    singletons,
    skill_use,
    standing,
    swapped_arguments,
    threats,
    times,
    unbindable_output,
    unnamed_item,
    until,
    unused_claim,
    vain_protection,
)
from rapc.base.diagnostics import Rule

ANALYZERS: tuple[Analyzer[Any], ...] = (
    *grave.ANALYZERS,
    unnamed_item.ANALYZER,
    singletons.ANALYZER,
    unbindable_output.ANALYZER,
    misspelt_variable.ANALYZER,
    said_twice.ANALYZER,
    until.ANALYZER,
    age_in_monitor.ANALYZER,
    nothing_awaited.ANALYZER,
    own_results.ANALYZER,
    joined.ANALYZER,
    declared_effects.ANALYZER,
    unused_claim.ANALYZER,
    vain_protection.ANALYZER,
    contradictions.ANALYZER,
    never_holds.ANALYZER,
    settled.ANALYZER,
    settled_comparison.ANALYZER,
    times.ANALYZER,
    needs_itself.ANALYZER,
    swapped_arguments.ANALYZER,
    rivals.ANALYZER,
    skill_use.ANALYZER,
    standing.ANALYZER,
    dead_case.ANALYZER,
    effects.EFFECTS,
    hopeless.ANALYZER,
    idle_resources.ANALYZER,
    agenda_bands.ANALYZER,
    threats.ANALYZER,
    constraints.ANALYZER,
    crossed_claims.ANALYZER,
    leftovers.ANALYZER,
    marked_constant.ANALYZER,
    idle_loops.ANALYZER,
    facts.ANALYZER,
    failures.ANALYZER,
    freshness.ANALYZER,
    missing_require.ANALYZER,
)
"""Every pass."""


@cache
def rules() -> Mapping[str, Rule]:
    """Every rule that `check` may report, by name, in the order of their codes."""
    return grave.rules_with(ANALYZERS, suppressions.RULES)
