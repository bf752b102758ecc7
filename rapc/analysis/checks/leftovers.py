"""RAP160 and RAP161: inputs that their RAP never uses, and RAPs that nothing reaches.

Both are opt-in: a library for others may well hold what it does not use itself.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Index
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.ir import nodes

INPUT = Rule(
    code="RAP160",
    name="unused-input",
    severity=Severity.INFO,
    opt_in=True,
    summary="a RAP that has methods never uses one of its inputs",
    why="""Every step that asks for the RAP has to give a value for the input, and
nothing comes of it; a constant or another variable may stand where the input was meant.
Where several RAPs are to be asked for in one way, an input may be left unused on
purpose. The rule is opt-in for that reason.""",
    ignore="where several RAPs are to be asked for in one way",
    source="T 4.2",
    example="""\
(declare-primitive drive (?place) (okay))
(define-rap (go ?place)
  (method (primitive (drive dock))))
""",
    better="""\
(declare-primitive drive (?place) (okay))
(define-rap (go ?place)
  (method (primitive (drive ?place))))
""",
)

UNREACHED = Rule(
    code="RAP161",
    name="unreached-rap",
    severity=Severity.INFO,
    opt_in=True,
    summary="no task of an agenda leads to a RAP, though the library has agendas",
    why="""Agendas say what is to be done; what none of them asks for, directly or
through other RAPs, is never carried out: it is left over, or a step is missing that
should ask for it. Tasks of tests in the same file count too. What is given on a command
line, by a program, or by a test file of its own is not seen here. The rule is opt-in
for that reason.""",
    ignore="where the RAP is asked for on a command line, by a program or by other "
    "libraries",
    source="T 5.4",
    example="""\
(declare-primitive drive (?place) (okay))
(declare-primitive dock () (okay))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-rap (recharge) (method (primitive (dock))))
(define-agenda day (task (go home)))
""",
    better="""\
(declare-primitive drive (?place) (okay))
(declare-primitive dock () (okay))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-rap (recharge) (method (primitive (dock))))
(define-agenda day (task (go home)) (task (recharge)))
""",
)


@check(INPUT, UNREACHED, needs_whole="form")
def leftovers(run: Pass) -> Iterator[Diagnostic]:
    """Find inputs that their RAP never uses, and RAPs that nothing reaches."""
    index = run.result(INDEX)
    yield from _unused(run, index)
    read = not any(run.unsure(form.span) for form in run.library.forms)
    if run.library.agendas and run.complete and read:
        yield from _unreached(run, index)


def _unused(run: Pass, index: Index) -> Iterator[Diagnostic]:
    own = {id(v) for rap in run.library.raps.values() for v in rap.inputs}
    used = {
        (id(one.owner), one.node.name)
        for one in index.of(nodes.Var)
        if id(one.node) not in own
    }
    for rap in run.library.raps.values():
        for variable in rap.inputs if rap.methods else ():
            if not variable.anonymous and (id(rap), variable.name) not in used:
                yield INPUT.at(
                    variable.span,
                    f"`{rap.name}` never uses its input `{variable.name}`",
                    help="use it, or take it away here and where the RAP is asked for",
                )


def _unreached(run: Pass, index: Index) -> Iterator[Diagnostic]:
    calls: dict[str, list[str]] = {}
    waiting = []
    for goal in index.of(nodes.Goal):
        if isinstance(goal.owner, nodes.DefineRap):
            calls.setdefault(goal.owner.name, []).append(goal.node.name)
        else:
            waiting.append(goal.node.name)
    reached = set(waiting)
    while waiting:
        for name in calls.get(waiting.pop(), ()):
            if name not in reached:
                reached.add(name)
                waiting.append(name)
    for rap in run.library.raps.values():
        if rap.name not in reached:
            yield UNREACHED.at(
                rap.name_span,
                f"no task that is given here leads to `{rap.name}`",
                help="give it as a task, ask for it in a step, or take it away",
            )
