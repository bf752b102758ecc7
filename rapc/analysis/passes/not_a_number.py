"""RAP069: a constant that is no number where one is needed, or a zero that divides.

Only what stands in the text can be seen here; what variables hold, a run will tell.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.occurrences import Occurrences, Use
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.analysis.passes.predicates import PREDICATES
from rapc.analysis.vocabulary import Predicate
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.values import format_atom, is_number
from rapc.ir import nodes
from rapc.parser.names import CALLS

NOT_A_NUMBER = Rule(
    code="RAP069",
    name="not-a-number",
    severity=Severity.ERROR,
    summary="a constant that is no number stands where one is needed, or zero divides",
    why="""Arithmetic, times and amounts need numbers: with anything else the query
fails, and so does a division by zero. `<`, `>`, `<=` and `>=` never hold of anything
but two numbers, and a number never equals a symbol.""",
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
Table = Mapping[str, Sequence[nodes.Argument]]
"""Terms at fault with the end of the sentence that says why."""


def _run(run: Pass) -> None:
    occurrences = run.result(OCCURRENCES)
    for found in (
        _computed(occurrences),
        _compared(occurrences),
        _times(occurrences),
        _declared(run, occurrences),
    ):
        for term, why in found:
            run.report(
                Diagnostic(
                    rule=NOT_A_NUMBER.name,
                    message=f"{_word(term)} {why}",
                    span=term.span,
                )
            )


ANALYZER = Analyzer(
    name="not-a-number",
    doc="Finds constants that are no numbers where numbers are needed.",
    run=_run,
    needs=(OCCURRENCES, PREDICATES),
    rules=(NOT_A_NUMBER,),
)


def _word(term: nodes.Term) -> str:
    return f"`{format_atom(term.value)}`" if isinstance(term, nodes.Const) else "this"


def _is_other(term: nodes.Term | None) -> bool:
    """Whether a term is a constant other than a number."""
    return type(term) is nodes.Const and not is_number(term.value)


def _computed(occurrences: Occurrences) -> Found:
    for use in occurrences.of(nodes.Call):
        if use.node.function in ARITHMETIC:
            for arg in use.node.args:
                if _is_other(arg):
                    yield arg, "is no number to compute with"
        if use.node.function == "/":
            for arg in use.node.args[1:]:
                if isinstance(arg, nodes.Const) and arg.value == 0:
                    yield arg, "divides nothing"


def _compared(occurrences: Occurrences) -> Found:
    for use in occurrences.of(nodes.Compare):
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


def _times(occurrences: Occurrences) -> Found:
    for believe in occurrences.of(nodes.Believe):
        yield from _must_be_numbers("is no age", believe.node.age)
    for window in occurrences.of(nodes.Window):
        yield from _must_be_numbers("is no time", window.node.start, window.node.stop)
    for delay in occurrences.of(nodes.MonitorTime):
        yield from _must_be_numbers("is no time", delay.node.start, delay.node.stop)
    for rap in occurrences.of(nodes.DefineRap):
        yield from _must_be_numbers("is no time", rap.node.duration)
    for effect in occurrences.of(nodes.ResourceChange):
        if effect.node.op in ("counter-add", "counter-sub"):
            yield from _must_be_numbers("is no amount", effect.node.amount)
    for resource in occurrences.of(nodes.Resource):
        if resource.node.kind == "counter":
            yield from _must_be_numbers("is no number", resource.node.initial)


def _must_be_numbers(why: str, *terms: nodes.Term | None) -> Found:
    for term in terms:
        if term is not None and _is_other(term):
            yield term, why


def _declared(run: Pass, occurrences: Occurrences) -> Found:
    """Arguments that were declared to be numbers."""
    facts = _with_numbers(run.result(PREDICATES))
    requests = _with_numbers(run.library.primitives)
    uses: list[tuple[Table, Use[nodes.Proposition] | Use[nodes.Request]]] = []
    uses += [(facts, use) for use in occurrences.of(nodes.Proposition) if facts]
    uses += [(requests, use) for use in occurrences.of(nodes.Request) if requests]
    for table, use in uses:
        for term, arg in zip(use.node.args, table.get(use.node.name, ()), strict=False):
            if arg.kind == "number" and _is_other(term) and not _unknown(term):
                yield term, f"is no number, which `{arg.variable.name}` was declared"


def _with_numbers(
    declared: Mapping[str, Predicate] | Mapping[str, nodes.DeclarePrimitive],
) -> dict[str, Sequence[nodes.Argument]]:
    """The arguments of declarations that want a number among them."""
    args = {name: form.args or () for name, form in declared.items()}
    return {k: v for k, v in args.items() if any(arg.kind == "number" for arg in v)}


def _unknown(term: nodes.Term) -> bool:
    return isinstance(term, nodes.Const) and term.value == "unknown"
