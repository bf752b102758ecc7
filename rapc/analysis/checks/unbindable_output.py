"""RAP028: an output that nothing in its RAP can bind [L 3.8, 3.9]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.bindings import sites
from rapc.analysis.facts.logic import is_never
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.names import nearest
from rapc.ir import clauses, nodes

UNBINDABLE = Rule(
    code="RAP028",
    name="unbindable-output",
    severity=Severity.WARNING,
    summary="an output variable is bound neither by `succeed` nor by any method",
    why="""Outputs take the bindings of `succeed`, else those of the method that
succeeded last. One that occurs in neither stays unbound, and so does the variable of
whoever asked for it. (A RAP without methods may get them from a problem solver; there
nothing is said.)""",
    ignore="where a problem solver adds methods that bind the output",
    source="T 4.2",
    example="""\
(declare-memory-proposition at (?thing ?place))
(define-rap (look-around))
(define-rap (look-for ?thing => ?place)
  (succeed (at ?thing ?spot))
  (method (task-net (t1 (look-around)))))
""",
    better="""\
(declare-memory-proposition at (?thing ?place))
(define-rap (look-around))
(define-rap (look-for ?thing => ?place)
  (succeed (at ?thing ?place))
  (method (task-net (t1 (look-around)))))
""",
)

_LOST = {c.word for c in clauses.RAP if c.required and not c.hands_on}
"""Clauses of which nothing reads the bindings."""


@check(UNBINDABLE, needs_whole="form")
def unbindable_output(run: Pass) -> Iterator[Diagnostic]:
    """Find outputs that neither `succeed` nor any method can bind."""
    for rap in run.library.forms:
        if not isinstance(rap, nodes.DefineRap) or not rap.outputs or not rap.methods:
            continue
        if is_never(rap.succeed):
            continue
        names = {
            site.name
            for site in sites(rap, run.library.functions)
            if not site.negated and site.clause not in _LOST
        }
        for output in rap.outputs:
            if output.name not in names:
                yield _unbindable(output, names)


def _unbindable(output: nodes.Var, names: set[str]) -> Diagnostic:
    near = nearest(output.name, names)
    return UNBINDABLE.at(
        output.span,
        f"nothing binds the output `{output.name}`",
        help=f"did you mean `{near}`?"
        if near
        else "bind it in `succeed`, in a context, or as the output of a step",
    )
