"""RAP105: outputs of steps that name what has a value already [L 3.59]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.walk import steps

TAKEN = Rule(
    code="RAP105",
    name="output-is-input",
    severity=Severity.WARNING,
    summary="a step is to hand out its result in an input, which has a value already",
    why="""An output that meets a variable with another value fails the step, with
`interference` [L 3.59]: it changes nothing. An input of the RAP, or of the very step,
has its value from the start, so the step ends well only if it finds that and nothing
else. Mostly another variable was meant; to make sure of a value, compare it in
`succeed` or in a context.""",
    ignore="where the step is to fail unless it finds this very value",
    source="T 4.2",
    example="""\
(define-rap (find ?thing => ?place))
(define-rap (fetch ?thing)
  (method (task-net (t1 (find ?thing => ?thing)))))
""",
    better="""\
(define-rap (find ?thing => ?place))
(define-rap (fetch ?thing)
  (method (task-net (t1 (find ?thing => ?)))))
""",
)


def _run(run: Pass) -> list[int]:
    """Report, and return the id of the RAP of each finding."""
    told: list[int] = []
    for rap in run.library.raps.values():
        inputs = {variable.name: variable for variable in rap.inputs}
        for method in rap.methods:
            for step in steps(method):
                for found in _taken(step.goal, inputs):
                    run.report(found)
                    told.append(id(rap))
    return told


ANALYZER = Analyzer(
    name="outputs",
    doc="Finds outputs of steps in variables that have a value already.",
    run=_run,
    rules=(TAKEN,),
    needs_whole="form",
)


def _taken(goal: nodes.Goal, inputs: dict[str, nodes.Var]) -> Iterator[Diagnostic]:
    given = {term.name: term for term in goal.args if isinstance(term, nodes.Var)}
    for output in goal.outputs:
        if not isinstance(output, nodes.Var) or output.anonymous:
            continue
        first = given.get(output.name) or inputs.get(output.name)
        if first is not None:
            yield Diagnostic(
                rule=TAKEN.name,
                message=f"`{output.name}` has a value already, which the output of "
                f"`{goal.name}` would have to be",
                span=output.span,
                labels=(Label(first.span, "it comes from here"),),
                help="name another variable, or write `?`",
            )
