"""RAP087: rows of a script that say what cannot be of a request or a skill."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes

IMPOSSIBLE_ROW = Rule(
    code="RAP087",
    name="impossible-row",
    severity=Severity.ERROR,
    summary="a row of a script says what its request or skill cannot do",
    why="""An atomic primitive holds the interpreter until it ends [L 3.72], so it does
not end `:after` it was asked for. A skill has no result and sends no data; only a skill
tells its signals with waits between them, or again and again; what goes off neither
waits nor is refused.""",
    source="L 3.72",
    example="""\
(declare-primitive drive (?place) (okay))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-test it-gets-there
  (script ((drive dock) :after 5))
  (task (go dock))
  (expect (succeeds (go dock))))
""",
    better="""\
(declare-primitive drive (?place) (okay) :atomic false)
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-test it-gets-there
  (script ((drive dock) :after 5))
  (task (go dock))
  (expect (succeeds (go dock))))
""",
)


@check(IMPOSSIBLE_ROW)
def impossible_row(run: Pass) -> Iterator[Diagnostic]:
    """Find rows of scripts that say what their request or skill cannot do."""
    for use in run.result(INDEX).of(nodes.ScriptRow):
        row = use.node
        wrong = _of_request(row) if row.kind == "request" else _of_skill(row)
        for message in wrong:
            yield IMPOSSIBLE_ROW.at(row.span, message)
        declared = run.library.primitives.get(row.request.name)
        later = row.kind == "request" and row.after is not None
        if later and declared is not None and declared.atomic:
            yield _atomic(row, declared)


def _atomic(row: nodes.ScriptRow, declared: nodes.DeclarePrimitive) -> Diagnostic:
    name = declared.name
    return IMPOSSIBLE_ROW.at(
        row.span,
        f"`{name}` is declared atomic, so it does not end `:after` its request",
        labels=(Label(declared.span, "declared here"),),
        help="declare it with `:atomic false`, or say how long it `:takes`",
    )


def _of_request(row: nodes.ScriptRow) -> Iterator[str]:
    if row.every is not None or row.pauses:
        yield "only a skill tells signals with waits between them, or again"


def _of_skill(row: nodes.ScriptRow) -> Iterator[str]:
    """Yield what a row of a skill says that cannot be said of one."""
    off = row.kind == "disable"
    given = (
        ("result", row.result is not None),
        ("`:takes`", bool(row.takes)),
        ("`:data`", bool(row.data)),
        ("`:after`", off and row.after is not None),
        ("`:every`", off and row.every is not None),
        ("`:refused`", off and row.refused),
        ("wait between signals", off and bool(row.pauses)),
    )
    for what, said in given:
        if said:
            yield f"a skill that {'goes off' if off else 'is enabled'} has no {what}"
