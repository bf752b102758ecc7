"""RAP018 and RAP019: computed terms whose function is not declared, or not met.

The built-in functions are checked by the parser, which knows how many arguments they
take. Functions used as tests are facts to `fact_arity` and `undeclared_predicate`.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Index, NameUse
from rapc.analysis.facts.names import (
    unknown_names,
    wrong_arity,
    wrong_kind,
)
from rapc.base.diagnostics import Diagnostic, Rule, Severity, Subject
from rapc.ir import nodes
from rapc.ir.walk import variables

UNDECLARED = Rule(
    code="RAP018",
    name="undeclared-function",
    severity=Severity.ERROR,
    summary="a term is computed by a function that is not declared",
    why="""A list that stands as an argument is computed. Besides arithmetic, `size-of`
and `value` only declared functions can do that; a proposition or property has no value
there.""",
    fix="unsafe: writes the name that is spelled almost so, where there is one",
    source="T A.1",
    example="""\
(declare-memory-property size (?thing ?size) unknown)
(declare-memory-property room (?box ?size) unknown)
(define-rap (pack ?thing ?box)
  (preconditions (room ?box (size ?thing))))
""",
    better="""\
(declare-memory-property size (?thing ?size) unknown)
(declare-memory-property room (?box ?size) unknown)
(define-rap (pack ?thing ?box)
  (preconditions (and (size ?thing ?size) (room ?box ?size))))
""",
)

ARITY = Rule(
    code="RAP019",
    name="wrong-function-arity",
    severity=Severity.ERROR,
    summary="a declared function gets another number of arguments than was declared",
    why="""The function that the world or the host registers is called with what the
term gives it; with too much or too little the query fails.""",
    source="T A.1",
    example="""\
(declare-memory-function distance (?from ?to))
(define-rap (go ?from ?to)
  (duration (distance ?to)))
""",
    better="""\
(declare-memory-function distance (?from ?to))
(define-rap (go ?from ?to)
  (duration (distance ?from ?to)))
""",
)


@check(UNDECLARED, ARITY)
def functions(run: Pass) -> Iterator[Diagnostic]:
    """Find computed terms whose function is not declared, or not met."""
    about = partial(_variables, run.result(INDEX))
    yield from unknown_names(run, UNDECLARED, ("computed",), about)
    yield from wrong_arity(run, ARITY, ("computed",))
    yield from wrong_kind(run, UNDECLARED, ("computed",), about)


def _variables(index: Index, used: NameUse) -> Iterator[Subject]:
    """Yield the variables that a fact in place of a computed value was to bind."""
    here = index.at(used.span.file, used.span.start)
    compared = here is not None and isinstance(here.parent, nodes.Compare)
    place = here.parent if here is not None and compared else used.node
    for variable in variables(place):
        yield Subject(place.span, variable.name)
