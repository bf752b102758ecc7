"""The rules of the front end, reported by the reader and the form functions."""

from __future__ import annotations

from rapc.base.diagnostics import Rule
from rapc.parser.rules.forms import FORM_RULES
from rapc.parser.rules.slips import SLIP_RULES
from rapc.parser.rules.text import TEXT_RULES

RULES: tuple[Rule, ...] = (*TEXT_RULES, *FORM_RULES, *SLIP_RULES)
"""All rules of the front end, each with its manual page."""
