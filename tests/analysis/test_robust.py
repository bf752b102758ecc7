"""Any text ends in findings that can be shown, never in an exception."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rapc.analysis.driver import check_library
from rapc.console import findings as render
from rapc.console import formats
from rapc.library.loader import load_text
from tests.effort import examples

CHECKOUT = Path(__file__).parents[2]
TEXTS = [
    path.read_text(encoding="utf-8")
    for path in sorted(
        [*CHECKOUT.glob("examples/*.rap"), *Path(__file__).parent.glob("*.rap")]
    )
]
TERMS = ("(size-of (?x))", "(value (?x))", "(size-of ())", "(size-of)", "(value 1 2)")
SCRAPS = [
    "(",
    ")",
    '"',
    ";",
    "#|",
    "|#",
    "?",
    "?x",
    "=>",
    ":a",
    "for",
    "not",
    "7",
    "\t",
]


@st.composite
def damaged(draw: st.DrawFn) -> str:
    """A program with pieces taken out, put in, or put elsewhere."""
    text = draw(st.sampled_from(TEXTS))
    for _ in range(draw(st.integers(1, 6))):
        start = draw(st.integers(0, len(text)))
        end = min(len(text), start + draw(st.integers(0, 40)))
        piece = draw(st.sampled_from([*SCRAPS, text[start:end], ""]))
        at = draw(st.integers(0, len(text)))
        if draw(st.booleans()):
            text = text[:start] + text[end:]
        text = f"{text[:at]}{piece}{text[at:]}"
    return text


@examples(150)
@given(damaged())
def test_damaged_programs_can_be_checked_and_shown(text: str) -> None:
    report = check_library(load_text(text))
    shown = "\n".join(line.plain for line in render.full(report, 80))
    assert shown.count("[RAP") >= len(report.findings)
    assert len(list(render.concise(report))) == len(report.findings)
    assert formats.json_text(report).startswith("[")
    for finding in report.findings:
        span = finding.diagnostic.span
        assert 0 <= span.start <= span.end <= len(text) + 1


@pytest.mark.parametrize("term", TERMS)
def test_a_term_that_cannot_be_read_is_one_finding(term: str) -> None:
    text = f"(define-rap (a ?seen) (succeed (> 1 {term})))"
    assert len(check_library(load_text(text)).findings) == 1
