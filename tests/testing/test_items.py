"""What rows of a script and actions at a time do to items that data have introduced."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.testing.run import Outcome, run_case

from .small_suite import cases, happened

LIBRARY = """
(declare-primitive scan () (okay))
(declare-primitive grasp (?arm ?item) (okay dropped))
(declare-sensor-datum object-seen (?place ?item ?kind))
(declare-memory-property class (?item ?kind ?value) unknown)
(declare-memory-property location (?item ?place) unknown)
(declare-indistinct-class jug)

(define-rap (look-around)
  (method (primitive (scan))))

(define-rap (take ?arm ?item)
  (succeed (location ?item ?arm))
  (method (primitive (grasp ?arm ?item))))
"""
SEEN = """
  (world truck)
  (script ((scan) :data ((object-seen shelf cup gun) (object-seen shelf jug1 jug))))
  (task (look-around))
"""


def run(folder: Path, clauses: str) -> Outcome:
    """Run a test in which a cup and a jug are seen at time 0."""
    text = f"{LIBRARY}\n(define-test it {SEEN} {clauses})\n"
    return run_case(cases(folder, text)["it"])


def test_a_row_moves_an_item_by_its_variables_and_loses_another(tmp_path: Path) -> None:
    outcome = run(
        tmp_path,
        """
        (script ((grasp ?arm ?x) :moves ((?x ?arm)) :loses (item-1)))
        (at 1 (task (take left cup)))
        (expect (succeeds (take left cup))
                (primitives (scan) (grasp left cup))
                (memory (and (location cup left) (location item-1 unknown)))
                (memory (and (know-sensor-name cup) (know-sensor-name item-1 false))))
        """,
    )
    assert happened(outcome) == []


def test_a_row_speaks_of_items_by_the_names_of_memory(tmp_path: Path) -> None:
    outcome = run(
        tmp_path,
        """
        (script ((grasp ?arm jug1) :moves ((item-1 ?arm))))
        (at 1 (task (take left item-1)))
        (expect (succeeds (take left item-1)) (memory (location item-1 left)))
        """,
    )
    assert happened(outcome) == []


def test_items_move_and_go_by_themselves(tmp_path: Path) -> None:
    outcome = run(
        tmp_path,
        """
        (at 1 (moves (cup floor) (item-1 floor))
              (expect (memory (and (location cup floor) (location item-1 floor)))))
        (at 2 (loses item-1)
              (expect (memory (and (location cup floor) (location item-1 unknown)))))
        """,
    )
    assert happened(outcome) == []


@pytest.mark.parametrize(
    ("clauses", "message"),
    [
        (
            "(script ((grasp ?a ?x) :moves ((ghost ?a)))) (at 1 (task (take left it)))",
            "row (grasp left it): no handler has introduced an item `ghost`",
        ),
        (
            "(script ((grasp ?a ?x) :loses (?x))) (at 1 (task (take left it)))",
            "row (grasp left it): no handler has introduced an item `it`",
        ),
        ("(at 3 (loses 7))", "at 3: no handler has introduced an item `7`"),
        (
            "(at 3 (moves (ghost bay1)))",
            "at 3: no handler has introduced an item `ghost`",
        ),
    ],
)
def test_unknown_item_is_refused(tmp_path: Path, clauses: str, message: str) -> None:
    assert happened(run(tmp_path, clauses)) == [message]
