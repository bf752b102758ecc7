"""RAP087: rows of scripts that delay the end of a primitive that is atomic."""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.index import INDEX
from rapc.analysis.named import declared_at
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes

ATOMIC = Rule(
    code="RAP087",
    name="atomic-delay",
    severity=Severity.ERROR,
    summary="a row of a script has `:after`, and its primitive is atomic",
    why="""An atomic primitive holds the interpreter until it ends [L 3.72]; `:takes`
says how long that is. Only one that is declared with `:atomic false` ends later, while
others go on, as `:after` has it. The test fails before it begins.""",
    example="""\
(declare-primitive drive (?place) (okay))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-test later
  (script ((drive ?) okay :after 10))
  (task (go home)))
""",
    better="""\
(declare-primitive drive (?place) (okay) :atomic false)
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-test later
  (script ((drive ?) okay :after 10))
  (task (go home)))
""",
)


def _run(run: Pass) -> None:
    for one in run.result(INDEX).of(nodes.ScriptRow):
        row = one.node
        declared = run.signatures.primitives.get(row.request.name)
        form = run.library.primitives.get(row.request.name)
        if row.kind != "request" or row.after is None or form is None:
            continue
        if form.atomic and declared is not None:
            run.report(
                Diagnostic(
                    rule=ATOMIC.name,
                    message=f"`{form.name}` is atomic, so its end cannot come later",
                    span=row.span,
                    labels=(Label(declared_at(run, declared), "declared here"),),
                    help="write `:takes`, or declare it with `:atomic false`",
                )
            )


ANALYZER = Analyzer(
    name="atomic-delay",
    doc="Finds rows of scripts that delay the end of an atomic primitive.",
    run=_run,
    needs=(INDEX,),
    rules=(ATOMIC,),
)
