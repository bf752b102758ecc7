"""Findings about literals that contradict each other (`rapc.analysis.facts.logic`)."""

from __future__ import annotations

from collections.abc import Collection, Container, Iterable, Iterator, Sequence

from rapc.analysis.check import Pass
from rapc.analysis.facts.logic import (
    Clash,
    Conjunction,
    Literal,
    apart,
    conjunction,
    entails,
    expanded,
    fact_name,
    literals,
    may_clash,
)
from rapc.base.diagnostics import Diagnostic, Label, Rule
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import substitute, variable_names


def first_clash(
    run: Pass,
    held: Sequence[Literal],
    own: Sequence[Literal],
    given: Container[str],
) -> Clash | None:
    """Return the first of some literals that contradicts another literal.

    Args:
        run: the pass.
        held: literals that hold, and do not contradict each other.
        own: the literals that are added in order.
        given: the variables that may have values before the first literal.
    """
    relations = run.signatures.relations
    if not may_clash([*held, *own], relations):
        return None
    made = Conjunction(relations, given)
    for literal in held:
        made.add(literal)
    for literal in own:
        clash = made.add(literal)
        if clash is not None:
            return clash
    return None


def rules_out(
    run: Pass, held: Sequence[Literal], formula: nodes.Formula, given: Collection[str]
) -> bool:
    """Return whether a formula has no solution where some literals hold.

    The values of a property in the formula and in the literals are one value.
    """
    wanted = literals(apart(formula, given, "@out"))
    bound = {*given, *variable_names(*[one.formula for one in held])}
    if first_clash(run, (), held, bound) is not None:
        return False
    return any(
        first_clash(run, held, _with_values_of(run, held, there, given), bound)
        is not None
        for there in (wanted, list(expanded(run.library, wanted)))
    )


def follows_expanded(
    run: Pass, held: Sequence[Literal], formula: nodes.Formula, given: Collection[str]
) -> bool:
    """Return whether a formula surely holds, with the formulas of queries.

    The values of a property in the formula and in the literals are one value.
    """
    known = list(expanded(run.library, held))
    facts = conjunction(expanded(run.library, literals(formula)))
    found = literals(apart(facts, given, "@out"))
    wanted = _with_values_of(run, known, found, given)
    bound = {*given, *variable_names(*[one.formula for one in known])}
    relations = run.signatures.relations
    return entails(known, conjunction(wanted), bound, relations)


def may_expand(run: Pass, held: Iterable[Literal], formula: nodes.Formula) -> bool:
    """Return whether `follows_expanded` may find more than `entails`."""
    library = run.library

    def is_expanded(one: Literal) -> bool:
        name = fact_name(one)
        return isinstance(one.formula, nodes.Believe) or name in library.queries

    wanted = literals(formula)
    return any(
        is_expanded(one) or fact_name(one) in library.properties for one in wanted
    ) or any(map(is_expanded, held))


def _with_values_of(
    run: Pass,
    held: Sequence[Literal],
    wanted: Sequence[Literal],
    given: Container[str],
) -> Sequence[Literal]:
    """Return literals with the values that other literals have for properties.

    Variables in `given` keep their names.
    """
    known = _of_properties(run, held)
    values = {(fact.name, fact.args[:-1]): fact.args[-1] for fact in known}
    terms: dict[str, nodes.Term] = {}
    for fact in _of_properties(run, wanted):
        last = fact.args[-1]
        value = values.get((fact.name, fact.args[:-1]))
        if value is not None and type(last) is nodes.Var and last.name not in given:
            terms.setdefault(last.name, value)
    return [Literal(substitute(one.formula, terms), one.holds) for one in wanted]


def _of_properties(run: Pass, found: Sequence[Literal]) -> Iterator[nodes.Proposition]:
    """Yield the facts of properties that hold."""
    for one in found:
        fact = one.formula
        if not one.holds or not isinstance(fact, nodes.Proposition):
            continue
        if fact.args and fact.name in run.library.properties:
            yield fact


def clash_at(rule: Rule, message: str, span: Span, label: Label) -> Diagnostic:
    """Return a finding with a label, unless the label has the same place."""
    return rule.at(span, message, labels=(label,) if label.span != span else ())


def said(literal: Literal) -> str:
    """Return the text of a literal, shortened, in back-ticks."""
    text = format_formula(literal.formula)
    if len(text) > _SHOWN_LETTERS:
        text = text[:_SHOWN_LETTERS] + "..."
    return f"`{text}`" if literal.holds else f"`(not {text})`"


_SHOWN_LETTERS = 50
"""The maximum number of letters of a formula in a message."""
