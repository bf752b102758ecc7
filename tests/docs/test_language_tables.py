"""The tables of forms, clauses and formulas come from the grammar and its words.

`python -m tests.docs.test_language_tables` writes them anew.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.heads import rules_by_head
from rapc.language.spelling import forms_table

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {
    "language/1-text.md": ["_rap_clause", "_any_clause", "annotation", "_form"],
    "language/2-queries.md": ["formula", "call"],
    "testing.md": ["_test_clause", "expectation"],
}
"""The pages with the groups of the grammar that they have tables of."""

_TABLE = re.compile(r"(<!-- (\w+) -->\n).*?(<!-- end -->)", re.S)


def _written(text: str) -> str:
    return _TABLE.sub(lambda found: found[1] + forms_table(found[2]) + found[3], text)


@pytest.mark.parametrize("page", PAGES)
def test_tables_are_those_of_the_grammar(page: str) -> None:
    text = (DOCS / page).read_text(encoding="utf-8")
    assert [found[2] for found in _TABLE.finditer(text)] == PAGES[page]
    assert _written(text) == text


def test_every_list_that_has_a_head_has_words() -> None:
    groups = (
        "_form",
        "define_rap",
        "method",
        "formula",
        "call",
        "_test_clause",
        "expectation",
    )
    heads = {rule for group in groups for rule in rules_by_head(group).values()}
    lists = {rule for rule in heads if RULES[rule][0] == "list"}
    assert lists <= {rule for rule, row in GRAMMAR.items() if row.says}


if __name__ == "__main__":
    for page in PAGES:
        file = DOCS / page
        file.write_text(_written(file.read_text(encoding="utf-8")), encoding="utf-8")
