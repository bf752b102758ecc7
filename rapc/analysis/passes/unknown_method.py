"""RAP067: questions about a method that the RAP does not have (T 4.1.2)."""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.names import Names
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.values import format_atom
from rapc.ir import nodes

UNKNOWN = Rule(
    code="RAP067",
    name="unknown-method",
    severity=Severity.ERROR,
    summary="`method-tried` or `result-with-method` names no method of its RAP",
    why="""These questions are about the methods of the RAP that asks them, by their
names. One that no method has was never tried and never had a result. (In a RAP without
methods of its own, a problem solver may bring methods with any name.)""",
    example="""\
(define-rap (knock))
(define-rap (ring))
(define-rap (call)
  (method bell (task-net (t1 (ring))))
  (method door (context (method-tried bel)) (task-net (t1 (knock)))))
""",
    better="""\
(define-rap (knock))
(define-rap (ring))
(define-rap (call)
  (method bell (task-net (t1 (ring))))
  (method door (context (method-tried bell)) (task-net (t1 (knock)))))
""",
)


def _run(run: Pass) -> None:
    for use in run.result(OCCURRENCES).of(nodes.HistoryTest):
        rap, history = use.owner, use.node
        if history.query == "last-result" or not isinstance(rap, nodes.DefineRap):
            continue
        asked = history.args[0]
        if not isinstance(asked, nodes.Const) or not rap.methods:
            continue
        names = [method.name for method in rap.methods if method.name is not None]
        if asked.value not in names:
            word = format_atom(asked.value)
            run.report(
                Diagnostic(
                    rule=UNKNOWN.name,
                    message=f"`{rap.name}` has no method called `{word}`",
                    span=asked.span,
                    help=Names(map(str, names)).did_you_mean(word),
                )
            )


ANALYZER = Analyzer(
    name="unknown-method",
    doc="Finds questions about methods that the RAP does not have.",
    run=_run,
    needs=(OCCURRENCES,),
    rules=(UNKNOWN,),
)
