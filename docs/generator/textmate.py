"""The TextMate grammar of the extension for VS Code, from the grammar of RAP."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from typing import Any

from rapc.language.highlight import HEADS, WORDS

_END = r"(?=[\s()\";]|$)"


def grammar() -> dict[str, Any]:
    """Return the TextMate grammar as data."""
    by_kind: dict[str, list[str]] = {}
    for word, kind in HEADS.items():
        by_kind.setdefault(kind, []).append(word)
    defining = [w for w in by_kind["form"] if w.startswith(("define-", "declare-"))]
    return {
        "name": "RAP",
        "scopeName": "source.rap",
        "fileTypes": ["rap"],
        "patterns": [
            _match("comment.line.semicolon.rap", ";.*$"),
            {
                "name": "comment.block.rap",
                "begin": r"#\|",
                "end": r"\|#",
                "patterns": [{"include": "#block"}],
            },
            {
                "name": "string.quoted.double.rap",
                "begin": '"',
                "end": '"',
                "patterns": [_match("constant.character.escape.rap", r"\\.")],
            },
            {
                "match": (
                    rf"(?i)(\()\s*({_any(defining)}){_END}(?:\s+\(?([^\s()\";:?]+))?"
                ),
                "captures": {
                    "1": {"name": "punctuation.section.parens.rap"},
                    "2": {"name": "keyword.declaration.rap"},
                    "3": {"name": "entity.name.function.rap"},
                },
            },
            _head("keyword.declaration.rap", by_kind["form"]),
            _head("keyword.control.rap", by_kind["clause"]),
            _head("keyword.operator.rap", by_kind["operator"]),
            _match("variable.parameter.rap", r"\?[^\s()\";]*"),
            _match("support.type.property-name.rap", r":[^\s()\";]+"),
            _match("constant.numeric.rap", rf"[-+]?[0-9]+(\.[0-9]+)?{_END}"),
            _match(
                "constant.language.rap",
                rf"(?i)(?<=[\s(])({_any(WORDS)}){_END}",
            ),
            {
                "match": r"(\()\s*([^\s()\";:?]+)",
                "captures": {
                    "1": {"name": "punctuation.section.parens.rap"},
                    "2": {"name": "entity.name.function.call.rap"},
                },
            },
            _match("punctuation.section.parens.rap", "[()]"),
            _match("constant.other.symbol.rap", r"[^\s()\";:?]+"),
        ],
        "repository": {
            "block": {
                "begin": r"#\|",
                "end": r"\|#",
                "patterns": [{"include": "#block"}],
            }
        },
    }


def _match(name: str, pattern: str) -> dict[str, Any]:
    return {"name": name, "match": pattern}


def _head(name: str, words: Iterable[str]) -> dict[str, Any]:
    """Return the pattern of words after an opening parenthesis."""
    return {
        "match": rf"(?i)(\()\s*({_any(words)}){_END}",
        "captures": {
            "1": {"name": "punctuation.section.parens.rap"},
            "2": {"name": name},
        },
    }


def _any(words: Iterable[str]) -> str:
    """Return the expression for one of some words; longer words first."""
    return "|".join(re.escape(one) for one in sorted(words, key=lambda w: (-len(w), w)))


def textmate() -> str:
    """Return the grammar as JSON."""
    return json.dumps(grammar(), indent=2, ensure_ascii=False) + "\n"
