"""Words in events read as terms, and the patterns that meet events."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.base.values import Text
from rapc.testing.patterns import read_value
from rapc.testing.run import Status

from .small_suite import happened, run


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("box", "box"),
        ("12", 12),
        ("-2.50", -2.5),
        ("2.0", 2),
        ("12345678901234567890", 12345678901234567890),
        ("-", "-"),
        ('"a \\"b\\" (c)"', Text('a "b" (c)')),
        ("()", ()),
        ("(a (b 1) ?x)", ("a", ("b", 1), "?x")),
        ("#counter(3)", "#counter(3)"),
        ('(use #set(a "b)" 2) x)', ("use", '#set(a "b)" 2)', "x")),
        ("time 30", Text("time 30")),
        ("(a", Text("(a")),
        ("a)", Text("a)")),
        ("", Text("")),
    ],
)
def test_terms_are_read_back(text: str, value: object) -> None:
    assert read_value(text) == value


GIVEN = """
  (facts (where box here))
  (script ((grab box) dropped :times 1) ((grab box) :asserts ((have box)))
          ((look mug) :takes 3 :asserts ((where mug shelf)))
          ((say ?)))
  (task (watch box)) (at 5 (task (find mug))) (at 9 (task (count-to 2)))
"""
"""A run in which most kinds of events come."""


@pytest.mark.parametrize(
    "pattern",
    [
        "(task-created :goal (find mug) :priority 0 :task ?n)",
        "(task-created :goal (find ?what))",
        "(task-created :goal ?any)",
        "(task-succeeded :goal (find mug => shelf))",
        "(task-succeeded :goal (find mug => ?p) :outputs ((? shelf)))",
        "(task-succeeded :outputs ())",
        "(task-created :step t1 :parent ?task)",
        '(resource-changed :what "counter-add 1: #counter(2)")',
        "(method-chosen :method #1 :rap find)",
        "(method-chosen :bindings ((? 2) (? #counter(1))))",
        "(primitive-ended :data () :result okay :time 8)",
        "(primitive-ended :request (grab ?x) :cycle 1)",
        "(fact-asserted :fact (have ?what) :by handler)",
        "(fact-asserted :fact (where ?x ?y) :by user)",
    ],
)
def test_an_event_pattern_matches(tmp_path: Path, pattern: str) -> None:
    outcome = run(tmp_path, f"{GIVEN} (expect (trace {pattern}))")
    assert happened(outcome) == []


@pytest.mark.parametrize(
    "pattern",
    [
        "(task-created :goal (find cup))",
        "(task-created :goal (find mug => shelf))",
        "(task-created :goal (find))",
        "(task-created :goal find)",
        "(task-created :parent ? :goal (find ?))",
        "(task-created :parent null :goal (find ?))",
        "(fact-asserted :fact (where ?x ?x))",
        "(fact-asserted :fact (have box) :by user)",
        '(fact-asserted :fact (have "box"))',
        "(primitive-ended :data (a))",
        "(task-succeeded :outputs ((?x ?x)))",
    ],
)
def test_an_event_pattern_does_not_match(tmp_path: Path, pattern: str) -> None:
    outcome = run(tmp_path, f"{GIVEN} (expect (trace {pattern}))")
    assert outcome.status is Status.FAILED
    assert happened(outcome)[0] == "no event fits pattern 1"


def test_event_patterns_come_in_order_and_share_no_bindings(tmp_path: Path) -> None:
    one = "(task-succeeded :goal (watch ?x))"
    two = "(task-succeeded :goal (find ?x))"
    assert happened(run(tmp_path, f"{GIVEN} (expect (trace {one} {two}))")) == []
    assert happened(run(tmp_path, f"{GIVEN} (expect (trace {two} {one}))")) != []
    assert happened(run(tmp_path, f"{GIVEN} (expect (trace {one} {one}))")) != []


def test_one_variable_means_one_thing_in_a_goal(tmp_path: Path) -> None:
    given = "(script ((look mug) :asserts ((where mug mug)))) (task (find mug))"
    assert happened(run(tmp_path, f"{given} (expect (succeeds (find ?x) ?x))")) == []
    given = given.replace("mug mug", "mug shelf")
    assert happened(run(tmp_path, f"{given} (expect (succeeds (find ?x) ?x))")) != []


def test_late_input_counts(tmp_path: Path) -> None:
    """It is not bound when the task is made, and the task is not selected either."""
    rap = """)
      (define-rap (see-to)
        (method (task-net (t1 (find mug => ?place) (for t2)) (t2 (guard ?place)))))
      (define-rap (guard ?place) (monitor-state (have ?place)))
      (define-test other"""
    clauses = (
        "(script ((look ?) :asserts ((where mug shelf)))) (task (see-to)) (until 5)"
    )
    outcome = run(tmp_path, f"{clauses} (expect (active (guard shelf))) {rap}")
    assert happened(outcome) == []
