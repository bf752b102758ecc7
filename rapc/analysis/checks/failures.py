"""RAP156: failures that a RAP with several methods does not tell apart."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Index
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes

_DOOR = """\
(declare-primitive turn-handle (?door) (okay locked stuck))
(declare-primitive kick (?door) (okay))
(declare-primitive unlock (?door) (okay))
(define-rap (open ?door)
  (method by-hand (primitive (turn-handle ?door)))
  (method with-force{} (primitive (kick ?door)))
  (method with-a-key{} (primitive (unlock ?door))))
"""

ALIKE = Rule(
    code="RAP156",
    name="failures-alike",
    severity=Severity.INFO,
    opt_in=True,
    summary="a RAP has other methods, and never asks how its primitive has failed",
    why="""A primitive that declares several failures says that there are several things
to do about them. Where they leave memory alike, only `last-result` and
`result-with-method` tell them apart (T 4.1.2); a RAP whose other methods do not ask
tries these in turn, whatever went wrong: a door that is locked is kicked. Methods that
serve against any failure need not ask; the rule is opt-in for that reason.""",
    ignore="where each method serves against any failure",
    source="T 4.1.2",
    example=_DOOR.format("", ""),
    better=_DOOR.format(
        "\n    (context (last-result stuck))\n   ",
        "\n    (context (last-result locked))\n   ",
    ),
)

_LEAST = 2
"""So many failures are worth telling apart, and so many methods have a choice."""


@check(ALIKE, needs_whole="form")
def failures(run: Pass) -> Iterator[Diagnostic]:
    """Find failures that a RAP with several methods does not tell apart."""
    index = run.result(INDEX)
    asked, asks_any = _asked(index)
    for rap in run.library.raps.values():
        if len(rap.methods) < _LEAST or id(rap) in asks_any or not run.complete:
            continue
        for method in rap.methods:
            if isinstance(method.body, nodes.Primitive):
                form = run.library.primitives.get(method.body.request.name)
                alike = _alike(form, asked) if form is not None else ()
                if form is not None and len(alike) >= _LEAST:
                    yield _finding(rap, method.body.request, form, alike)


def _asked(index: Index) -> tuple[set[object], set[int]]:
    """Return the results asked for by name, and the RAPs that ask for any result.

    A query that asks for any result serves whatever RAP names it.
    """
    named: set[object] = set()
    by: set[int] = set()
    for one in index.of(nodes.HistoryTest):
        result = one.node.args[-1] if one.node.args else None
        if one.node.query == "method-tried" or isinstance(result, nodes.Var):
            by.add(id(one.owner))
        elif isinstance(result, nodes.Const):
            named.add(result.value)
    queries = {
        one.owner.name
        for one in index.of(nodes.HistoryTest)
        if isinstance(one.owner, nodes.DefineQuery)
    }
    for fact in index.of(nodes.Proposition) if queries else ():
        if fact.node.name in queries:
            by.add(id(fact.owner))
    return named, by


def _alike(form: nodes.DeclarePrimitive, asked: set[object]) -> Sequence[str]:
    """Return the failures that nobody asks for and that leave memory alike."""
    told = {on.result: on.effects for on in form.on}
    failures = [name for name in form.results if name not in ("okay", *asked)]
    groups: dict[object, list[str]] = {}
    for name in failures:
        groups.setdefault(told.get(name, ()), []).append(name)
    return max(groups.values(), key=len, default=())


def _finding(
    rap: nodes.DefineRap,
    request: nodes.Request,
    form: nodes.DeclarePrimitive,
    alike: Sequence[str],
) -> Diagnostic:
    names = ", ".join(f"`{name}`" for name in alike[:-1]) + f" and `{alike[-1]}`"
    return ALIKE.at(
        request.span,
        f"no method of `{rap.name}` asks whether `{form.name}` has failed with {names}",
        labels=(Label(form.span, "declared here"),),
        help="ask `last-result` in the contexts of the other methods",
    )
