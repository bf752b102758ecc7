"""The rules of the front end: everything the reader and the form functions find."""

from __future__ import annotations

from rapc.base.diagnostics import Rule
from rapc.parser.rules.forms import FORM_RULES
from rapc.parser.rules.slips import SLIP_RULES
from rapc.parser.rules.text import TEXT_RULES

RULES: tuple[Rule, ...] = (*TEXT_RULES, *FORM_RULES, *SLIP_RULES)
"""All of them, each with its manual page."""
