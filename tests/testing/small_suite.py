"""A small library, and tests of it that are written, found and run in one go."""

from __future__ import annotations

from pathlib import Path

from rapc.testing import discover
from rapc.testing.run import Case, Outcome, Wrap, run_case

LIBRARY = """\
(declare-primitive grab (?x) (okay dropped) :atomic false)
(declare-primitive look (?x) (okay nothing))
(declare-primitive say (?what) (okay))
(declare-sensor-datum sighting (?x))
(declare-event :bump (?side))
(declare-memory-proposition have (?x) "What the robot holds.")
(declare-memory-property where (?x ?place) unknown "Where things are.")

(define-rap (fetch ?x)
  (succeed (have ?x))
  (method by-hand (primitive (grab ?x))))

(define-rap (find ?x => ?place)
  (succeed (and (where ?x ?place) (n= ?place unknown)))
  (method (primitive (look ?x))))

(define-rap (tidy)
  (method (task-net (one (fetch cup) (for two)) (two (fetch box)))))

(define-rap (count-to ?n)
  (resources (counter ?done))
  (succeed (= (value ?done) ?n))
  (method (task-net (t1 (utter ?done) (counter-add ?done 1)))))

(define-rap (utter ?what) (method (primitive (say it))))

(define-rap (watch ?thing)
  (monitor-state (where ?thing here))
  (succeed (have ?thing))
  (method (primitive (grab ?thing))))

(define-rap (await ?side)
  (method (task-net (t1 (fetch cup) (wait-for (:bump ?side))))))
"""
GRAB = "((grab ?x) okay :takes 2 :asserts ((have ?x)))"
"""A row by which everything can be fetched, in 2 time units."""


def cases(folder: Path, text: str, name: str = "it.test.rap") -> dict[str, Case]:
    """The tests of a text that is put into a file, by their names."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    found = discover.find([path])
    assert found.reports == ()
    return {case.test.name: case for case in found.cases}


def run(folder: Path, clauses: str, seed: int = 0, wrap: Wrap | None = None) -> Outcome:
    """Run a test of the library above that consists of some clauses."""
    found = cases(folder, f"{LIBRARY}\n(define-test it {clauses})\n")
    return run_case(found["it"], seed, wrap)


def happened(outcome: Outcome) -> list[str]:
    """All that was not as expected, line by line."""
    return [line for failure in outcome.failures for line in failure.happened]
