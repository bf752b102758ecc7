"""Every RAP text of the repository, and programs that the grammar makes."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.extra.lark import from_lark
from lark.lexer import PatternStr, TerminalDef

from rapc.analysis.registry import rules
from rapc.language.build import MARKS, SOURCE, parser

CHECKOUT = Path(__file__).parents[2]
FILES = sorted(
    path
    for folder in ("stdlib", "examples", "tests")
    for path in (CHECKOUT / folder).rglob("*.rap")
)
_BLOCK = re.compile(r"^```rap(?: [^\n]*)?\n(.*?)^```", re.M | re.S)


@cache
def texts() -> dict[str, str]:
    """The texts by where they stand: files, examples of rules, blocks of the docs."""
    found = {
        str(path.relative_to(CHECKOUT)): path.read_text(encoding="utf-8")
        for path in FILES
    }
    for rule in rules().values():
        found[f"{rule.name} example"] = rule.page.example
        found[f"{rule.name} better"] = rule.page.better
    for page in sorted((CHECKOUT / "docs").rglob("*.md")):
        blocks = _BLOCK.findall(page.read_text(encoding="utf-8"))
        for at, block in enumerate(blocks, start=1):
            found[f"{page.relative_to(CHECKOUT)} block {at}"] = block
    return found


NUMBERS = {
    "NUMBER": ["0", "3", "-2.5", "1.0"],
    "INTEGER": ["-1", "4.0", "2"],
    "TIME": ["0", "2.5", "100"],
    "PERIOD": ["0.5", "3"],
    "COUNT": ["0", "2"],
    "POSITIVE": ["1", "3.0"],
}
NAMES = ["a", "b", "Box-1", "t1", "t2", "okay", "#1", "have", "truck", "f"]
VARIABLES = ["?x", "?Y", "?", "?n"]
KEYWORDS = [":a", ":Done", ":bump"]
TEXTS = ['"a"', '"two\nlines ; (x"', '"A \\"b\\""']


def programs() -> st.SearchStrategy[str]:
    """Whole programs, made by the grammar, with a blank behind every token."""
    terminals, _, _ = parser().grammar.compile(["start"], "*")
    hidden = ("_NAME", "_END", "_SYMBOL", "_SPACE")
    explicit = {t.name: _tokens(t) for t in terminals if t.name not in hidden}
    for skipped in ("COMMENT", "WS"):
        explicit[skipped] = st.just(" ")
    return from_lark(parser(), start="start", explicit=explicit)


def for_each_program(count: int, hold: Callable[[str], None]) -> None:
    """Hand over so many programs, the same ones each time."""

    @settings(
        max_examples=count,
        deadline=None,
        database=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(programs())
    def hand_over(text: str) -> None:
        hold(text)

    hand_over()


def _tokens(terminal: TerminalDef) -> st.SearchStrategy[str]:
    pattern, name = terminal.pattern, terminal.name
    if isinstance(pattern, PatternStr):
        return st.just(pattern.value if pattern.value in MARKS else f"{pattern.value} ")
    if name == "SHOWN":
        return st.sampled_from(["#counter", "#SET"])
    if name in NUMBERS:
        words = NUMBERS[name]
    elif name in ("STRING", "FILE"):
        words = TEXTS
    elif pattern.value.startswith("\\?"):
        words = (
            VARIABLES if name == "VARIABLE" else [w for w in VARIABLES if len(w) > 1]
        )
    else:
        words = KEYWORDS if pattern.value.startswith(":") else NAMES
    return st.sampled_from([f"{word} " for word in words])


__all__ = ("FILES", "SOURCE", "programs", "texts")
