"""Facts, goals and requests with variables, as patterns of values."""

from __future__ import annotations

from rapc.base.values import Fact
from rapc.errors import TextError
from rapc.ir.nodes import Const, Var
from rapc.parser.parse import parse_pattern


def pattern(text: str) -> Fact:
    """Return a list with variables as a pattern; variables are names with `?`.

    Raises:
        TextError: for computed terms, and for whatever is no proposition.
    """
    made = parse_pattern(text)
    values = []
    for term in made.args:
        if isinstance(term, Const):
            values.append(term.value)
        elif isinstance(term, Var):
            values.append(term.name)
        else:
            raise TextError(f"a pattern holds values and variables only: {text}")
    return (made.name, *values)
