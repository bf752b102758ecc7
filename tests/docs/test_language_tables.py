"""The tables of forms, clauses and formulas come from the grammar and its words.

`python -m tests.docs.test_language_tables` writes them anew.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.heads import heads, rules_by_head, spelling
from rapc.language.shapes import leaves

DOCS = Path(__file__).parents[2] / "docs"
PAGES = {
    "language/1-text.md": ["_rap_clause", "_any_clause", "annotation", "_form"],
    "language/2-queries.md": ["formula", "call"],
    "reference/tests.md": ["_test_clause", "expectation"],
}
"""The pages with the groups of the grammar that they have tables of."""

_TABLE = re.compile(r"(<!-- (\w+) -->\n).*?(<!-- end -->)", re.S)


def _table_of(group: str) -> str:
    """Return a table of the lists in a group of the grammar, as the pages have them.

    Those that may stand several times beside others that stand once are marked *.
    """
    once = [rule for name in leaves(RULES[group]) for rule in _once(name)]
    rules = [*dict.fromkeys(rules_by_head(group).values()) | _headless(group)]
    titles = [group.rpartition("_")[2], "what it says"]
    paged = any(GRAMMAR[rule].pages for rule in rules)
    rows = [titles + ["page"] * paged, ["---"] * (len(titles) + paged)]
    for rule in rules:
        row = GRAMMAR[rule]
        links = ", ".join(f"[{page[0]}]({page})" for page in row.pages)
        spelt = spelling(rule).replace("|", "\\|")
        said = f"{row.says}; {row.more}" if row.more else row.says
        mark = " *" if once and rule not in once else ""
        rows.append([f"`{spelt}`{mark}", said] + [links] * paged)
    lines = [f"| {' | '.join(cells)} |\n" for cells in rows]
    return "".join(lines).replace(" --- ", "---")


def _once(name: str) -> list[str]:
    """The rules of a group that stand once in a form."""
    return list(leaves(RULES[name])) if name.startswith("_once") else []


def _headless(group: str) -> dict[str, None]:
    """The lists of a group that begin with a part of their own, as `protect` does."""
    lists = [rule for rule in leaves(RULES[group]) if rule[0] != "_"]
    return dict.fromkeys(rule for rule in lists if not heads(rule))


def _written(text: str) -> str:
    return _TABLE.sub(lambda found: found[1] + _table_of(found[2]) + found[3], text)


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
