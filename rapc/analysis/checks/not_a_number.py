"""RAP069: a constant that is no number where one is needed, or a zero that divides.

Only what stands in the text can be seen here; what variables hold, a run will tell.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Index, Occurrence
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.values import format_atom, is_number
from rapc.ir import nodes
from rapc.language.heads import CALLS

NOT_A_NUMBER = Rule(
    code="RAP069",
    name="not-a-number",
    severity=Severity.ERROR,
    summary="a constant that is no number stands where one is needed, or zero divides",
    why="""Arithmetic, times and amounts need numbers: with anything else the query
fails, and so does a division by zero. `<`, `>`, `<=` and `>=` never hold of anything
but two numbers, and a number never equals a symbol.""",
    source="T 4.1",
    example="""\
(declare-memory-property size (?thing ?size) unknown)
(define-rap (lift ?thing)
  (preconditions (and (size ?thing ?size) (< ?size small))))
""",
    better="""\
(declare-memory-property size (?thing ?size) unknown)
(define-rap (lift ?thing)
  (preconditions (and (size ?thing ?size) (< ?size 10))))
""",
)

ARITHMETIC = ("+", "-", "*", "/")

Found = Iterator[tuple[nodes.Term, str]]
"""Terms at fault with the end of the sentence that says why."""


@check(NOT_A_NUMBER)
def not_a_number(run: Pass) -> Iterator[Diagnostic]:
    """Find constants that are no numbers where numbers are needed."""
    index = run.result(INDEX)
    for found in (
        _computed(index),
        _compared(index),
        _times(index),
        _declared(run, index),
    ):
        for term, why in found:
            yield NOT_A_NUMBER.at(term.span, f"{_word(term)} {why}")


def _word(term: nodes.Term) -> str:
    return f"`{format_atom(term.value)}`" if isinstance(term, nodes.Const) else "this"


def _is_other(term: nodes.Term | None) -> bool:
    """Whether a term is a constant other than a number."""
    return type(term) is nodes.Const and not is_number(term.value)


def _computed(index: Index) -> Found:
    for use in index.of(nodes.Call):
        if use.node.function in ARITHMETIC:
            for arg in use.node.args:
                if _is_other(arg):
                    yield arg, "is no number to compute with"
        if use.node.function == "/":
            for arg in use.node.args[1:]:
                if isinstance(arg, nodes.Const) and arg.value == 0:
                    yield arg, "divides nothing"


def _compared(index: Index) -> Found:
    for use in index.of(nodes.Compare):
        sides = (use.node.left, use.node.right)
        if use.node.op in ("=", "n="):
            for one, other in (sides, sides[::-1]):
                computed = type(one) is nodes.Call and one.function in CALLS
                if computed and _is_other(other):
                    yield other, "never equals a number"
        else:
            for side in sides:
                if _is_other(side):
                    yield side, f"is no number, and `{use.node.op}` never holds of it"


def _times(index: Index) -> Found:
    for believe in index.of(nodes.Believe):
        yield from _must_be_numbers("is no age", believe.node.age)
    for window in index.of(nodes.Window):
        yield from _must_be_numbers("is no time", window.node.start, window.node.stop)
    for delay in index.of(nodes.MonitorTime):
        yield from _must_be_numbers("is no time", delay.node.start, delay.node.stop)
    for rap in index.of(nodes.DefineRap):
        yield from _must_be_numbers("is no time", rap.node.duration)
    for effect in index.of(nodes.ResourceChange):
        if effect.node.op.startswith("counter") and not _is_set(effect):
            yield from _must_be_numbers("is no amount", effect.node.amount)
    for resource in index.of(nodes.Resource):
        if resource.node.kind == "counter":
            yield from _must_be_numbers("is no number", resource.node.initial)


def _is_set(effect: Occurrence[nodes.ResourceChange]) -> bool:
    """Whether a set is changed as if it were a counter, which is told of already."""
    rap, term = effect.owner, effect.node.resource
    resources = rap.resources if isinstance(rap, nodes.DefineRap) else ()
    return any(one.kind == "set" and one.variable == term for one in resources)


def _must_be_numbers(why: str, *terms: nodes.Term | None) -> Found:
    for term in terms:
        if term is not None and _is_other(term):
            yield term, why


def _declared(run: Pass, index: Index) -> Found:
    """Arguments that were declared to be numbers."""
    if not any(named.kind == "number" for named in index.kinds()):
        return
    for used in index.uses():
        declared = run.signatures.table(used.use).get(used.name)
        args = declared.args if declared is not None else None
        for term, arg in zip(used.node.args, args or (), strict=False):
            if arg.kind == "number" and _is_other(term) and not _unknown(term):
                yield term, f"is no number, which `{arg.variable.name}` was declared"


def _unknown(term: nodes.Term) -> bool:
    return isinstance(term, nodes.Const) and term.value == "unknown"
