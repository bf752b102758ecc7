"""RAP074: a step that is to go on until it ends or starts itself [L 4.27]."""

from __future__ import annotations

from collections import Counter

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.ir import nodes
from rapc.ir.walk import steps

ITSELF = Rule(
    code="RAP074",
    name="until-itself",
    severity=Severity.WARNING,
    summary="a step is to go on until it ends or starts itself",
    why="""`until-end` and `until-start` end a step for what another step does. With
its own tag such an annotation never does anything; another step is meant, or none.""",
    ignore="never: the annotation does nothing",
    source="T 4.5.2",
    example="""\
(define-rap (watch))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (t1 (watch) (until-end t1))
    (t2 (carry)))))
""",
    better="""\
(define-rap (watch))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (t1 (watch) (until-end t2))
    (t2 (carry)))))
""",
)


def _run(run: Pass) -> None:
    for rap in run.library.forms:
        if type(rap) is nodes.DefineRap:
            for method in rap.methods:
                often = Counter(step.tag for step in steps(method))
                for step in steps(method):
                    if often[step.tag] == 1:
                        _look(run, step)


def _look(run: Pass, step: nodes.Step) -> None:
    for annotation in step.annotations:
        if not isinstance(annotation, nodes.UntilStart | nodes.UntilEnd):
            continue
        if annotation.tag == step.tag:
            does = "ends" if type(annotation) is nodes.UntilEnd else "starts"
            run.report(
                Diagnostic(
                    rule=ITSELF.name,
                    message=f"step `{step.tag}` is to go on until it {does} itself",
                    span=annotation.span,
                    help="name another step, or take the annotation away",
                )
            )


ANALYZER = Analyzer(
    name="until-itself",
    doc="Finds steps that are to go on until something that they do themselves.",
    run=_run,
    rules=(ITSELF,),
)
