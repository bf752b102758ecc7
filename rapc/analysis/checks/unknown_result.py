"""RAP022: results that no task can ever see [T 4.1.2] [L 3.54].

A task sees `okay`, the reasons of the interpreter, the results of declared primitives
and, where an event fails a primitive or a step, the event's name without its colon.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Form, Index
from rapc.analysis.facts.names import UnknownNames, declared_at
from rapc.analysis.renaming import renaming
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.names import Suggestions
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.signatures import Fault

UNKNOWN = Rule(
    code="RAP022",
    name="unknown-result",
    severity=Severity.ERROR,
    summary="a result is asked for, given or described that nothing can return",
    why="""Results come from primitives, which declare theirs, from events that fail a
step, and from the interpreter: `okay`, `no-method`, `interference`, `futile-loop` and
`signal`. A test for any other symbol never holds. In the script of a test a row answers
a request with one of the results of its primitive; an `:on` of that says what one of
them changes.""",
    fix="unsafe: writes the name that is spelled almost so, where there is one",
    source="T 4.1.2",
    example="""\
(declare-primitive arm-grasp (?thing) (okay arm-dropped))
(define-rap (grasp ?thing)
  (method
    (context (not (last-result arm-droped)))
    (primitive (arm-grasp ?thing))))
""",
    better="""\
(declare-primitive arm-grasp (?thing) (okay arm-dropped))
(define-rap (grasp ?thing)
  (method
    (context (not (last-result arm-dropped)))
    (primitive (arm-grasp ?thing))))
""",
)

REASONS = ("okay", "no-method", "interference", "futile-loop", "signal")
"""The results that come from the interpreter itself."""


@check(UNKNOWN)
def unknown_result(run: Pass) -> Iterator[Diagnostic]:
    """Find questions about results that nothing can return."""
    known = {*REASONS, *_declared(run.library)}
    names = Suggestions(known)
    unknown = UnknownNames(UNKNOWN)
    for constant, owner in _asked(run.result(INDEX)):
        value = constant.value
        if not isinstance(value, str) or value not in known:
            message = f"nothing returns the result `{value}`"
            word = str(value)
            help_, meant = names.did_you_mean(word), names.near(word)
            fault = Fault("unknown", message, help_, name=word, meant=meant)
            unknown.add(fault, constant.span, owner)
    yield from unknown.findings(run)
    for row in run.result(INDEX).of(nodes.ScriptRow):
        answered = row.node.kind == "request" and not row.node.refused
        result = row.node.result or "okay"
        wrong = run.signatures.no_result(row.node.request.name, result)
        if wrong is not None and answered:
            yield _no_result(run, row.node, wrong)
    for primitive in run.library.primitives.values():
        for on in primitive.on:
            wrong = run.signatures.no_result(primitive.name, on.result)
            if wrong is not None:
                yield _no_result(run, on, wrong)


def _declared(library: Library) -> Iterator[str]:
    for primitive in library.primitives.values():
        yield from primitive.results
        yield from (on.result for on in primitive.on)
    for name in library.events:
        yield name.removeprefix(":")


def _asked(index: Index) -> Iterator[tuple[nodes.Const, Form]]:
    """Every constant that stands for a result, with its top-level form."""
    bound: set[tuple[int, str]] = set()
    for use in index.of(nodes.HistoryTest):
        if use.node.query != "method-tried":
            result = use.node.args[-1]
            if type(result) is nodes.Const:
                yield result, use.owner
            elif type(result) is nodes.Var:
                bound.add((id(use.owner), result.name))
    for test in index.of(nodes.Compare) if bound else ():
        sides = (test.node.left, test.node.right)
        for one, other in (sides, sides[::-1]):
            asked = type(one) is nodes.Var and (id(test.owner), one.name) in bound
            if asked and type(other) is nodes.Const:
                yield other, test.owner
    for case in index.of(nodes.ResultCase):
        expected = case.node.result
        if isinstance(expected, nodes.Const) and expected.value != "succeed":
            yield expected, case.owner
    for fails in index.of(nodes.Fails):
        if isinstance(fails.node.result, nodes.Const):
            yield fails.node.result, fails.owner


def _no_result(
    run: Pass, place: nodes.ScriptRow | nodes.ResultEffects, wrong: Fault
) -> Diagnostic:
    assert wrong.declared is not None
    declared = declared_at(run, wrong.declared)
    return UNKNOWN.at(
        place.span,
        wrong.message,
        labels=(Label(declared, "its results are declared here"),),
        help=wrong.help,
        fix=renaming(run.library.files, wrong.name, wrong.meant, [place.span]),
    )
