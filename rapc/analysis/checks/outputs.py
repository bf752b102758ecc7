"""RAP105: outputs of steps that name what has a value already [L 3.59]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity, Subject
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


@check(TAKEN, needs_whole="form")
def outputs(run: Pass) -> Iterator[Diagnostic]:
    """Find outputs of steps in variables that have a value already."""
    for rap in run.library.raps.values():
        inputs = {variable.name: variable for variable in rap.inputs}
        for method in rap.methods:
            for step in steps(method):
                yield from _taken(step.goal, inputs)


def _taken(goal: nodes.Goal, inputs: dict[str, nodes.Var]) -> Iterator[Diagnostic]:
    given = {term.name: term for term in goal.args if isinstance(term, nodes.Var)}
    for output in goal.outputs:
        if not isinstance(output, nodes.Var) or output.anonymous:
            continue
        first = given.get(output.name) or inputs.get(output.name)
        if first is not None:
            yield TAKEN.at(
                output.span,
                f"`{output.name}` has a value already, which the output of "
                f"`{goal.name}` would have to be",
                labels=(Label(first.span, "it comes from here"),),
                help="name another variable, or write `?`",
                about=(Subject(output.span),),
            )
