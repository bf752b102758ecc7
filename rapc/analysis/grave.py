"""The passes without which no library is run: those that find errors, and their needs.

They stand apart from the others so that a run imports no more than these: it takes a
while to import all (`rapc.analysis.suite`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from rapc.analysis import (
    census,
    index,
    inferred_kinds,
    named,
    place_kinds,
    places,
)
from rapc.analysis.analyzer import Analyzer
from rapc.analysis.passes import (
    anonymous_variable,
    bindings,
    constants,
    data,
    explained,
    fact_arity,
    functions,
    impossible_row,
    kinds,
    not_a_number,
    otherwise,
    outputs,
    primitives,
    query_circles,
    resource_as_value,
    resources,
    signals,
    task_nets,
    unbound_variable,
    undeclared_predicate,
    unknown_agenda,
    unknown_event,
    unknown_method,
    unknown_rap,
    unknown_result,
    worldless,
)
from rapc.base.diagnostics import Rule, Severity
from rapc.library import library, loader
from rapc.parser.rules import table as parser

ANALYZERS: tuple[Analyzer[Any], ...] = (
    index.INDEX,
    index.USES,
    named.MISUSES,
    places.PLACES,
    place_kinds.PLACE_KINDS,
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
    signals.ANALYZER,
    data.ANALYZER,
    anonymous_variable.ANALYZER,
    resources.ANALYZER,
    resource_as_value.ANALYZER,
    unknown_method.ANALYZER,
    unknown_event.ANALYZER,
    not_a_number.ANALYZER,
    otherwise.ANALYZER,
    outputs.ANALYZER,
    query_circles.ANALYZER,
    kinds.ANALYZER,
    impossible_row.ANALYZER,
    unknown_agenda.ANALYZER,
    constants.ANALYZER,
    worldless.ANALYZER,
)
"""The passes with a rule that finds errors, and all that they need."""


def rules_with(
    analyzers: Iterable[Analyzer[Any]], more: Iterable[Rule] = ()
) -> Mapping[str, Rule]:
    """Return the rules of some passes, of reading and linking, and more, by name.

    They are in the order of their codes.
    """
    own = [rule for analyzer in analyzers for rule in analyzer.rules]
    others = (*parser.RULES, *library.RULES, *loader.RULES, *more)
    everything = sorted([*own, *others], key=lambda rule: rule.code)
    return MappingProxyType({rule.name: rule for rule in everything})


@cache
def rules() -> Mapping[str, Rule]:
    """Every rule of these passes, those that find no errors among them, by name."""
    return rules_with(ANALYZERS)


@cache
def errors() -> frozenset[str]:
    """The names of the rules that keep a library from being run."""
    grave = (r for r in rules().values() if r.severity is Severity.ERROR)
    return frozenset(rule.name for rule in grave if not rule.opt_in)
