"""RAP022: results that no task can ever see (T 4.1.2, semantics 3).

A task sees `okay`, the reasons of the interpreter, the results of declared primitives
and, where an event fails a primitive or a step, the event's name without its colon.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.names import Names
from rapc.analysis.occurrences import Occurrences
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.analysis.unknown import Unknown
from rapc.base.diagnostics import Rule, Severity
from rapc.ir import nodes
from rapc.library.library import Library

UNKNOWN = Rule(
    code="RAP022",
    name="unknown-result",
    severity=Severity.ERROR,
    summary="a result is asked for that nothing in the library can return",
    why="""Results come from primitives, which declare theirs, from events that fail a
step, and from the interpreter: `okay`, `no-method`, `interference`, `futile-loop` and
`signal`. A test for any other symbol never holds.""",
    example="""\
(declare-primitive arm-grasp (?thing) (okay arm-dropped))
(define-rap (grasp ?thing)
  (method
    (context (not (last-result arm-droped)))
    (primitive (arm-grasp ?thing))))
""",
    better="""\
(declare-primitive arm-grasp (?thing) (okay arm-dropped))
(define-rap (grasp ?thing)
  (method
    (context (not (last-result arm-dropped)))
    (primitive (arm-grasp ?thing))))
""",
)

REASONS = ("okay", "no-method", "interference", "futile-loop", "signal")
"""The results that come from the interpreter itself."""


def _run(run: Pass) -> None:
    known = {*REASONS, *_declared(run.library)}
    names = Names(known)
    unknown = Unknown(UNKNOWN, "nothing returns the result `{}`", names)
    for constant in _asked(run.result(OCCURRENCES)):
        value = constant.value
        if not isinstance(value, str) or value not in known:
            place = constant.span
            unknown.add(value if isinstance(value, str) else str(value), place)
    unknown.report(run)


ANALYZER = Analyzer(
    name="unknown-result",
    doc="Finds questions about results that nothing can return.",
    run=_run,
    needs=(OCCURRENCES,),
    rules=(UNKNOWN,),
)


def _declared(library: Library) -> Iterator[str]:
    for primitive in library.primitives.values():
        yield from primitive.results
    for name in library.events:
        yield name.removeprefix(":")


def _asked(occurrences: Occurrences) -> Iterator[nodes.Const]:
    """Every constant that stands for a result."""
    bound: set[tuple[int, str]] = set()
    for use in occurrences.of(nodes.HistoryTest):
        if use.node.query != "method-tried":
            result = use.node.args[-1]
            if type(result) is nodes.Const:
                yield result
            elif type(result) is nodes.Var:
                bound.add((id(use.owner), result.name))
    for test in occurrences.of(nodes.Compare) if bound else ():
        sides = (test.node.left, test.node.right)
        for one, other in (sides, sides[::-1]):
            asked = type(one) is nodes.Var and (id(test.owner), one.name) in bound
            if asked and type(other) is nodes.Const:
                yield other
    for case in occurrences.of(nodes.ResultCase):
        expected = case.node.result
        if isinstance(expected, nodes.Const) and expected.value != "succeed":
            yield expected
