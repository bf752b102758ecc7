"""Tokens of RAP text for colours, and indentation of lines."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rapc.language.comments import comment_end
from rapc.language.grammar import RULES, TERMINALS
from rapc.language.heads import (
    CALLS,
    FORMS,
    QUERIES,
    heads,
    rules_by_head,
    words_of_shape,
)
from rapc.language.shapes import is_list, is_rule, is_terminal, leaves

_TOKEN = re.compile(
    "|".join(
        f"(?P<{name}>{pattern})"
        for name, pattern in (
            ("block", TERMINALS["BLOCK_OPEN"]),
            ("comment", TERMINALS["COMMENT"]),
            ("string", r'"(?:[^"\\]|\\.)*"?'),
            ("variable", TERMINALS["VARIABLE"]),
            ("keyword", TERMINALS["KEYWORD"]),
            ("number", TERMINALS["NUMBER"]),
            ("name", TERMINALS["_NAME"]),
            ("bracket", r"[()]"),
            ("space", r"\s+"),
            ("rest", "."),
        )
    ),
    re.S,
)

HEADS = {
    **{
        head: "clause" for rule in RULES if is_list(RULES[rule]) for head in heads(rule)
    },
    **dict.fromkeys((*QUERIES, *CALLS), "operator"),
    **dict.fromkeys(FORMS, "form"),
}
"""The kinds of names after an opening bracket."""

WORDS = {word for shape in RULES.values() for word in words_of_shape(shape)} - {*HEADS}
"""The words of the language that are not names after an opening bracket."""


def _is_named(leaf: str) -> bool:
    """Return whether a leaf of a shape is, or begins with, a name."""
    return is_terminal(leaf) or (is_rule(leaf) and _is_named(next(leaves(RULES[leaf]))))


_NAMED = {
    head
    for head, rule in rules_by_head("_form").items()
    if _is_named([*leaves(RULES[rule])][1])
}
"""The forms that define a name."""


def tokens(text: str) -> Iterator[tuple[str, str]]:
    """Yield the tokens of a text, each with its kind; no character is lost.

    Names after a bracket are of the kind `form` (`define-rap`), `clause`, `operator`
    (of formulas and computed terms) or `head`. Other names are `defined` (by a form),
    `word` (of the language) or `name`. A character that is not RAP has the kind `rest`.
    """
    at = 0
    opened = defining = False
    while found := _TOKEN.match(text, at):
        kind, said = found.lastgroup or "rest", found.group()
        if kind == "block":
            end = comment_end(text, at)
            kind, said = "comment", text[at:] if end < 0 else text[at:end]
        elif kind == "name":
            word = said.lower()
            if defining and word != "index":
                kind = "defined"
            elif opened:
                kind = HEADS.get(word, "head")
            elif word in WORDS:
                kind = "word"
            defining = word in _NAMED or (defining and word == "index")
        elif kind not in ("comment", "space"):
            defining = defining and said == "("
        if kind not in ("comment", "space"):
            opened = said == "("
        at += len(said)
        yield kind, said


def indentation(text: str) -> int:
    """Return the indentation of the next line of an unfinished list, in spaces."""
    open_at: list[int] = []
    column = 0
    for kind, said in tokens(text):
        if said == "(":
            open_at.append(column)
        elif said == ")" and open_at:
            open_at.pop()
        newline = said.rfind("\n") if kind in ("space", "string", "comment") else -1
        column = len(said) - newline - 1 if newline >= 0 else column + len(said)
    return open_at[-1] + 2 if open_at else 0
