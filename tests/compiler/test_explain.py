"""What is told of the plans of queries, and that it is what they do."""

from __future__ import annotations

import pytest

from rapc.compiler.explain import describe, explain
from rapc.compiler.program import Program
from rapc.library.loader import load_text
from rapc.runtime.interpreter import Interpreter
from rapc.worlds.scripted import ScriptedWorld

LIBRARY = """\
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property class (?item ?class ?value) false)
(declare-memory-property size (?item ?size) nominal)
(declare-memory-proposition road (?from ?to ?kind))
(declare-memory-proposition wet (?place))
(declare-memory-function nominal)
(define-rap (fetch ?item ?from => ?way)
  (resources (set ?seen))
  (succeed (and (location ?item depot) (road ?from depot ?way)))
  (monitor-state (believe (location ?item ?from) 20))
  (preconditions (not (or (wet ?from) (class ?item fragile true))))
  (method straight
    (context (and (road ?from ?next ?kind) (road ?next depot ?kind)
                  (size ?item ?size) (> ?size 3) (class ?other ? true)
                  (not (member ?seen ?other)) (class ?item box false)))
    (task-net
      (t1 (fetch ?item ?next) ((road ?next ? ?any) for t2))
      (t2 (fetch ?item depot))))
  (method round
    (context (or (wet ?x) (road ?x ?y ?) (road ?p ?q ?p)))
    (task-net)))
"""

FUNCTIONS = {"nominal": lambda view, index: 1}

TOLD = """\
succeed at <text>:9 (?item ?from bound)
  (location ?item depot): check whether the fact is in memory
  (road ?from depot ?way): search the smaller set of the facts with ?from as \
argument 1 or depot as argument 2; compare with ?from, depot; bind ?way
monitor-state at <text>:10 (?item ?from bound)
  (believe (location ?item ?from) 20): look up the value of (location ?item); default \
`unknown` if there is no value; compare with ?from
preconditions at <text>:11 (?from ?item bound)
  no solution exists of:
    each branch in order:
      (wet ?from): check whether the fact is in memory
      (class ?item fragile true): check whether the fact is in memory
context of method `straight` at <text>:13 (?from ?item ?seen bound)
  (road ?from ?next ?kind): search the facts with ?from as argument 1; bind ?next \
?kind
  (road ?next depot ?kind): check whether the fact is in memory
  (size ?item ?size): look up the value of (size ?item); default `nominal` \
if there is no value; bind ?size
  (> ?size 3): test
  (class ?other ? true): search the facts with true as argument 3; bind ?other
  no solution exists of:
    (member ?seen ?other): test
  (class ?item box false): look up the value of (class ?item box); default \
`false` if there is no value; compare with false
`for t2` formula at <text>:17 (?next bound)
  (road ?next ? ?any): search the facts with ?next as argument 1; bind ?any
context of method `round` at <text>:20
  each branch in order:
    (wet ?x): search all facts of `wet`; bind ?x
    (road ?x ?y ?): search all facts of `road`; bind ?x ?y
    (road ?p ?q ?p): search all facts of `road`; bind ?p ?q
"""


def test_each_clause_is_told_as_it_is_asked() -> None:
    loaded = load_text(LIBRARY)
    assert loaded.diagnostics == ()
    lines = describe(explain(Program(loaded.library), "fetch"))
    assert "\n".join(lines) + "\n" == TOLD


def test_a_memory_says_how_many_facts_are_to_be_expected() -> None:
    library = Program(load_text(LIBRARY).library)
    run = Interpreter(
        library, ScriptedWorld([], declared=library.library), functions=FUNCTIONS
    )
    for place in ("barn", "dock", "mill"):
        run.assert_fact("wet", place)
        run.assert_fact("road", "yard", place, "paved")
    run.assert_fact("road", "barn", "mill", "muddy")
    lines = list(describe(explain(library, "fetch"), run.memory.spread))
    assert [line.split("; ")[0] for line in lines if "about" in line] == [
        "  (road ?from depot ?way): search the smaller set of the "
        "facts with ?from as argument 1 or depot as argument 2 (about "
        "1.3)",
        "  (road ?from ?next ?kind): search the facts with ?from as "
        "argument 1 (about 2)",
        "  (class ?other ? true): search the facts with true as argument 3 (about 0)",
        "  (road ?next ? ?any): search the facts with ?next as argument 1 (about 2)",
        "    (wet ?x): search all facts of `wet` (about 3)",
        "    (road ?x ?y ?): search all facts of `road` (about 4)",
        "    (road ?p ?q ?p): search all facts of `road` (about 4)",
    ]


def test_a_name_that_is_no_rap_is_refused() -> None:
    library = Program(load_text(LIBRARY).library)
    with pytest.raises(ValueError, match="unknown RAP `fech`; did you mean `fetch`"):
        explain(library, "fech")


CHOICE = """\
(declare-memory-proposition road (?from ?to))
(declare-memory-proposition wet (?place))
(define-query (way ?from ?to) (or (road ?from ?to) (road ?to ?from)))
(define-rap (go ?from ?to)
  (method straight (context (way ?from ?to)) (task-net))
  (method round
    (context (and (road ?from ?next) otherwise))
    (constraints (not (wet ?next)))
    (task-net))
  (method wait (context otherwise) (task-net)))
"""

OF_CHOICE = """\
context of method `straight` at <text>:5 (?from ?to bound)
  (way ?from ?to): the formula of the query:
    each branch in order:
      (road ?from ?to): check whether the fact is in memory
      (road ?to ?from): check whether the fact is in memory
context of method `round` at <text>:7 (?from bound)
  otherwise: check whether a preceding method holds
  (road ?from ?next): search the facts with ?from as argument 1; bind ?next
constraints of method `round` at <text>:8 (?next bound)
  no solution exists of:
    (wet ?next): check whether the fact is in memory
context of method `wait`
  otherwise: check whether a preceding method holds
"""


def test_queries_otherwise_and_constraints_of_methods_are_told() -> None:
    lines = describe(explain(Program(load_text(CHOICE).library), "go"))
    assert "".join(f"{line}\n" for line in lines) == OF_CHOICE
