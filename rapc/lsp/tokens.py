"""Semantic tokens: the kind of each word, for colours."""

from __future__ import annotations

from collections.abc import Mapping

from lsprotocol import types

from rapc.language.highlight import tokens
from rapc.lsp.positions import Text

_TYPES: Mapping[str, types.SemanticTokenTypes] = {
    "form": types.SemanticTokenTypes.Keyword,
    "clause": types.SemanticTokenTypes.Keyword,
    "operator": types.SemanticTokenTypes.Operator,
    "head": types.SemanticTokenTypes.Function,
    "defined": types.SemanticTokenTypes.Function,
    "word": types.SemanticTokenTypes.EnumMember,
    "variable": types.SemanticTokenTypes.Variable,
    "keyword": types.SemanticTokenTypes.Property,
    "number": types.SemanticTokenTypes.Number,
    "string": types.SemanticTokenTypes.String,
    "comment": types.SemanticTokenTypes.Comment,
}
"""The token types of the protocol, by the kinds of `rapc.language.highlight`."""

_NAMES = list(dict.fromkeys(_TYPES.values()))

LEGEND = types.SemanticTokensLegend(
    [str(one.value) for one in _NAMES],
    [str(types.SemanticTokenModifiers.Definition.value)],
)
"""The numbers of types and modifiers in answers."""


def semantic_tokens(text: Text, rows: range | None = None) -> types.SemanticTokens:
    """Return the tokens of a text, or only those in some rows, from 0."""
    data: list[int] = []
    row = column = 0
    last = (0, 0)
    for kind, said in tokens(text.text):
        known = _TYPES.get(kind)
        for at, line in enumerate(said.split("\n")):
            if at:
                row, column = row + 1, 0
            size = _units(line, text.wide)
            if known and size and (rows is None or row in rows):
                start = column if row > last[0] else column - last[1]
                number = _NAMES.index(known)
                data += (row - last[0], start, size, number, int(kind == "defined"))
                last = (row, column)
            column += size
    return types.SemanticTokens(data)


def _units(line: str, wide: bool) -> int:
    """Return the length of a piece of a line in the units of the client."""
    if not wide or line.isascii():
        return len(line)
    return len(line) + sum(char > "\uffff" for char in line)
