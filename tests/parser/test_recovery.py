"""Texts that do not close: one finding each, in the likeliest place, the rest intact.

Each case is a text, the rule, and what stands at the finding, at its labels and in the
text once the fix is applied.
"""

from __future__ import annotations

import random
import re
from typing import NamedTuple

import pytest

from rapc.analysis.driver import check_library
from rapc.library.loader import load_text
from tests.damage import (
    shipped_raps,
    shipped_texts,
    slipped,
    with_other_parenthesis,
)
from tests.parser.reading import fixed, only, parsed, rules, shown

PARTS = {
    "a method": (
        "(method\n  (context (p))\n  (task-net\n    (t1 (bar)))))\n",
        (4, 17),
    ),
    "a context and a task-net": (
        "(context (p ?x))\n(task-net\n  (t1 (bar))\n  (t2 (baz)))))\n",
        (4, 14),
    ),
    "a method with a primitive": (
        "(method\n  (context (and (p)\n                (q)))\n  (primitive (go))))\n",
        (4, 20),
    ),
}
"""Parts of a RAP alone, as books print them, with parentheses too many at the end."""

BEFORE = "(define-rap (before) (succeed true))\n"
AFTER = "\n(define-rap (after) (succeed true))\n"


class Case(NamedTuple):
    """A broken form, where it is broken, and the same form in order."""

    name: str
    broken: str
    rule: str
    row: int
    column: int
    labels: tuple[int, ...]
    sound: str


CASES = [
    Case(
        "closing parenthesis missing within",
        "(define-rap\n  (index (foo ?x)\n  (succeed (p ?x))\n  (method (task-net)))",
        "missing-parenthesis",
        *(2, 3, (2, 5)),
        "(define-rap\n  (index (foo ?x))\n  (succeed (p ?x))\n  (method (task-net)))",
    ),
    Case(
        "closing parenthesis missing at the end",
        "(define-rap\n  (index (foo))\n  (method\n    (task-net\n      (t1 (bar)))",
        "missing-parenthesis",
        *(3, 3, (5, 6)),
        "(define-rap\n  (index (foo))\n  (method\n    (task-net\n      (t1 (bar)))))",
    ),
    Case(
        "closing parenthesis missing, nothing indented",
        "(define-rap\n(index (foo ?x)\n(succeed (p ?x))\n(method\n(task-net)))",
        "missing-parenthesis",
        *(2, 1, (2, 6)),
        "(define-rap\n(index (foo ?x))\n(succeed (p ?x))\n(method\n(task-net)))",
    ),
    Case(
        "closing parenthesis too many at the end",
        "(define-rap\n  (index (foo))\n  (succeed (p))))",
        "surplus-parenthesis",
        *(3, 17, (1,)),
        "(define-rap\n  (index (foo))\n  (succeed (p)))",
    ),
    Case(
        "closing parenthesis too many within a method",
        "(define-rap\n  (index (foo))\n  (method\n    (context (p)))\n"
        "    (task-net (t1 (bar)))))",
        "surplus-parenthesis",
        *(4, 18, (3, 5)),
        "(define-rap\n  (index (foo))\n  (method\n    (context (p))\n"
        "    (task-net (t1 (bar)))))",
    ),
    Case(
        "method indented as if in the one before it, one too many at the end",
        "(define-rap\n  (index (foo))\n  (method\n    (task-net (t1 (bar))))\n"
        "    (method\n      (task-net (t1 (baz))))))",
        "surplus-parenthesis",
        *(6, 30, (1,)),
        "(define-rap\n  (index (foo))\n  (method\n    (task-net (t1 (bar))))\n"
        "    (method\n      (task-net (t1 (baz)))))",
    ),
    Case(
        "clauses outside of their form",
        "(define-rap\n  (index (foo)))\n(succeed (p))\n(method (task-net))",
        "surplus-parenthesis",
        *(2, 16, (1, 3)),
        "(define-rap\n  (index (foo))\n(succeed (p))\n(method (task-net)))",
    ),
    Case(
        "opening parenthesis of a clause missing",
        "(define-rap\n  (index (foo))\n  succeed (p))\n  (method (task-net)))",
        "missing-parenthesis",
        *(3, 3, ()),
        "(define-rap\n  (index (foo))\n  (succeed (p))\n  (method (task-net)))",
    ),
    Case(
        "opening parenthesis of a form missing",
        "define-rap (foo)\n  (succeed (p)))",
        "missing-parenthesis",
        *(1, 1, ()),
        "(define-rap (foo)\n  (succeed (p)))",
    ),
    Case(
        "opening parenthesis too many",
        "(define-rap\n  (index (foo))\n  ((method (task-net)))",
        "surplus-parenthesis",
        *(3, 3, ()),
        "(define-rap\n  (index (foo))\n  (method (task-net)))",
    ),
    Case(
        "string not closed",
        '(declare-memory-proposition foo (?x) "what it says)',
        "unterminated-string",
        *(1, 38, (1, 2)),
        '(declare-memory-proposition foo (?x) "what it says")',
    ),
    Case(
        "string not closed, others behind it",
        '(define-test foo\n  "what it shows\n  (require "truck")\n  (facts (a "b")))',
        "unterminated-string",
        *(2, 3, (2, 5)),
        '(define-test foo\n  "what it shows"\n  (require "truck")\n  (facts (a "b")))',
    ),
    Case(
        "comment not closed",
        "(define-rap (foo)) #| and nothing\nmore than this",
        "unterminated-comment",
        *(1, 20, (2, 3)),
        "(define-rap (foo)) #| and nothing\nmore than this |#",
    ),
]


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_one_finding_and_the_rest_intact(case: Case) -> None:
    text = BEFORE + case.broken + AFTER
    found = only(text)
    assert found.rule == case.rule
    lines = [0, *(i + 1 for i, c in enumerate(text) if c == "\n")]
    assert found.span.start == lines[case.row] + case.column - 1
    rows = [text.count("\n", 0, label.span.start) for label in found.labels]
    assert sorted(rows) == list(case.labels)
    names = [getattr(form, "name", "") for form in parsed(text).forms]
    assert names[:1] + names[-1:] == ["before", "after"]
    assert "foo" in names or case.name.startswith("string not closed,")


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_fix_puts_it_right(case: Case) -> None:
    text = BEFORE + case.broken + AFTER
    assert fixed(text) == BEFORE + case.sound + AFTER
    assert rules(fixed(text)) == []


