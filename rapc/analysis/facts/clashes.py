"""Findings about literals that contradict each other (`rapc.analysis.facts.logic`)."""

from __future__ import annotations

from collections.abc import Container, Sequence

from rapc.analysis.check import Pass
from rapc.analysis.facts.logic import Clash, Conjunction, Literal, may_clash
from rapc.base.diagnostics import Diagnostic, Label, Rule
from rapc.base.source import Span
from rapc.ir.printer import format_formula


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
