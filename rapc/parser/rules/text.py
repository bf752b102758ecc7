"""Rules of the reader about the text, independent of its meaning."""

from __future__ import annotations

from rapc.base.diagnostics import Rule

TEXT_RULES: tuple[Rule, ...] = (
    Rule(
        code="RAP001",
        name="missing-parenthesis",
        summary="a list is not closed, or the first parenthesis of a form is missing",
        fix="unsafe: closes the list where the indentation ends",
        source="T 3.1",
    ),
    Rule(
        code="RAP002",
        name="surplus-parenthesis",
        summary="unexpected closing parenthesis",
        fix="unsafe: removes the parenthesis that the indentation shows as unexpected",
        source="T 3.1",
    ),
    Rule(
        code="RAP003",
        name="unterminated-string",
        summary="a string is not closed",
        fix="unsafe: closes the string at the end of its line, before the "
        "parentheses there",
        source="L 1",
    ),
    Rule(
        code="RAP004",
        name="unterminated-comment",
        summary="a comment that begins with `#|` is not closed",
        fix="unsafe: closes the comment before the next form",
        source="L 1",
    ),
    Rule(
        code="RAP005",
        name="illegal-character",
        summary="invalid character",
        fix="safe: removes a quotation mark before a symbol or a list",
        source="L 1",
    ),
    Rule(
        code="RAP006",
        name="nested-too-deeply",
        summary="lists are nested more than 100 levels deep",
        source="L 1",
    ),
    Rule(
        code="RAP007",
        name="too-long",
        summary="a name or a number is too long",
        source="L 1",
    ),
    Rule(
        code="RAP008",
        name="malformed-number",
        summary="invalid number",
        fix="safe: writes the number that is meant, if the number is clear",
        source="L 1",
    ),
    Rule(
        code="RAP009",
        name="unknown-form",
        summary="a form at the top level is not a form of the language",
        fix="unsafe: writes the similar name, if there is one",
        source="L 1",
    ),
)
