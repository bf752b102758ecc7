"""RAP084: claims of things that nobody else could want."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.index import INDEX, Occurrence
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.names import Suggestions, plural
from rapc.ir import nodes
from rapc.ir.printer import format_formula

UNUSED = Rule(
    code="RAP084",
    name="unused-claim",
    severity=Severity.INFO,
    summary="a method claims a thing that nothing uses and no other method claims",
    why="""A claim keeps others from what they use or claim themselves. Things are not
declared: one that nothing else names, with as many arguments, keeps nobody from
anything, and is likely misspelt or left over.""",
    example="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(define-rap (go ?to) (method (primitive (drive ?to))))
(define-rap (visit ?to)
  (method (claims weels) (task-net (t1 (go ?to)))))
""",
    better="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(define-rap (go ?to) (method (primitive (drive ?to))))
(define-rap (visit ?to)
  (method (claims wheels) (task-net (t1 (go ?to)))))
""",
)

_Sort = tuple[str, int]
"""A thing by its name and number of arguments."""


def _run(run: Pass) -> None:
    users: dict[_Sort, set[int]] = {}
    claims: list[Occurrence[nodes.Thing]] = []
    for thing in run.result(INDEX).of(nodes.Thing):
        users.setdefault(_sort(thing), set()).add(id(thing.parent))
        if isinstance(thing.parent, nodes.Method):
            claims.append(thing)
    lone = [claim for claim in claims if len(users[_sort(claim)]) == 1]
    kept = users.keys() - {_sort(claim) for claim in lone}
    near = Suggestions(sorted({name for name, _ in kept}))
    users_known = not any(run.unsure(one.span) for one in _offers(run))
    for claim in lone if run.complete and users_known else ():
        run.report(_finding(claim.node, near, users))


def _offers(run: Pass) -> Iterable[nodes.DeclarePrimitive | nodes.DeclareSkill]:
    """Return what may use things."""
    return (*run.library.primitives.values(), *run.library.skills.values())


def _sort(thing: Occurrence[nodes.Thing]) -> _Sort:
    return thing.node.name, len(thing.node.args)


def _finding(
    thing: nodes.Thing, near: Suggestions, users: Mapping[_Sort, object]
) -> Diagnostic:
    written = format_formula(thing)
    others = sorted(count for name, count in users if name == thing.name)
    others.remove(len(thing.args))
    help_ = near.did_you_mean(thing.name)
    if others:
        amount = plural(others[0], "argument") if others[0] else "no arguments"
        help_ = f"`{thing.name}` is named with {amount} elsewhere"
    return Diagnostic(
        rule=UNUSED.name,
        message=f"nothing else uses or claims `{written}`",
        span=thing.span,
        help=help_,
    )


ANALYZER = Analyzer(
    name="unused-claim",
    doc="Finds claims of things that nothing uses and no other method claims.",
    run=_run,
    needs=(INDEX,),
    rules=(UNUSED,),
)
