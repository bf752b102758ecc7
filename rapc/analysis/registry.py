"""The checks and their rules.

A module of checks is imported when one of its rules is enabled. Before a library is
run, only errors count, and only the modules that find errors are imported.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cache
from importlib import import_module
from types import MappingProxyType

from rapc.analysis import suppressions
from rapc.analysis.check import Check
from rapc.base.diagnostics import Rule, Severity
from rapc.library import library, loader
from rapc.parser.rules import table as parser

_WITH_ERRORS = (
    "kinds",
    "names",
    "order_and_until",
    "otherwise",
    "plans",
    "query_circles",
    "resources",
    "results",
    "tests",
    "variables",
)
"""The modules with a rule that finds errors."""

_OTHERS = (
    "agendas",
    "claims",
    "conditions",
    "constants",
    "goals",
    "left_out",
    "letters",
    "loops",
    "monitors",
    "nets",
    "protections",
    "required_files",
    "settled",
    "skills",
    "times",
    "unknown_values",
    "unused",
)


@cache
def checks(*, errors_only: bool = False) -> tuple[Check, ...]:
    """Return all checks, or only those of the modules that find errors."""
    modules = _WITH_ERRORS if errors_only else (*_WITH_ERRORS, *_OTHERS)
    return tuple(
        one
        for name in modules
        for one in vars(import_module(f"rapc.analysis.checks.{name}")).values()
        if isinstance(one, Check)
    )


@cache
def rules(*, errors_only: bool = False) -> Mapping[str, Rule]:
    """Return the rules of checks, reading and linking by name, in order of codes.

    Args:
        errors_only: leave out the rules about suppressions, and the rules of modules
            that find no errors.
    """
    every = [rule for one in checks(errors_only=errors_only) for rule in one.rules]
    every += (*parser.RULES, *library.RULES, *loader.RULES)
    if not errors_only:
        every += suppressions.RULES
    every.sort(key=lambda rule: rule.code)
    return MappingProxyType({rule.name: rule for rule in every})


@cache
def errors() -> frozenset[str]:
    """Return the names of the rules that prevent a library from running."""
    every = rules(errors_only=True).values()
    found = (r for r in every if r.severity is Severity.ERROR and not r.opt_in)
    return frozenset(rule.name for rule in found)


def are_errors(enabled: Collection[str]) -> bool:
    """Return whether all given rules prevent a library from running."""
    return errors().issuperset(enabled)


def checks_for(enabled: Collection[str]) -> list[Check]:
    """Return the checks of the enabled rules."""
    among = checks(errors_only=are_errors(enabled))
    return [one for one in among if any(rule.name in enabled for rule in one.rules)]
