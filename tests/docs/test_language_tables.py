"""The tables of docs/language/1-text.md come from the grammar and its words.

`python -m tests.docs.test_language_tables` writes them anew.
"""

from __future__ import annotations

import re
from pathlib import Path

from rapc.language.grammar import RULES
from rapc.language.heads import rules_by_head
from rapc.language.words import OPERANDS, WORDS, table

PAGE = Path(__file__).parents[2] / "docs" / "language" / "1-text.md"
_TABLE = re.compile(r"(<!-- (\w+) -->\n).*?(<!-- end -->)", re.S)


def _written(text: str) -> str:
    return _TABLE.sub(lambda found: found[1] + table(found[2]) + found[3], text)


def test_tables_are_those_of_the_grammar() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert [found[2] for found in _TABLE.finditer(text)] == [
        "_rap_clause",
        "annotation",
    ]
    assert _written(text) == text


def test_words_are_of_rules_of_the_grammar() -> None:
    assert set(WORDS) <= set(RULES)
    assert set(OPERANDS) <= set(RULES)


def test_every_list_that_has_a_head_has_words() -> None:
    groups = ("_form", "define_rap", "method", "formula", "_test_clause", "expectation")
    heads = {rule for group in groups for rule in rules_by_head(group).values()}
    lists = {rule for rule in heads if RULES[rule][0] == "list"}
    assert lists <= set(WORDS)


if __name__ == "__main__":
    PAGE.write_text(_written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
