"""RAP029: a variable used once whose name is close to another of the same RAP.

T's printed code has such slips: one variable, spelled two ways. The language cannot
tell: a variable used once is a wildcard. Numbered and lettered names are left alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, VariableAt
from rapc.analysis.facts.names import renaming
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity, Subject
from rapc.base.names import Close
from rapc.ir import nodes

MISSPELT = Rule(
    code="RAP029",
    name="misspelt-variable",
    severity=Severity.WARNING,
    summary="a variable is used only once, and another one is spelled almost so",
    why="""A variable that occurs once matches anything, so one variable spelled two
ways is two variables, and neither means what was meant. If anything will do, write a
bare `?`, or a name of its own.""",
    fix="unsafe: writes the variable that is spelled almost so",
    ignore="where the two names are meant: give one of them a name that is less like "
    "the other",
    source="T 4.1",
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


@check(MISSPELT, needs_whole="form")
def misspelt_variable(run: Pass) -> Iterator[Diagnostic]:
    """Find variables used once whose names are close to another's."""
    for owner, named in run.result(INDEX).variables():
        if not isinstance(owner, nodes.DefineRap | nodes.DefineQuery):
            continue
        names = named
        if "?" in named:
            names = {name: uses for name, uses in named.items() if name != "?"}
        once = [name for name, uses in names.items() if len(uses) == 1]
        suspects = _suspects(once, names)
        close = Close(names, THRESHOLDS.close_variable) if suspects else None
        for name in suspects:
            other = close.to(name) if close else None
            if other is not None and _is_slip(names[name][0][0], names[other]):
                yield _finding(run, names[name][0][0], names[other][0][0])


def _suspects(once: Iterable[str], names: Iterable[str]) -> list[str]:
    """The names used once that may be a slip for another: one about as long."""
    lengths: dict[int, int] = {}
    for name in names:
        lengths[len(name)] = lengths.get(len(name), 0) + 1
    return [
        name
        for name in once
        if (len(name) >= THRESHOLDS.close_variable - 1 and len(name) + 1 in lengths)
        or (
            len(name) >= THRESHOLDS.close_variable
            and (lengths[len(name)] > 1 or len(name) - 1 in lengths)
        )
    ]


def _is_slip(one: nodes.Var, others: Sequence[VariableAt]) -> bool:
    """Of two variables used once each, only the later one is taken for the slip.

    A short name is no slip for its plural: `?arm` and `?arms`.
    """
    other = others[0][0]
    if len(one.name) < THRESHOLDS.close_variable and other.name == f"{one.name}s":
        return False
    return len(others) > 1 or other.span.start < one.span.start


def _finding(run: Pass, variable: nodes.Var, close: nodes.Var) -> Diagnostic:
    return MISSPELT.at(
        variable.span,
        f"`{variable.name}` is used only here",
        labels=(Label(close.span, "a variable with a close name"),),
        help=f"did you mean `{close.name}`? if anything will do, write `?`",
        fix=renaming(run.library.files, variable.name, close.name, [variable.span]),
        about=(Subject(variable.span, variable.name),),
    )
