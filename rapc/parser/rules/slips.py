"""Rules about published slips: invalid notations with a clear meaning."""

from __future__ import annotations

from rapc.base.diagnostics import Rule

SLIP_RULES: tuple[Rule, ...] = (
    Rule(
        code="RAP050",
        name="parenthesised-times",
        summary="the times of `monitor-time` have parentheses",
        fix="safe: removes the parentheses",
        source="T 4.7.1",
    ),
    Rule(
        code="RAP051",
        name="parenthesised-for",
        summary="`for` after a formula has its own parentheses",
        fix="safe: removes the parentheses",
        source="T 4.5.2",
    ),
    Rule(
        code="RAP052",
        name="bare-for",
        summary="`for` and its tag have no parentheses",
        fix="safe: adds parentheses",
        source="T 4.5.2",
    ),
    Rule(
        code="RAP053",
        name="not-of-many",
        summary="`not` has several formulas",
        fix="unsafe: joins the formulas by `and`; `or` may be meant",
        source="T 4.1.3",
    ),
    Rule(
        code="RAP054",
        name="believe-without-time",
        summary="`believe` has no age",
        fix="unsafe: binds the age to a variable, which matches a belief of any age",
        source="T 4.1.1",
    ),
    Rule(
        code="RAP055",
        name="bare-rule",
        summary="the query and the actions of a rule have no parentheses",
        fix="safe: adds parentheses",
        source="S 4.2",
    ),
)
