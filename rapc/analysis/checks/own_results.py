"""RAP154: results that the methods of a RAP cannot have.

A task remembers what its own methods ended with (T 4.1.2). Of a method with a primitive
that is one of the results that the primitive declares, or a reason of the interpreter.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.unknown_result import REASONS
from rapc.analysis.facts.index import INDEX
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.names import Suggestions
from rapc.ir import nodes

OTHERS = Rule(
    code="RAP154",
    name="impossible-result",
    severity=Severity.WARNING,
    summary="a RAP asks for a result that none of its own methods can have",
    why="""`last-result` and `result-with-method` speak of what the methods of the same
RAP ended with (T 4.1.2). A primitive ends with a result that it declares; one of
another primitive never comes up here, so the test never holds. The result of another
primitive was meant, or the test stands in the wrong RAP.""",
    ignore="where a problem solver brings a method that ends so",
    source="T 4.1.2",
    example="""\
(declare-primitive grasp (?thing) (okay slipped))
(declare-primitive drive (?place) (okay blocked))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-rap (take ?thing)
  (preconditions (not (last-result blocked)))
  (method (primitive (grasp ?thing))))
""",
    better="""\
(declare-primitive grasp (?thing) (okay slipped))
(declare-primitive drive (?place) (okay blocked))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-rap (take ?thing)
  (preconditions (not (last-result slipped)))
  (method (primitive (grasp ?thing))))
""",
)

_ASKS = 2
"""How many arguments `result-with-method` has."""


@check(OTHERS, needs_whole="form")
def own_results(run: Pass) -> Iterator[Diagnostic]:
    """Find questions about results that the RAP's own methods cannot have."""
    known = {r for form in run.library.primitives.values() for r in results(form)}
    by_name: dict[int, _ByName] = {}
    wrong: dict[int, list[tuple[nodes.Const, Sequence[_Answers]]]] = {}
    for asked in run.result(INDEX).of(nodes.HistoryTest):
        rap, test = asked.owner, asked.node
        if not isinstance(rap, nodes.DefineRap) or test.query == "method-tried":
            continue
        result = test.args[-1] if test.args else None
        if not isinstance(result, nodes.Const) or result.value not in known:
            continue
        if id(rap) not in by_name:
            by_name[id(rap)] = _by_name(run, rap)
        answers = by_name[id(rap)].get(_meant(test))
        own = {name for one in answers or () for name in results(one.form)}
        if answers and result.value not in {*own, *REASONS}:
            wrong.setdefault(id(rap), []).append((result, answers))
    for found in wrong.values():
        yield _finding(found)


def results(form: nodes.DeclarePrimitive) -> set[str]:
    """Return the results that the declaration of a primitive speaks of."""
    return {*form.results, *(on.result for on in form.on)}


class _Answers(msgspec.Struct, frozen=True):
    """A request of a method, and the declaration of its primitive."""

    request: nodes.Request
    form: nodes.DeclarePrimitive


_ByName = Mapping[object, Sequence[_Answers] | None]
"""The requests of the methods by their names, and of all by None."""


def _meant(test: nodes.HistoryTest) -> object:
    """The name of the method that a question is about; None for any."""
    if test.query == "last-result" or len(test.args) < _ASKS:
        return None
    first = test.args[0]
    return first.value if isinstance(first, nodes.Const) else None


def _by_name(run: Pass, rap: nodes.DefineRap) -> _ByName:
    """Return what methods ask for; None where one has another body, or is unknown."""
    found: dict[object, list[_Answers] | None] = {}
    for method in rap.methods:
        one = _answer(run, method)
        for name in {method.name, None}:
            there = found.setdefault(name, [])
            if one is None:
                found[name] = None
            elif there is not None:
                there.append(one)
    return found


def _answer(run: Pass, method: nodes.Method) -> _Answers | None:
    if not isinstance(method.body, nodes.Primitive):
        return None
    form = run.library.primitives.get(method.body.request.name)
    return None if form is None else _Answers(method.body.request, form)


def _finding(wrong: Sequence[tuple[nodes.Const, Sequence[_Answers]]]) -> Diagnostic:
    result, answers = wrong[0]
    names = ", ".join(dict.fromkeys(f"`{one.form.name}`" for one in answers))
    own = sorted({name for one in answers for name in results(one.form)})
    others = ", ".join(f"`{name}`" for name in own)
    further = [Label(other.span, "nor with this") for other, _ in wrong[1:]]
    asked = Label(answers[0].request.span, "this is asked for")
    return OTHERS.at(
        result.span,
        f"{names} never ends with `{result.value}`",
        labels=(asked, *further),
        help=Suggestions(own).did_you_mean(str(result.value)) or f"it has {others}",
    )
