"""RAP070: a primitive that enables skills and awaits nothing [S 3.2]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.ir import nodes

NOTHING_AWAITED = Rule(
    code="RAP070",
    name="nothing-awaited",
    severity=Severity.WARNING,
    summary="a primitive enables skills and waits for no event",
    why="""Such a primitive ends well at once, and what it enabled is switched off with
it: the skills hardly run. To let them run, wait for the event that says that they are
done.""",
    ignore="where the skill does its work at once when it is switched on",
    source="S 3.2",
    example="""\
(declare-skill :follow-wall (?side))
(define-rap (follow ?side)
  (method (primitive (enable (:follow-wall ?side)))))
""",
    better="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall ?side))
    (wait-for (:wall-ends) :succeed))))
""",
)


@check(NOTHING_AWAITED, needs_whole="method")
def nothing_awaited(run: Pass) -> Iterator[Diagnostic]:
    """Find primitives that enable skills and wait for no event."""
    for use in run.result(INDEX).of(nodes.Skills):
        if use.node.enable and not use.node.waits:
            yield NOTHING_AWAITED.at(
                use.node.span,
                "this primitive awaits nothing and ends at once",
                help="add `(wait-for (:event) :succeed)`",
            )
