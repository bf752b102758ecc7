"""Which passes there are: the one list of them, and of all rules.

A new pass is a file in `rapc/analysis/passes` and a line here. The order of the list
does not matter: a pass runs when it is wanted, or when another asks for its result.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from rapc.analysis import (
    census,
    effects,
    index,
    inferred_kinds,
    named,
    places,
    suppressions,
)
from rapc.analysis.analyzer import Analyzer
from rapc.analysis.passes import (
    age_in_monitor,
    agenda_bands,
    anonymous_variable,
    bindings,
    constants,
    constraints,
    contradictions,
    crossed_claims,
    data,
    dead_case,
    declared_effects,
    explained,
    fact_arity,
    facts,
    failures,
    freshness,
    functions,
    hopeless,
    idle_loops,
    idle_resources,
    impossible_row,
    joined,
    kinds,
    leftovers,
    marked_constant,
    missing_require,
    misspelt_variable,
    needs_itself,
    never_holds,
    not_a_number,
    nothing_awaited,
    otherwise,
    outputs,
    own_results,
    primitives,
    query_circles,
    resource_as_value,
    resources,
    rivals,
    said_twice,
    settled,
    settled_comparison,
    signals,
    singletons,
    skill_use,
    standing,
    swapped_arguments,
    task_nets,
    threats,
    times,
    unbindable_output,
    unbound_variable,
    undeclared_predicate,
    unknown_agenda,
    unknown_event,
    unknown_method,
    unknown_rap,
    unknown_result,
    unnamed_item,
    until,
    unused_claim,
    vain_protection,
    worldless,
)
from rapc.base.diagnostics import Rule
from rapc.library import library, loader
from rapc.parser.rules import table as parser

ANALYZERS: tuple[Analyzer[Any], ...] = (
    index.INDEX,
    index.USES,
    named.MISUSES,
    places.PLACES,
    census.CENSUS,
    inferred_kinds.INFERRED,
    explained.EXPLAINED,
    task_nets.TASK_NETS,
    bindings.BINDINGS,
    unbound_variable.ANALYZER,
    unknown_rap.ANALYZER,
    undeclared_predicate.ANALYZER,
    fact_arity.ANALYZER,
    functions.ANALYZER,
    primitives.ANALYZER,
    unknown_result.ANALYZER,
    unnamed_item.ANALYZER,
    signals.ANALYZER,
    singletons.ANALYZER,
    data.ANALYZER,
    unbindable_output.ANALYZER,
    misspelt_variable.ANALYZER,
    anonymous_variable.ANALYZER,
    resources.ANALYZER,
    said_twice.ANALYZER,
    resource_as_value.ANALYZER,
    unknown_method.ANALYZER,
    unknown_event.ANALYZER,
    until.ANALYZER,
    age_in_monitor.ANALYZER,
    not_a_number.ANALYZER,
    nothing_awaited.ANALYZER,
    otherwise.ANALYZER,
    outputs.ANALYZER,
    own_results.ANALYZER,
    query_circles.ANALYZER,
    kinds.ANALYZER,
    joined.ANALYZER,
    declared_effects.ANALYZER,
    impossible_row.ANALYZER,
    unused_claim.ANALYZER,
    vain_protection.ANALYZER,
    unknown_agenda.ANALYZER,
    contradictions.ANALYZER,
    never_holds.ANALYZER,
    settled.ANALYZER,
    settled_comparison.ANALYZER,
    times.ANALYZER,
    needs_itself.ANALYZER,
    swapped_arguments.ANALYZER,
    constants.ANALYZER,
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
    worldless.ANALYZER,
)
"""Every pass."""


@cache
def rules() -> Mapping[str, Rule]:
    """Every rule that `check` may report, by name, in the order of their codes."""
    own = [rule for analyzer in ANALYZERS for rule in analyzer.rules]
    others = (*parser.RULES, *library.RULES, *loader.RULES, *suppressions.RULES)
    everything = sorted([*own, *others], key=lambda rule: rule.code)
    return MappingProxyType({rule.name: rule for rule in everything})
