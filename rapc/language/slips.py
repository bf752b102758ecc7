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
