"""RAP124: resources that nobody changes in a way that anybody could notice.

What becomes of a resource is known where it stays in its RAP: one that is handed to
steps, or given a value by another resource, may be changed elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.first_values import FirstValues
from rapc.analysis.index import INDEX, Occurrence
from rapc.analysis.literals import literals, number
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes

IDLE = Rule(
    code="RAP124",
    name="idle-resource",
    severity=Severity.WARNING,
    summary="a set or counter is asked about, and nothing ever brings it there",
    why="""A counter that nothing counts, or that is only counted up where `succeed`
waits for it to fall, never gets there; a set that nothing is put into stays empty (T
4.8). The effect on the step is missing, or its verb is the wrong one. A resource that
nobody uses at all is left over.""",
    example="""\
(declare-primitive load () (okay))
(define-rap (lift) (method (primitive (load))))
(define-rap (load-all ?number)
  (resources (counter ?wanted ?number))
  (succeed (<= (value ?wanted) 0))
  (method (task-net (t1 (lift)))))
""",
    better="""\
(declare-primitive load () (okay))
(define-rap (lift) (method (primitive (load))))
(define-rap (load-all ?number)
  (resources (counter ?wanted ?number))
  (succeed (<= (value ?wanted) 0))
  (method (task-net (t1 (lift) (counter-sub ?wanted 1)))))
""",
)


class _Uses(msgspec.Struct):
    """What a RAP does with one of its resources."""

    resource: nodes.Resource
    changes: list[nodes.ResourceChange]
    #: Where it is asked about.
    asked: list[Span]
    #: Whether others may change it.
    shared: bool = False


def _run(run: Pass) -> None:
    found: dict[tuple[int, str], _Uses] = {}
    index = run.result(INDEX)
    for one in index.of(nodes.Resource):
        key = (id(one.owner), one.node.variable.name)
        found[key] = _Uses(one.node, [], [])
    if not found:
        return
    for variable in index.of(nodes.Var):
        uses = found.get((id(variable.owner), variable.node.name))
        if uses is not None and variable.node is not uses.resource.variable:
            _note(uses, variable)
    for (owner, _), uses in found.items():
        rap = next(r.node for r in index.of(nodes.DefineRap) if id(r.node) == owner)
        for finding in _judge(uses, rap):
            run.report(finding)


ANALYZER = Analyzer(
    name="idle-resource",
    doc="Finds resources that nothing changes, or changes the wrong way.",
    run=_run,
    needs=(INDEX,),
    rules=(IDLE,),
    needs_whole="form",
)


def _note(uses: _Uses, variable: Occurrence[nodes.Var]) -> None:
    parent = variable.parent
    if isinstance(parent, nodes.ResourceChange):
        if parent.resource is variable.node:
            uses.changes.append(parent)
    elif isinstance(parent, nodes.SetTest | nodes.Call):
        uses.asked.append(variable.node.span)
    else:
        uses.shared = True


def _judge(uses: _Uses, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    resource = uses.resource
    name = resource.variable.name
    if uses.shared:
        return
    if not uses.asked:
        if not uses.changes:
            yield _finding(uses, f"nobody uses the {resource.kind} `{name}`")
        return
    if not uses.changes and resource.initial is None:
        what = "put into" if resource.kind == "set" else "counted by"
        yield _finding(uses, f"nothing is ever {what} `{name}`")
    elif not uses.changes and _is_awaited(uses, rap):
        yield _finding(uses, f"nothing changes `{name}`, for which `succeed` waits")
    elif resource.kind == "set" and resource.initial is None:
        if all(change.op == "set-sub" for change in uses.changes):
            yield _finding(uses, f"nothing is ever put into `{name}`")
    elif resource.kind == "counter":
        way = _wanted(rap.succeed, name, FirstValues((resource,)))
        if way and all(_way(change) == -way for change in uses.changes):
            turn = "fall" if way < 0 else "rise"
            yield _finding(
                uses, f"`succeed` waits for `{name}` to {turn}, and it never does"
            )


def _finding(uses: _Uses, message: str) -> Diagnostic:
    changes = [Label(change.span, "changed here") for change in uses.changes]
    asked = [Label(span, "asked here") for span in uses.asked[:1]]
    return Diagnostic(
        rule=IDLE.name,
        message=message,
        span=uses.changes[0].span if uses.changes else uses.resource.variable.span,
        labels=(*changes[1:3], *asked),
    )


def _is_awaited(uses: _Uses, rap: nodes.DefineRap) -> bool:
    goal = rap.succeed
    if goal is None or isinstance(goal, nodes.Or):
        return False
    return any(goal.span.start <= span.start < goal.span.end for span in uses.asked)


def _wanted(goal: nodes.Formula | None, name: str, first: FirstValues) -> int:
    """Which way a counter has to go for `succeed` to hold: -1, 1, or 0 if not known."""
    for literal in literals(goal):
        test = literal.formula
        if not isinstance(test, nodes.Compare) or not literal.holds:
            continue
        if first.holds(test):
            continue
        for one, other, sign in (
            (test.left, test.right, 1),
            (test.right, test.left, -1),
        ):
            if _is_value(one, name) and number(other) is not None:
                return sign * _SIGNS.get(test.op, 0)
    return 0


_SIGNS = {"<": -1, "<=": -1, ">": 1, ">=": 1}


def _is_value(term: nodes.Term, name: str) -> bool:
    if not isinstance(term, nodes.Call) or term.function != "value":
        return False
    (arg,) = term.args if len(term.args) == 1 else (None,)
    return isinstance(arg, nodes.Var) and arg.name == name


def _way(change: nodes.ResourceChange) -> int:
    """Which way a change moves a counter; 0 if its amount is not known."""
    amount = number(change.amount)
    if amount is None or amount <= 0:
        return 0
    return 1 if change.op == "counter-add" else -1
