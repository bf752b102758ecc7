"""Words that print has had for others, and those that group steps elsewhere."""

from __future__ import annotations

from collections.abc import Mapping

SLIPS: Mapping[str, str] = {
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
"""Words that print has had, with those that are meant."""

GROUPS = ("sequence", "parallel")
"""Words that group steps in other languages."""

ELSEWHERE: Mapping[str, str] = {
    "priority": "a priority is a number behind the tag: `(t1 2 (rap args...))`",
    "after": "the step that comes before says so: `(for t1)`",
    "timeout": "a time to end at is a second step, `(window now 30 30)`, and "
    "`until-end`",
}
"""What is said by other words than those that some expect here."""

MISPLACED: Mapping[tuple[str, str], str] = {
    ("option of `task`", ":at"): "a task that begins later stands in an `at`: "
    "`(at 130 (task ...))`",
}
"""Help for a word that belongs elsewhere, by what it would be here and the word."""
