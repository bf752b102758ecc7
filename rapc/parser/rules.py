"""The rules of the front end: everything the reader and the form functions find."""

from __future__ import annotations

from rapc.diagnostics import Rule
from rapc.parser.rules_of_forms import FORM_RULES
from rapc.parser.rules_of_slips import SLIP_RULES
from rapc.parser.rules_of_text import TEXT_RULES

RULES: tuple[Rule, ...] = (*TEXT_RULES, *FORM_RULES, *SLIP_RULES)
"""All of them, each with its manual page."""
