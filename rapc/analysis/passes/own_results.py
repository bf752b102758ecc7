"""RAP154: results that the methods of a RAP cannot have.

A task remembers what its own methods ended with (T 4.1.2). Of a method with a primitive
that is one of the results that the primitive declares, or a reason of the interpreter.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.index import INDEX
from rapc.analysis.passes.unknown_result import REASONS
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.names import Suggestions
from rapc.ir import nodes

OTHERS = Rule(
    code="RAP154",
    name="impossible-result",
    severity=Severity.WARNING,
    summary="a RAP asks for a result that none of its own methods can have",
    why="""`last-result` and `result-with-method` speak of what the methods of the same
RAP ended with (T 4.1.2). A primitive ends with a result that it declares; one of
another primitive never comes up here, so the test never holds. The result of another
primitive was meant, or the test stands in the wrong RAP.""",
    example="""\
(declare-primitive grasp (?thing) (okay slipped))
(declare-primitive drive (?place) (okay blocked))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-rap (take ?thing)
  (preconditions (not (last-result blocked)))
  (method (primitive (grasp ?thing))))
""",
    better="""\
(declare-primitive grasp (?thing) (okay slipped))
(declare-primitive drive (?place) (okay blocked))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-rap (take ?thing)
  (preconditions (not (last-result slipped)))
  (method (primitive (grasp ?thing))))
""",
)

_ASKS = 2
"""How many arguments `result-with-method` has."""


def _run(run: Pass) -> None:
    known = {r for form in run.library.primitives.values() for r in form.results}
    for asked in run.result(INDEX).of(nodes.HistoryTest):
        rap, test = asked.owner, asked.node
        if not isinstance(rap, nodes.DefineRap) or test.query == "method-tried":
            continue
        result = test.args[-1] if test.args else None
        if not isinstance(result, nodes.Const) or result.value not in known:
            continue
        forms = list(_primitives(run, _meant(rap, test)))
        own = {name for form in forms if form for name in form.results}
        if forms and None not in forms and result.value not in {*own, *REASONS}:
            run.report(_finding(result, [form for form in forms if form], own))


ANALYZER = Analyzer(
    name="own-results",
    doc="Finds questions about results that the RAP's own methods cannot have.",
    run=_run,
    needs=(INDEX,),
    rules=(OTHERS,),
    needs_whole="form",
)


def _meant(rap: nodes.DefineRap, test: nodes.HistoryTest) -> list[nodes.Method]:
    """The methods that a question is about."""
    if test.query == "last-result" or len(test.args) < _ASKS:
        return list(rap.methods)
    first = test.args[0]
    if not isinstance(first, nodes.Const):
        return list(rap.methods)
    return [method for method in rap.methods if method.name == first.value]


def _primitives(
    run: Pass, methods: list[nodes.Method]
) -> Iterator[nodes.DeclarePrimitive | None]:
    """Yield the primitives of methods; None for one that has another body."""
    for method in methods:
        if isinstance(method.body, nodes.Primitive):
            yield run.library.primitives.get(method.body.request.name)
        else:
            yield None


def _finding(
    result: nodes.Const, forms: list[nodes.DeclarePrimitive], own: set[str]
) -> Diagnostic:
    names = ", ".join(dict.fromkeys(f"`{form.name}`" for form in forms))
    others = ", ".join(f"`{name}`" for name in sorted(own))
    return Diagnostic(
        rule=OTHERS.name,
        message=f"{names} never ends with `{result.value}`",
        span=result.span,
        labels=tuple([Label(form.span, "declared here") for form in forms[:1]]),
        help=Suggestions(own).did_you_mean(str(result.value)) or f"it has {others}",
    )
