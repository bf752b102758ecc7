"""The rules of the front end and what the code reports are the same names.

That each example breaks its rule alone is tested for all rules in `tests/analysis`.
"""

from __future__ import annotations

import ast
from pathlib import Path

from rapc.parser.rules.table import RULES

PARSER = Path(__file__).parents[2] / "rapc" / "parser"
REPORTERS = {
    "report",
    "report_fixable",
    "certain",
    "unknown",
    "Diagnostic",
    "_unclosed",
}


def _reported() -> set[str]:
    """The first argument of every call that reports, where it is a plain string."""
    names = set()
    for path in PARSER.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and node.args:
                called = getattr(node.func, "attr", getattr(node.func, "id", ""))
                first = node.args[0]
                named = isinstance(first, ast.Constant) and isinstance(first.value, str)
                if called in REPORTERS and named:
                    names.add(ast.literal_eval(first))
    return names


def test_what_is_reported_are_the_rules() -> None:
    assert _reported() == {rule.name for rule in RULES}


def test_codes_are_those_of_the_front_end() -> None:
    numbers = [int(rule.code.removeprefix("RAP")) for rule in RULES]
    assert numbers == sorted(set(numbers))
    assert all(1 <= number <= 11 or 30 <= number <= 59 for number in numbers)