def test_opener_place_and_notice_are_shown() -> None:
    text = "(define-rap\n  (index (foo ?x)\n  (succeed (p ?x)))\n(define-rap (two))\n"
    found = only(text)
    assert found.message == "the list of `index` is not closed"
    assert shown(text, found.span) == "("
    assert found.label == "opened here"
    first, last = found.labels
    assert text[: first.span.end].endswith("(index (foo ?x)")
    assert first.message == "`)` is probably missing after this position"
    assert text[last.span.start :] == "(define-rap (two))\n"
    assert last.message == "noticed here"


def test_two_faults_that_make_up_for_each_other_are_told_apart() -> None:
    text = "(define-rap\n  (index (one))\n(define-rap\n  (index (two))))\n"
    assert rules(text) == ["missing-parenthesis", "surplus-parenthesis"]
    assert fixed(text) == text.replace("(one))", "(one)))").replace("))))", ")))")


def test_findings_of_other_forms_are_not_hidden() -> None:
    text = "(define-rap (one)\n(define-rap (two) (success true))\n"
    assert rules(text) == ["missing-parenthesis", "unknown-clause"]


def test_findings_within_the_broken_form_are_withheld() -> None:
    text = "(define-rap (one) (succed true) (foo)\n"
    assert rules(text) == ["missing-parenthesis"]
    assert [one.form for one in parsed(text).partial] == [*parsed(text).forms]


def test_words_that_print_has_had_are_told_in_the_broken_form_too() -> None:
    text = "(define-rap (one) (success true)\n"
    assert rules(text) == ["missing-parenthesis", "unknown-clause"]


PRINTED = """\
(DEFINE-RAP
  (INDEX (carry ?what))
  (CONSTRAINT (at hill))
  (MONITOR-TIME (now 5 20))
  (METHOD
    (TASK-NET
      (t1 (lift ?what)
          ((held ?what) (FOR t2)))
      (t2 (drop ?what)
          (COUNTER-DEL ?left 1))))))
"""


def test_all_slips_of_a_form_are_told_beside_a_parenthesis_too_many_behind_it() -> None:
    assert rules(PRINTED) == [
        "unknown-clause",
        "parenthesised-times",
        "parenthesised-for",
        "unknown-annotation",
        "surplus-parenthesis",
    ]
    assert not parsed(PRINTED).partial
    assert rules(fixed(PRINTED)) == []


def test_clause_in_column_one_begins_no_form() -> None:
    text = "(define-rap\n(index (one))\n(method (task-net)))\n"
    assert rules(text) == []


def test_required_file_within_a_test_begins_no_form() -> None:
    text = '(define-test one\n(require "truck")\n(facts (a b)\n(expect))\n'
    found = only(text)
    assert found.rule == "missing-parenthesis"
    assert fixed(text) == text.replace("(a b)", "(a b))")


def test_form_in_a_comment_or_string_begins_no_form() -> None:
    for text in (
        "(define-rap (one) #|\n(define-rap (two))\n|# (succeed true))\n",
        '(declare-event :a () "\n(define-rap (two))\n")\n',
    ):
        assert rules(text) == []


SAMPLE = """\
(define-rap (fetch ?thing => ?place)
  (succeed (and (have ?thing)
                (location ?thing ?place)))
  (repeat-while (or (location ?thing ?spot)
                    (not (have ?thing))))
  (method walk
    (context (and (location ?thing ?spot)
                  (> (distance ?spot) 3)))
    (task-net
      (t1 (go-to ?spot)
          ((at ?spot) for t2)
          (until-end t2))
      (t2 1 (pick-up ?thing => ?place))))
  (method 2
    (context (know-sensor-name ?thing))
    (primitive (grasp ?thing))))
"""
PLACES = [at for at, mark in enumerate(SAMPLE) if mark in "()"]


