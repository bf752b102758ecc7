"""What is reported of data that do not fit a rule of the grammar."""

from __future__ import annotations

from collections.abc import Mapping

from rapc.language.grammar import RULES
from rapc.language.misfits import MISFITS
from rapc.language.shapes import leaves
from rapc.language.spelling import spelling
from rapc.language.words import WORDS
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.syntax import Datum

FINDINGS: Mapping[str, str] = {
    **dict.fromkeys(leaves(RULES["formula"]), "malformed-formula"),
    **dict.fromkeys(leaves(RULES["annotation"]), "malformed-annotation"),
    **dict.fromkeys(leaves(RULES["_form"]), "malformed-form"),
    **dict.fromkeys(leaves(RULES["_rap_clause"]), "malformed-clause"),
    **dict.fromkeys(("case", "rule", "alternative", "action"), "malformed-rule"),
    **dict.fromkeys(leaves(RULES["expectation"]), "malformed-clause"),
    "expectation": "malformed-clause",
    **dict.fromkeys(("above", "reads", "uses", "tells"), "malformed-form"),
    **dict.fromkeys(("primitive_atomic", "skill_events"), "malformed-form"),
    "COMPARATOR": "malformed-form",
}
"""Which rule of the checker a fault breaks; in clauses it is `malformed-clause`."""


def finding(rule: str) -> str:
    """Return the rule of the checker that a fault in data of a rule breaks."""
    return FINDINGS.get(rule, "malformed-clause")


def wrong(ctx: Context, rule: str, datum: Datum) -> None:
    """Report a list whose operands are too few, too many or of the wrong kinds."""
    said = MISFITS.get(rule)
    if said is not None:
        message = said.message.format(kind=kind_of(datum))
        ctx.report(said.finding, message, datum, help=said.help)
        return
    row = WORDS.get(rule)
    name = head_of(datum)
    message = f"`{name}` is written `{spelling(rule)}`"
    if row is not None and row.takes:
        message = f"`{name}` takes {row.takes}"
    ctx.report(finding(rule), message, datum)
