"""Any text, however broken, ends in findings: never an exception, never a hang."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rapc.base.limits import MAX_FINDINGS
from rapc.language import heads as names
from tests.effort import examples, first
from tests.parser.reading import hold_places, parsed, rules

WORDS = [
    *names.FORMS,
    *names.RAP_CLAUSES,
    *names.METHOD_CLAUSES,
    *names.TEST_CLAUSES,
    *names.ANNOTATIONS,
    *names.QUERIES,
    *names.CALLS,
    *("=>", "now", "t", "nil", "rule", "match-result", "mem-add", "enable", "set"),
    *(":finish", ":succeed", ":asserts", ":refused", ":bump", "succeeds", "trace"),
    *("?x", "?", "a", "3", "-1.5", '"s"'),
]
REFUSED = ["(size-of (?x))", "(value ())", "(+ 1)", "(f (?x))", "(p => ?x)", "(=> a)"]
"""Lists that are refused, as parts of others."""

MARKS = ["(", ")", "((", "))", "\n(", '"', ";", "#|", "|#", "'"]
PIECES = st.one_of(st.sampled_from(WORDS), st.sampled_from(MARKS), st.text(max_size=2))
LOOSE = st.lists(PIECES, max_size=60).map(" ".join)
NESTED = st.recursive(
    st.sampled_from([*WORDS, *REFUSED]),
    lambda inner: st.lists(inner, max_size=5).map(lambda ws: f"({' '.join(ws)})"),
    max_leaves=40,
)
FORMS = st.builds(
    lambda head, parts: f"({head} {' '.join(parts)})",
    st.sampled_from(names.FORMS),
    st.lists(NESTED, max_size=5),
)


@examples(500)
@given(st.text())
def test_random_text(text: str) -> None:
    hold_places(text)


@examples(1000)
@given(LOOSE)
def test_random_words_and_marks(text: str) -> None:
    hold_places(text)


@examples(600, share=6)
@given(FORMS)
def test_random_forms(text: str) -> None:
    hold_places(text)


ABSURD = [
    ("100,000 open parentheses", "(" * 100_000, ["nested-too-deeply"]),
    ("100,000 closing parentheses", ")" * 100_000, ["surplus-parenthesis"]),
    ("balanced but deep", "(" * 5000 + ")" * 5000, ["nested-too-deeply"]),
    ("10 MB of one symbol", "a" * 10_000_000, ["too-long"]),
    ("10 MB of one number", "7" * 10_000_000, ["too-long"]),
    ("1 MB of one string, open", '"' + "a" * 1_000_000, ["unterminated-string"]),
    ("1 MB of quotation marks in it", '"' + '\\"' * 500_000, ["unterminated-string"]),
    ("1 MB of comment, open", "#|" * 500_000, ["unterminated-comment"]),
    ("1 MB of space", " " * 1_000_000, []),
    ("1 MB of space behind an open list", "(" + " " * 1_000_000, None),
    ("1 MB of quotes", "'" * 1_000_000, ["illegal-character"]),
    ("1 MB of nulls", "\0" * 1_000_000, ["illegal-character"]),
]


@pytest.mark.parametrize("row", first(10, ABSURD), ids=[row[0] for row in ABSURD])
def test_absurd_text_ends_in_one_finding(
    row: tuple[str, str, list[str] | None],
) -> None:
    _, text, expected = row
    found = rules(text)
    assert found == expected or (expected is None and len(found) == 1)


def test_formula_of_two_hundred_leaves_is_the_largest() -> None:
    for count, found in ((200, []), (201, ["formula-too-large"])):
        text = f"(define-rap (a) (succeed (or{' (p)' * count})))"
        assert rules(text) == found


def test_findings_of_one_file_are_limited_and_the_last_says_so() -> None:
    found = parsed("(foo)\n" * (MAX_FINDINGS + 500)).diagnostics
    assert len(found) == MAX_FINDINGS
    assert found[-1].notes
    assert not found[-2].notes