def _context(mutant: str, at: int) -> str:
    return repr(mutant[max(0, at - 12) : at + 12])


@pytest.mark.parametrize("at", PLACES)
def test_any_one_parenthesis_lost_or_doubled_is_one_finding(at: int) -> None:
    lost = SAMPLE[:at] + SAMPLE[at + 1 :]
    doubled = SAMPLE[:at] + SAMPLE[at] + SAMPLE[at:]
    for mutant in (lost, doubled):
        text = BEFORE + mutant + AFTER
        (name,) = rules(text)
        assert name in ("missing-parenthesis", "surplus-parenthesis")
        names = [getattr(form, "name", "") for form in parsed(text).forms]
        assert (names[0], names[-1]) == ("before", "after")
        assert not any("parenthesis" in rule for rule in rules(fixed(text)))


def test_nearly_all_lost_closing_parentheses_come_back_where_they_were() -> None:
    closing = [at for at in PLACES if SAMPLE[at] == ")"]
    back = [at for at in closing if fixed(SAMPLE[:at] + SAMPLE[at + 1 :]) == SAMPLE]
    assert len(back) >= 0.9 * len(closing)


TWO_SLIPS = """\
(define-rap (water-plant)
  (succeed (wet soil))
  (method can
    (context (have can)))
    (task-net (t1 (pour))))
  (method can
    (task-net (t1 (look-for-can)))))
"""


def test_two_methods_of_one_name_are_told_beside_a_parenthesis() -> None:
    """As in T's figure 5.16: no parenthesis can have made them one name."""
    assert rules(TWO_SLIPS) == ["surplus-parenthesis", "duplicate-method"]


@pytest.mark.parametrize("text", [TWO_SLIPS, TWO_SLIPS.replace("succeed", "success")])
def test_names_are_not_looked_up_where_parentheses_were_guessed_at(text: str) -> None:
    """Whatever else is told of the form."""
    found = check_library(load_text(text)).findings
    assert {one.diagnostic.rule for one in found} <= {
        *("surplus-parenthesis", "duplicate-method", "unknown-clause")
    }


@pytest.mark.parametrize("part", PARTS)
def test_a_part_alone_is_put_right_where_it_goes_on_too_long(part: str) -> None:
    text, (row, column) = PARTS[part]
    unit = parsed(text)
    (found,) = [d for d in unit.diagnostics if d.rule.endswith("-parenthesis")]
    assert found.rule == "surplus-parenthesis"
    place = unit.file.position(found.span.start)
    assert (place.row, place.column) == (row, column)


MISPLACED = """\
(define-rap (go ?place)
  (succeed (at ?place))
  (context (at home))
  (method
    (primitive (drive ?place)))
"""


def test_a_misplaced_clause_before_a_missing_parenthesis_is_one_finding() -> None:
    assert rules(MISPLACED) == ["missing-parenthesis"]
    assert fixed(MISPLACED) == f"{MISPLACED.rstrip()})\n"


def test_a_rap_closed_before_a_clause_in_its_line_is_one_finding() -> None:
    text = "(define-rap (go) (succeed (p))) (method (task-net)))"
    found = only(text)
    assert found.span.start == text.index(") (method")
    assert [shown(text, label.span) for label in found.labels] == ["(", ")"]
    assert fixed(text) == "(define-rap (go) (succeed (p)) (method (task-net)))"


def _contradicts(text: str) -> bool:
    """Whether a `)` is taken out where another one is put in."""
    fixes = [found.fix for found in parsed(text).diagnostics if found.fix]
    edits = [edit for fix in fixes for edit in fix.edits]
    put = {edit.span.start for edit in edits if edit.content.startswith(")")}
    for edit in edits:
        at = edit.span.start
        if not edit.content and text[at] == ")":
            run = re.compile(r"[)\s]*").match(text, at)
            if run and any(at <= other <= run.end() for other in put):
                return True
    return False


@pytest.mark.parametrize("seed", range(4))
def test_no_parenthesis_is_taken_out_where_one_is_put_in(seed: int) -> None:
    """A line in the middle of another form may reopen many lists."""
    dice = random.Random(f"contradictions:{seed}")
    texts = [slipped(dice.choice(shipped_raps()), dice) for _ in range(250)]
    assert [text for text in texts if _contradicts(text)] == []


def test_most_single_slips_are_one_finding_on_their_line() -> None:
    """Of 400 slips in shipped files 381 are one finding, 297 begin on the line."""
    dice = random.Random(5)
    alone = there = 0
    for _ in range(400):
        text, at = with_other_parenthesis(dice.choice(shipped_texts()), dice)
        unit = parsed(text)
        alone += len(unit.diagnostics) == 1
        starts = [found.span.start for found in unit.diagnostics[:1]]
        there += [unit.file.position(start).row for start in starts] == [
            text.count("\n", 0, at) + 1
        ]
    assert alone >= 375
    assert there >= 290
