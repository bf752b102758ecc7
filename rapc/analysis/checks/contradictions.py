"""RAP110: formulas that never hold, whatever happens.

A conjunction is taken apart into literals (`rapc.analysis.facts.logic`), of which two
never hold together; each branch of an `or` is asked with what stands around it.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from typing import NamedTuple

from rapc.analysis.check import Fact, Pass, check
from rapc.analysis.facts.bindings import Bound, whole_formulas
from rapc.analysis.facts.logic import Clash, Conjunction, Literal, literals, may_clash
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import variable_names

CONTRADICTION = Rule(
    code="RAP110",
    name="contradiction",
    severity=Severity.WARNING,
    summary="two parts of a formula never hold together",
    why="""A property has one value at a time; what is asked cannot be denied as well;
no number is below 3 and above 5. A conjunction, or a branch of an `or`, with two such
parts never holds, whatever happens: mostly `or` was meant, or one of the two speaks of
another thing (T 4.1).""",
    ignore="where a method is switched off on purpose: write `nil` as its context",
    source="T 4.1.3",
    example="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (go-through ?door))
(define-rap (pass ?door)
  (method
    (context (and (door-state ?door open) (door-state ?door ajar)))
    (task-net (t1 (go-through ?door)))))
""",
    better="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (go-through ?door))
(define-rap (pass ?door)
  (method
    (context (or (door-state ?door open) (door-state ?door ajar)))
    (task-net (t1 (go-through ?door)))))
""",
)


class Contradiction(NamedTuple):
    """A formula of a clause that never holds, and what in it contradicts what."""

    formula: nodes.Formula
    clash: Clash


def _run(run: Pass) -> Sequence[Contradiction]:
    return [
        Contradiction(formula, clash)
        for form in run.library.forms
        for formula, given in whole_formulas(form, run.library.functions)
        for clash in _contradictions(run, formula, given)
    ]


CONTRADICTIONS = Fact(_run)
"""The contradictions in clauses, in the order of the text."""


@check(CONTRADICTION, needs_whole="form")
def contradictions(run: Pass) -> Iterable[Diagnostic]:
    """Find formulas that never hold, whatever happens."""
    every = run.result(CONTRADICTIONS)
    return one_for_each_place(_contradiction(one.clash) for one in every)


def one_for_each_place(found: Iterable[Diagnostic]) -> Iterable[Diagnostic]:
    """Return the first finding at each place."""
    first: dict[Span, Diagnostic] = {}
    for one in found:
        first.setdefault(one.span, one)
    return first.values()


def clash_at(rule: Rule, message: str, span: Span, label: Label) -> Diagnostic:
    """Return a finding with a label, unless that is about the same place."""
    return rule.at(span, message, labels=(label,) if label.span != span else ())


class _Asked(NamedTuple):
    """A formula with what is asked together with it."""

    formula: nodes.Formula
    #: The variables that may have values before all of that.
    given: Container[str]
    before: Sequence[Literal] = ()
    behind: Sequence[Literal] = ()


def _contradictions(
    run: Pass, formula: nodes.Formula, given: Container[str]
) -> Iterator[Clash]:
    """Yield what never holds in a formula.

    Args:
        run: the pass.
        formula: the formula.
        given: the variables that may have values before it is asked.
    """
    if not isinstance(formula, _JOINED):
        return
    waiting = [_Asked(formula, given)]
    while waiting:
        here = waiting.pop()
        own = list(literals(here.formula))
        after = [*own, *here.behind]
        clash = first_clash(run, here.before, after, here.given)
        if clash is not None:
            if any(clash.second is one for one in here.behind):
                clash = Clash(clash.second, clash.first)
            if any(clash.second is one for one in own):
                yield clash
            continue
        for at, literal in enumerate(own):
            inner = literal.formula
            if not isinstance(inner, _JOINED):
                continue
            before = [*here.before, *own[:at]]
            if literal.holds:
                asked = _Asked(inner, here.given, before, after[at + 1 :])
            else:
                asked = _Asked(inner, _bound_by(here.given, before))
            parts = inner.parts if isinstance(inner, nodes.Or) else (inner,)
            waiting += [asked._replace(formula=part) for part in reversed(parts)]


def _bound_by(given: Container[str], before: Iterable[Literal]) -> Container[str]:
    """The variables that may have values behind some literals."""
    held = [set(variable_names(one.formula)) for one in before if one.holds]
    return Bound(given, set().union(*held)) if held else given


_JOINED = (nodes.And, nodes.Or, nodes.Not)
"""What other formulas are put together by."""


def first_clash(
    run: Pass,
    held: Sequence[Literal],
    own: Sequence[Literal],
    given: Container[str],
) -> Clash | None:
    """Return the first of some literals that contradicts another.

    Args:
        run: the run of the pass.
        held: literals that hold, and do not contradict each other.
        own: the literals that are put to them, one after another.
        given: the variables that may have values before all of them.
    """
    if not may_clash([*held, *own]):
        return None
    made = Conjunction(run.signatures.relations, given)
    for literal in held:
        made.add(literal)
    for literal in own:
        clash = made.add(literal)
        if clash is not None:
            return clash
    return None


def _contradiction(clash: Clash) -> Diagnostic:
    return clash_at(
        CONTRADICTION,
        f"{said(clash.second)} and {said(clash.first)} never hold together",
        clash.second.span,
        Label(clash.first.span, "asked here" if clash.first.holds else "denied here"),
    )


def said(literal: Literal) -> str:
    """Return what a literal says, shortened, in back-ticks."""
    text = format_formula(literal.formula)
    if len(text) > _LONG:
        text = text[:_LONG] + "..."
    return f"`{text}`" if literal.holds else f"`(not {text})`"


_LONG = 50
"""How many letters of a formula are told."""
