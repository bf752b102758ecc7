"""The events of a trace with their keys: what a test may expect of one.

What each means stands in docs/trace.md; `rapc.runtime.events` makes them, and a test
holds the two together.
"""

from __future__ import annotations

from collections.abc import Mapping

COMMON = ("n", "cycle", "time")
"""Keys that every event has."""

KEYS: Mapping[str, tuple[str, ...]] = {
    "data-received": ("data",),
    "deadline-missed": (
        "task",
        "deadline",
    ),
    "deadlock": (
        "tasks",
        "waiting",
    ),
    "fact-asserted": (
        "fact",
        "by",
    ),
    "fact-erased": (
        "fact",
        "by",
    ),
    "family-switched": (
        "task",
        "from",
        "to",
    ),
    "item-introduced": (
        "item",
        "sensor",
        "class",
        "location",
        "with",
        "score",
        "rival",
    ),
    "item-lost": (
        "item",
        "sensor",
        "class",
        "location",
        "with",
        "score",
        "rival",
    ),
    "item-merged": (
        "item",
        "sensor",
        "class",
        "location",
        "with",
        "score",
        "rival",
    ),
    "item-moved": (
        "item",
        "sensor",
        "class",
        "location",
        "with",
        "score",
        "rival",
    ),
    "method-chosen": (
        "task",
        "rap",
        "method",
        "bindings",
    ),
    "method-ended": (
        "task",
        "method",
        "result",
        "because",
    ),
    "method-suspended": (
        "task",
        "method",
        "for",
        "by",
    ),
    "primitive-cancelled": (
        "task",
        "request",
    ),
    "primitive-ended": (
        "task",
        "request",
        "result",
        "data",
    ),
    "primitive-requested": (
        "task",
        "request",
        "sent",
    ),
    "query-faulted": (
        "task",
        "what",
    ),
    "request-refused": (
        "task",
        "request",
        "sent",
        "because",
    ),
    "resource-changed": (
        "task",
        "what",
    ),
    "rule-run": (
        "task",
        "what",
        "at",
    ),
    "run-ended": (
        "reason",
        "because",
        "results",
        "waiting",
    ),
    "run-started": (
        "format",
        "library",
        "digest",
        "world",
        "options",
        "settings",
        "seed",
        "tasks",
        "faults",
        "facts",
    ),
    "signal": (
        "task",
        "what",
    ),
    "skill-disabled": (
        "task",
        "what",
    ),
    "skill-enabled": (
        "task",
        "what",
    ),
    "solver-called": (
        "task",
        "goal",
        "methods",
    ),
    "task-blocked": (
        "task",
        "on",
        "holder",
    ),
    "task-created": (
        "task",
        "goal",
        "parent",
        "family",
        "priority",
        "step",
    ),
    "task-failed": (
        "task",
        "goal",
        "reason",
        "result",
        "because",
    ),
    "task-removed": (
        "task",
        "cause",
    ),
    "task-selected": (
        "task",
        "goal",
    ),
    "task-succeeded": (
        "task",
        "goal",
        "outputs",
    ),
    "task-woken": (
        "task",
        "on",
        "holder",
    ),
}
"""For each event the further keys, in the order in which they are written."""
