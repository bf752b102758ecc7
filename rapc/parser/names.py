"""The words of the language: what may head a form, a clause, an annotation.

The reader tells by them where a new form begins, forms/ suggests what was meant.
"""

from __future__ import annotations

FORMS = (
    "define-rap",
    "declare-memory-proposition",
    "declare-memory-property",
    "declare-memory-function",
    "declare-indistinct-class",
    "declare-class-comparator",
    "declare-primitive",
    "declare-sensor-datum",
    "declare-skill",
    "declare-event",
    "define-memory-rule",
    "define-event-rule",
    "define-test",
    "require",
)
"""What may stand at the top level."""

RAP_CLAUSES = (
    "index",
    "duration",
    "monitor-state",
    "monitor-time",
    "repeat-while",
    "succeed",
    "preconditions",
    "constraints",
    "resources",
    "effects",
    "method",
)
"""The clauses of a `define-rap`."""

METHOD_CLAUSES = ("context", "notations", "task-net", "primitive")
"""The clauses of a method."""

TEST_CLAUSES = (
    "require",
    "world",
    "facts",
    "script",
    "at",
    "task",
    "until",
    "cycles",
    "expect",
)
"""The clauses of a `define-test`."""

ANNOTATIONS = (
    "for",
    "until-start",
    "until-end",
    "window",
    "wait-for",
    "set-add",
    "set-sub",
    "counter-add",
    "counter-sub",
)
"""What may head an annotation of a step."""

COMPARISONS = ("=", "n=", "<", ">", "<=", ">=")
"""Tests of two terms."""

CALLS = ("+", "-", "*", "/", "size-of", "value")
"""Functions that compute a term; others are declared."""

QUERIES = (
    "and",
    "or",
    "not",
    *COMPARISONS,
    "believe",
    "member",
    "empty",
    "method-tried",
    "last-result",
    "result-with-method",
    "know-sensor-name",
    "count",
)
"""Words that head a formula and are no propositions."""

TRUTHS = {"t": True, "true": True, "nil": False, "false": False}
"""The constants that are formulas."""

SLIPS = {
    "success": "succeed",
    "succeeds": "succeed",
    "constraint": "constraints",
    "precondition": "preconditions",
    "resource": "resources",
    "effect": "effects",
    "notation": "notations",
    "methods": "method",
    "monitor": "monitor-state",
    "counter-del": "counter-sub",
    "set-del": "set-sub",
}
"""Words that print has had for others."""
