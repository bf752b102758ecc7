"""RAP066: a set or counter where a plain value is needed [T 4.8.1] [L 6]."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Form, Index
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
    Subject,
)
from rapc.ir import nodes
from rapc.language.heads import CALLS

RESOURCE_AS_VALUE = Rule(
    code="RAP066",
    name="resource-as-value",
    severity=Severity.ERROR,
    summary="a set or counter stands where a plain value is needed",
    why="""A resource is a thing of its own, not the number or the members it holds now.
It equals no number, stands in no fact, and a request that holds one fails. Steps and
`resources` take it as it is, `value`, `size-of`, `member` and `empty` look into it.""",
    fix="unsafe: takes the `value` of a counter",
    source="T 4.8.1",
    example="""\
(define-rap (load))
(define-rap (load-some ?number)
  (resources (counter ?count 0))
  (succeed (= ?count ?number))
  (method (task-net (t1 (load) (counter-add ?count 1)))))
""",
    better="""\
(define-rap (load))
(define-rap (load-some ?number)
  (resources (counter ?count 0))
  (succeed (= (value ?count) ?number))
  (method (task-net (t1 (load) (counter-add ?count 1)))))
""",
)


@check(RESOURCE_AS_VALUE, needs_whole="method")
def resource_as_value(run: Pass) -> Iterator[Diagnostic]:
    """Find sets and counters where a plain value is needed."""
    index = run.result(INDEX)
    resources: dict[tuple[int, str], tuple[str, nodes.Var]] = {
        (id(use.owner), use.node.variable.name): (use.node.kind, use.node.variable)
        for use in index.of(nodes.Resource)
    }
    resources.update(_inputs(index))
    effects = {id(use.node.pattern) for use in index.of(nodes.DeclaredEffect)}
    for use in index.of(nodes.Var) if resources else ():
        key = (id(use.owner), use.node.name)
        if key not in resources or id(use.parent) in effects:
            continue
        kind, declared = resources[key]
        if use.node is declared or isinstance(use.parent, nodes.DefineRap):
            continue
        if _needs_value(use.node, use.parent, run.library.functions):
            yield _finding(use.node, kind, declared)
    for term, kind, declared in _handed_on(run, index, resources):
        yield _finding(term, kind, declared)


_Known = Mapping[tuple[int, str], tuple[str, nodes.Var]]
"""Resources by their form and name: the kind, and where they are declared."""


def _handed_on(
    run: Pass, index: Index, resources: _Known
) -> Iterator[tuple[nodes.Var, str, nodes.Var]]:
    """Yield resources that steps hand to inputs which are used as plain values only."""
    handed: dict[tuple[int, str], list[nodes.Var]] = {}
    owner_of: dict[int, Form] = {}
    for step in index.of(nodes.Goal) if resources else ():
        callee = run.library.raps.get(step.node.name)
        taken = callee.inputs if callee is not None else ()
        for term, variable in zip(step.node.args, taken, strict=False):
            if isinstance(term, nodes.Var) and (id(step.owner), term.name) in resources:
                handed.setdefault((id(callee), variable.name), []).append(term)
                owner_of[id(term)] = step.owner
    uses: dict[tuple[int, str], set[bool]] = {}
    for use in index.of(nodes.Var) if handed else ():
        key = (id(use.owner), use.node.name)
        if key in handed and not isinstance(use.parent, nodes.DefineRap):
            plain = _needs_value(use.node, use.parent, run.library.functions)
            uses.setdefault(key, set()).add(plain)
    for key, terms in handed.items():
        for term in terms if uses.get(key) == {True} else ():
            yield term, *resources[id(owner_of[id(term)]), term.name]


def _inputs(index: Index) -> Iterator[tuple[tuple[int, str], tuple[str, nodes.Var]]]:
    """Yield the inputs that their RAP changes as sets or counters."""
    for use in index.of(nodes.ResourceChange):
        rap, term = use.owner, use.node.resource
        if isinstance(rap, nodes.DefineRap) and isinstance(term, nodes.Var):
            for variable in rap.inputs:
                if variable.name == term.name:
                    kind = use.node.op.split("-")[0]
                    yield (id(rap), term.name), (kind, variable)


def _needs_value(
    variable: nodes.Var, parent: nodes.Node, functions: Container[str]
) -> bool:
    """Whether what a variable stands in takes plain values only."""
    match parent:
        case nodes.Goal() | nodes.Resource():
            needed = False
        case nodes.Pattern():
            needed = parent.name not in functions
        case nodes.Call():
            needed = parent.function in CALLS and parent.function not in _LOOK_INSIDE
        case nodes.SetTest():
            needed = variable is not parent.args[0]
        case nodes.ResourceChange():
            needed = variable is parent.amount
        case nodes.DefineRap():
            needed = variable is parent.duration
        case _:
            needed = True
    return needed


_LOOK_INSIDE = ("size-of", "value")


def _finding(variable: nodes.Var, kind: str, declared: nodes.Var) -> Diagnostic:
    counter = kind == "counter"
    content = f"(value {variable.name})"
    fix = Fix(Applicability.UNSAFE, "take its value", (Edit(variable.span, content),))
    return RESOURCE_AS_VALUE.at(
        variable.span,
        f"`{variable.name}` is a {kind}, not a plain value",
        labels=(Label(declared.span, "declared here"),),
        help=f"write `{content}` for the number it holds"
        if counter
        else f"ask `(member {variable.name} x)` or `(size-of {variable.name})`",
        fix=fix if counter else None,
        about=(Subject(variable.span, variable.name),),
    )
