"""A Pygments lexer for RAP: websites, notebooks and LaTeX documents colour RAP with it.

Pygments finds the lexer by the entry point `pygments.lexers`, under the name `rap`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import ClassVar

from pygments.lexer import Lexer
from pygments.token import (
    Comment,
    Error,
    Keyword,
    Name,
    Number,
    Operator,
    Punctuation,
    String,
    Whitespace,
    _TokenType,
)

from rapc.language.highlight import tokens

_TOKENS = {
    "form": Keyword.Declaration,
    "clause": Keyword,
    "operator": Operator.Word,
    "head": Name,
    "defined": Name.Function,
    "word": Keyword.Constant,
    "name": Name.Constant,
    "variable": Name.Variable,
    "keyword": Name.Attribute,
    "number": Number,
    "string": String,
    "comment": Comment,
    "bracket": Punctuation,
    "space": Whitespace,
    "rest": Error,
}


class RapLexer(Lexer):
    """Lexer for RAP, the language of rapc."""

    name = "RAP"
    aliases: ClassVar[Sequence[str]] = ("rap",)
    filenames: ClassVar[Sequence[str]] = ("*.rap",)

    def get_tokens_unprocessed(
        self, text: str
    ) -> Iterator[tuple[int, _TokenType, str]]:
        """Yield the tokens of a text, each with its position and type."""
        at = 0
        for kind, part in tokens(text):
            yield at, _TOKENS[kind], part
            at += len(part)
