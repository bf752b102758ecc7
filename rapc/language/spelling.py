"""How the lists of the grammar are written in short, one by one and as tables.

Findings spell a rule to say what fits at a place, the pages of docs/language have a
table for each group.
"""

from __future__ import annotations

from collections.abc import Mapping

from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.heads import heads, rules_by_head
from rapc.language.shapes import Shape, is_rule, is_word, leaves


def spelling(rule: str) -> str:
    """Return how a list is written, as in `(believe (fact) term)`."""
    return _spelt(RULES[rule])


def forms_table(group: str) -> str:
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


def _spelt(shape: Shape) -> str:
    if isinstance(shape, tuple):
        texts = [_spelt(part) for part in shape[1:]]
        if shape[0] == "or":
            texts = list(dict.fromkeys(texts))
        return _JOINED[shape[0]].format("|".join(texts), " ".join(texts))
    if is_word(shape):
        return shape[1:-1]
    name = shape.replace("_", "-").lower()
    return (GRAMMAR[shape].short if is_rule(shape) else "") or name


_JOINED: Mapping[Shape, str] = {
    "list": "({1})",
    "seq": "{1}",
    "or": "{0}",
    "?": "[{0}]",
    "*": "{0}...",
    "+": "{0}...",
}
"""How parts are written together: as alternatives, or one behind the other."""
