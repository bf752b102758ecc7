"""RAP029: a variable used once whose name is close to another of the same RAP.

T's printed code has such slips: one variable, spelled two ways. The language cannot
tell: a variable used once is a wildcard. Numbered and lettered names are left alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.passes.bindings import BINDINGS
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes

MISSPELT = Rule(
    code="RAP029",
    name="misspelt-variable",
    severity=Severity.WARNING,
    summary="a variable is used only once, and another one is spelled almost so",
    why="""A variable that occurs once matches anything, so one variable spelled two
ways is two variables, and neither means what was meant. If anything will do, write a
bare `?`, or a name of its own.""",
    example="""\
(declare-memory-proposition inside (?thing ?box))
(define-rap (open ?container))
(define-rap (take-out ?thing)
  (preconditions (inside ?thing ?contaner))
  (method
    (context (inside ?thing ?container))
    (task-net (t1 (open ?container)))))
""",
    better="""\
(declare-memory-proposition inside (?thing ?box))
(define-rap (open ?container))
(define-rap (take-out ?thing)
  (preconditions (inside ?thing ?))
  (method
    (context (inside ?thing ?container))
    (task-net (t1 (open ?container)))))
""",
)

_LEAST = 5
"""How long a name must be, its mark included, to be close to another."""

_TELLS_APART = re.compile(r"(?:[0-9]+|-[a-z])$")
"""The end of names that come in rows: `?arm1`, `?arm-b`."""


def _run(run: Pass) -> None:
    missing = run.result(BINDINGS).missing
    seen: dict[int, dict[str, list[nodes.Var]]] = {}
    for use in run.result(OCCURRENCES).of(nodes.Var):
        if isinstance(use.owner, nodes.DefineRap) and not use.node.anonymous:
            names = seen.setdefault(id(use.owner), {})
            names.setdefault(use.node.name, []).append(use.node)
    for owner, names in seen.items():
        unbound = {m.variable.name for m in missing.get(owner, ())}
        for name, uses in names.items():
            if len(uses) == 1 and name not in unbound:
                close = _close(name, names)
                if close is not None and _is_slip(uses[0], names[close]):
                    run.report(_finding(uses[0], names[close][0]))


ANALYZER = Analyzer(
    name="misspelt-variable",
    doc="Finds variables used once whose names are close to another's.",
    run=_run,
    needs=(OCCURRENCES, BINDINGS),
    rules=(MISSPELT,),
)


def _close(name: str, names: Iterable[str]) -> str | None:
    if len(name) < _LEAST:
        return None
    stem = _TELLS_APART.sub("", name)
    for other in names:
        if abs(len(name) - len(other)) <= 1 and other != name:
            rows = stem == _TELLS_APART.sub("", other)
            if not rows and is_one_slip(name, other):
                return other
    return None


def _is_slip(one: nodes.Var, others: list[nodes.Var]) -> bool:
    """Of two variables used once each, only the later one is taken for the slip."""
    return len(others) > 1 or others[0].span.start < one.span.start


def is_one_slip(one: str, other: str) -> bool:
    """Whether one letter left out, put in, changed or swapped makes them equal."""
    start = 0
    while start < min(len(one), len(other)) and one[start] == other[start]:
        start += 1
    left, right = one[start:], other[start:]
    if len(left) == len(right):
        swapped = left[1::-1] == right[:2] and left[2:] == right[2:]
        return left[1:] == right[1:] or swapped
    longer, shorter = (left, right) if len(left) > len(right) else (right, left)
    return longer[1:] == shorter


def _finding(variable: nodes.Var, close: nodes.Var) -> Diagnostic:
    return Diagnostic(
        rule=MISSPELT.name,
        message=f"`{variable.name}` is used only here",
        span=variable.span,
        labels=(Label(close.span, "a variable with a close name"),),
        help=f"did you mean `{close.name}`? if anything will do, write `?`",
    )
