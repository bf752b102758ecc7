"""RAP013 and RAP014: steps and rules that ask for a RAP that is not there.

T 4.2 and 4.5.2: a step is a pattern that must match the index of a RAP.
"""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.names import Names
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.analysis.unknown import Unknown
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.values import format_list
from rapc.ir import nodes
from rapc.library.library import word_span

UNKNOWN = Rule(
    code="RAP013",
    name="unknown-rap",
    severity=Severity.ERROR,
    summary="a step or a memory rule names a RAP that the library does not define",
    why="""A step asks for a RAP by its name. If no file that was read defines one of
that name, the method fails whenever it is chosen.""",
    example="""\
(define-rap (go-to ?place))
(define-rap (go-home)
  (method (task-net (t1 (goto depot)))))
""",
    better="""\
(define-rap (go-to ?place))
(define-rap (go-home)
  (method (task-net (t1 (go-to depot)))))
""",
)

ARITY = Rule(
    code="RAP014",
    name="wrong-step-arity",
    severity=Severity.ERROR,
    summary="a step gives a RAP another number of inputs or outputs than its index has",
    why="""A step has to match the index of the RAP it asks for: as many inputs, and
after `=>` as many outputs. An output that is not needed is written `?`.""",
    example="""\
(define-rap (look-for ?thing => ?place))
(define-rap (look)
  (method (task-net (t1 (look-for)))))
""",
    better="""\
(define-rap (look-for ?thing => ?place))
(define-rap (look)
  (method (task-net (t1 (look-for box => ?)))))
""",
)


def _run(run: Pass) -> None:
    raps = run.library.raps
    advice = "define it, or `require` the file that does"
    unknown = Unknown(UNKNOWN, "no RAP is called `{}`", Names(raps), advice)
    for use in run.result(OCCURRENCES).of(nodes.Goal):
        rap = raps.get(use.node.name)
        if rap is None:
            place = word_span(run.library.files, use.node.span, 0)
            unknown.add(use.node.name, place)
        else:
            is_rule = type(use.parent) is nodes.MemoryRule
            _check_arity(run, use.node, rap, outputs_optional=is_rule)
    unknown.report(run)


ANALYZER = Analyzer(
    name="unknown-rap",
    doc="Finds steps and memory rules whose RAP is not defined, or is not met.",
    run=_run,
    needs=(OCCURRENCES,),
    rules=(UNKNOWN, ARITY),
)


def _check_arity(
    run: Pass, goal: nodes.Goal, rap: nodes.DefineRap, *, outputs_optional: bool
) -> None:
    faults = []
    if len(goal.args) != len(rap.inputs):
        faults.append(_counts(len(rap.inputs), "input", len(goal.args)))
    if len(goal.outputs) != len(rap.outputs) and (goal.outputs or not outputs_optional):
        faults.append(_counts(len(rap.outputs), "output", len(goal.outputs)))
    if faults:
        arrow = ["=>", *(v.name for v in rap.outputs)] if rap.outputs else []
        index = format_list([rap.name, *(v.name for v in rap.inputs), *arrow])
        run.report(
            Diagnostic(
                rule=ARITY.name,
                message=f"`{goal.name}` has {' and '.join(faults)}",
                span=goal.span,
                labels=(Label(rap.name_span, f"its index is `{index}`"),),
                help="write `?` after `=>` for an output that is not needed"
                if not goal.outputs and "output" in faults[-1]
                else "",
            )
        )


def _counts(wanted: int, what: str, given: int) -> str:
    plural = "" if wanted == 1 else "s"
    return f"{wanted or 'no'} {what}{plural}, not {given}"
