"""Rules of the reader about the text, independent of its meaning."""

from __future__ import annotations

from rapc.base.diagnostics import Rule

TEXT_RULES: tuple[Rule, ...] = (
    Rule(
        code="RAP001",
        name="missing-parenthesis",
        summary="a list is not closed, or a form has lost its first parenthesis",
        fix="unsafe: closes the list where the indentation says that it ends",
        source="T 3.1",
    ),
    Rule(
        code="RAP002",
        name="surplus-parenthesis",
        summary="there is a closing parenthesis too many",
        fix="unsafe: takes out the one that the indentation says is too many",
        source="T 3.1",
    ),
    Rule(
        code="RAP003",
        name="unterminated-string",
        summary="a string is not closed",
        fix="unsafe: closes it at the end of its line, before the parentheses there",
        source="L 1",
    ),
    Rule(
        code="RAP004",
        name="unterminated-comment",
        summary="a comment that begins with `#|` is not closed",
        fix="unsafe: closes it before the next form",
        source="L 1",
    ),
    Rule(
        code="RAP005",
        name="illegal-character",
        summary="a character has no place in this language",
        fix="safe: takes out a quotation mark before a symbol or a list",
        source="L 1",
    ),
    Rule(
        code="RAP006",
        name="nested-too-deeply",
        summary="lists are nested more than 100 deep",
        source="L 1",
    ),
    Rule(
        code="RAP007",
        name="too-long",
        summary="a name or a number is absurdly long",
        source="L 1",
    ),
    Rule(
        code="RAP008",
        name="malformed-number",
        summary="something looks like a number and is none",
        fix="safe: writes the number that is meant, where it can be told",
        source="L 1",
    ),
    Rule(
        code="RAP009",
        name="unknown-form",
        summary="something at the top level is no form of the language",
        fix="unsafe: writes the name that is spelled almost so, where there is one",
        source="L 1",
    ),
)
