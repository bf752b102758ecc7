"""RAP124 and RAP164: resources that nobody changes, or asks about.

What becomes of a resource that is handed to steps is looked up in their RAPs
(`rapc.analysis.facts.resources`); of one that goes elsewhere nothing is said.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.logic import literals, number_of
from rapc.analysis.facts.resources import FirstValues, Flow, flows, overall_use
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity, Subject
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
    ignore="where a host or a problem solver changes the resource",
    source="T 4.8.1",
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


UNREAD = Rule(
    code="RAP164",
    name="unread-resource",
    severity=Severity.INFO,
    opt_in=True,
    summary="a set or counter is changed, and nobody asks about it",
    why="""What a resource holds matters where a formula or a term asks for it, here or
in a RAP that it is handed to (T 4.8). A counter may still be there to show the
interpreter that a loop gets on, or to be seen in a trace. The rule is opt-in for that
reason.""",
    ignore="where a counter shows the interpreter that a loop gets on, or is there to "
    "be seen",
    source="T 4.8",
    example="""\
(declare-primitive load () (okay))
(define-rap (lift) (method (primitive (load))))
(define-rap (load-some)
  (resources (counter ?loaded))
  (method (task-net (t1 (lift) (counter-add ?loaded 1)))))
""",
    better="""\
(declare-primitive load () (okay))
(define-rap (lift) (method (primitive (load))))
(define-rap (load-some)
  (resources (counter ?loaded))
  (repeat-while (< (value ?loaded) 4))
  (method (task-net (t1 (lift) (counter-add ?loaded 1)))))
""",
)


@check(IDLE, UNREAD, needs_whole="form")
def idle_resource(run: Pass) -> Iterator[Diagnostic]:
    """Find resources that nothing changes, or changes the wrong way."""
    index = run.result(INDEX)
    if not index.of(nodes.Resource):
        return
    every = flows(index)
    for rap in run.library.raps.values():
        for resource in rap.resources:
            own = every[id(rap), resource.variable.name]
            yield from _judge(resource, overall_use(own, every, run.library), rap)


def _judge(
    resource: nodes.Resource, uses: Flow, rap: nodes.DefineRap
) -> Iterator[Diagnostic]:
    name = resource.variable.name
    if uses.escapes:
        return
    if not uses.asked:
        if not uses.changes:
            message = f"nobody uses the {resource.kind} `{name}`"
            yield _finding(resource, uses, message)
        else:
            yield _unread(resource, uses)
        return
    if not uses.changes and resource.initial is None:
        what = "put into" if resource.kind == "set" else "counted by"
        yield _finding(resource, uses, f"nothing is ever {what} `{name}`")
    elif not uses.changes and _is_awaited(uses, rap):
        message = f"nothing changes `{name}`, for which `succeed` waits"
        yield _finding(resource, uses, message)
    elif resource.kind == "set" and resource.initial is None:
        if all(change.op == "set-sub" for change in uses.changes):
            yield _finding(resource, uses, f"nothing is ever put into `{name}`")
    elif resource.kind == "counter":
        yield from _wrong_way(resource, uses, rap)


def _wrong_way(
    resource: nodes.Resource, uses: Flow, rap: nodes.DefineRap
) -> Iterator[Diagnostic]:
    """Yield a finding if a counter only goes away from what a clause waits for."""
    name, first = resource.variable.name, FirstValues((resource,))
    for clause, formula, sign in (
        ("succeed", rap.succeed, 1),
        ("repeat-while", rap.repeat_while, -1),
    ):
        way = sign * _wanted(formula, name, first if sign > 0 else FirstValues(()))
        if sign < 0 and first.fails(formula) is not None:
            continue
        if way and all(_way(change) == -way for change in uses.changes):
            turn = "fall" if way < 0 else "rise"
            yield _finding(
                resource,
                uses,
                f"`{clause}` waits for `{name}` to {turn}, and it never does",
            )
            return


def _unread(resource: nodes.Resource, uses: Flow) -> Diagnostic:
    return UNREAD.at(
        resource.variable.span,
        f"nobody asks what is in `{resource.variable.name}`"
        if resource.kind == "set"
        else f"nobody asks what `{resource.variable.name}` has come to",
        labels=tuple([Label(c.span, "changed here") for c in uses.changes[:2]]),
        about=(Subject(resource.variable.span, resource.variable.name),),
    )


def _finding(resource: nodes.Resource, uses: Flow, message: str) -> Diagnostic:
    changes = [Label(change.span, "changed here") for change in uses.changes]
    asked = [Label(one.span, "asked here") for one in uses.asked[:1]]
    return IDLE.at(
        uses.changes[0].span if uses.changes else resource.variable.span,
        message,
        labels=(*changes[1:3], *asked),
        about=(Subject(resource.variable.span, resource.variable.name),),
    )


def _is_awaited(uses: Flow, rap: nodes.DefineRap) -> bool:
    goal = rap.succeed
    if goal is None or isinstance(goal, nodes.Or):
        return False
    own = [one.span.start for one in uses.asked if one.span.file == goal.span.file]
    return any(goal.span.start <= start < goal.span.end for start in own)


def _wanted(goal: nodes.Formula | None, name: str, first: FirstValues) -> int:
    """Which way a counter has to go for `succeed` to hold: -1, 1, or 0 if not known."""
    parts = goal.parts if isinstance(goal, nodes.Or) else (goal,)
    for literal in (one for part in parts for one in literals(part)):
        test = literal.formula
        if not isinstance(test, nodes.Compare) or not literal.holds:
            continue
        if first.holds(test):
            continue
        for one, other, sign in (
            (test.left, test.right, 1),
            (test.right, test.left, -1),
        ):
            if _is_value(one, name) and number_of(other) is not None:
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
    amount = number_of(change.amount)
    if amount is None or amount <= 0:
        return 0
    return 1 if change.op == "counter-add" else -1
