"""What is reported of data that do not fit a rule of the grammar."""

from __future__ import annotations

from rapc.language.grammar import GRAMMAR
from rapc.language.spelling import spelling
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.syntax import Datum


def finding(rule: str) -> str:
    """Return the rule of the checker that a fault in data of a rule breaks."""
    return GRAMMAR[rule].breaks if rule in GRAMMAR else "malformed-clause"


def wrong(ctx: Context, rule: str, datum: Datum) -> None:
    """Report a list whose operands are too few, too many or of the wrong kinds."""
    said, name = GRAMMAR[rule], head_of(datum)
    message = said.wrong.format(kind=kind_of(datum))
    if not message and said.takes:
        message = f"`{name}` takes {said.takes}"
    elif not message:
        message = f"`{name}` is written `{spelling(rule)}`"
    ctx.report(said.breaks, message, datum, help=said.help)
