"""The terminals of `rap.lark` as regular expressions, by name.

Written by `python -m tests.parser.terminals`; a test holds it against the grammar.
"""

from __future__ import annotations

from collections.abc import Mapping

# fmt: off
# ruff: noqa: E501
TERMINALS: Mapping[str, str] = {
    "LPAR": "\\(",
    "RPAR": "\\)",
    "_NAME": "(?:[^\\s\u0000-\u001f\u007f-\u009f\u200b-\u200f\u2018\u2019\u201c\u201d\u2060\ufeff()\\[\\]{}\"';`,|\\\\#]+|#(?!\\|))+",
    "NUMBER": "[+-]?[0-9]+(?:\\.[0-9]+)?(?!#(?!\\|)|[^\\s\u0000-\u001f\u007f-\u009f\u200b-\u200f\u2018\u2019\u201c\u201d\u2060\ufeff()\\[\\]{}\"';`,|\\\\#])",
    "VARIABLE": "\\?(?:(?:[^\\s\u0000-\u001f\u007f-\u009f\u200b-\u200f\u2018\u2019\u201c\u201d\u2060\ufeff()\\[\\]{}\"';`,|\\\\#]+|#(?!\\|))+)?",
    "KEYWORD": ":(?:[^\\s\u0000-\u001f\u007f-\u009f\u200b-\u200f\u2018\u2019\u201c\u201d\u2060\ufeff()\\[\\]{}\"';`,|\\\\#]+|#(?!\\|))+",
    "SYMBOL": "(?!:)(?:[^\\s\u0000-\u001f\u007f-\u009f\u200b-\u200f\u2018\u2019\u201c\u201d\u2060\ufeff()\\[\\]{}\"';`,|\\\\#]+|#(?!\\|))+",
    "STRING": "(?s:\"[^\"\\\\]*(?:\\\\.[^\"\\\\]*)*\")",
    "BLOCK_OPEN": "\\#\\|",
    "BLOCK_CLOSE": "\\|\\#",
    "BLOCK_TEXT": "(?:[^#|]|#(?!\\|)|\\|(?!#))+",
    "COMMENT": ";[^\n]*",
    "_SPACE": "[ \t\r\n\f]",
    "WS": "(?:[ \t\r\n\f])+",
}
"""What lark makes of the grammar's terminals."""
