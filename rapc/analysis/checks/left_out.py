"""Parts of RAPs that the planner does not see [L 10]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.ir import nodes
from rapc.library.operators import Model

LEFT_OUT = Rule(
    code="RAP202",
    name="left-out-of-planning",
    severity=Severity.INFO,
    opt_in=True,
    summary="the planner does not see a part of an operator or of a goal to plan for",
    ignore="where the part need not hold in a plan, or usually holds",
    source="T 7.4.1",
)


@check(LEFT_OUT, needs_whole="form")
def left_out(run: Pass) -> Iterator[Diagnostic]:
    """Find the parts that the model of the planner leaves out."""
    if not run.complete:
        return
    model = Model(run.library, run.signatures)
    for rap in run.library.raps.values():
        if rap.plan is not None:
            model.goal(rap)
    reported = set()
    for one in model.left_out:
        if one.span not in reported:
            reported.add(one.span)
            what = f"see this part of `{one.rap}`"
            if isinstance(one.part, nodes.DefineRap):
                what = f"use `{one.rap}`"
            yield LEFT_OUT.at(one.span, f"the planner does not {what}: {one.reason}")
