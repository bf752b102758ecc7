"""RAP029: a variable used once whose name is close to another of the same RAP.

T's printed code has such slips: one variable, spelled two ways. The language cannot
tell: a variable used once is a wildcard. Numbered and lettered names are left alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.index import INDEX, Form, Occurrence
from rapc.analysis.passes.bindings import BINDINGS
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
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

_MOST = 60
"""How long a name may be; nobody compares longer ones by eye."""

_TELLS_APART = re.compile(r"[0-9]+|-[a-z]$")
"""What tells names apart that come in rows: `?arm1`, `?arm-b`."""


def _run(run: Pass) -> None:
    missing = run.result(BINDINGS).missing
    for owner, names in _by_form(run.result(INDEX).of(nodes.Var)):
        if not isinstance(owner, nodes.DefineRap | nodes.DefineQuery):
            continue
        names.pop("?", None)
        unbound = {m.variable.name for m in missing.get(id(owner), ())}
        once = [n for n, uses in names.items() if len(uses) == 1 and n not in unbound]
        suspects = _suspects(once, names)
        close = _Close(names) if suspects else None
        for name in suspects:
            other = close.to(name) if close else None
            if other is not None and _is_slip(names[name][0], names[other]):
                run.report(_finding(names[name][0], names[other][0]))


ANALYZER = Analyzer(
    name="misspelt-variable",
    doc="Finds variables used once whose names are close to another's.",
    run=_run,
    needs=(INDEX, BINDINGS),
    rules=(MISSPELT,),
    needs_whole="form",
)


def _by_form(
    uses: Iterable[Occurrence[nodes.Var]],
) -> Iterator[tuple[Form, dict[str, list[nodes.Var]]]]:
    """Each form that has variables, with these by their names."""
    owner: Form | None = None
    names: dict[str, list[nodes.Var]] = {}
    for use in uses:
        if use.owner is not owner:
            if owner is not None:
                yield owner, names
            owner, names = use.owner, {}
        variable = use.node
        if variable.name in names:
            names[variable.name].append(variable)
        else:
            names[variable.name] = [variable]
    if owner is not None:
        yield owner, names


class _Close:
    """Finds names one slip away, by what is left of names that lose a letter."""

    def __init__(self, names: Iterable[str]) -> None:
        self._names: dict[str, list[str]] = {}
        for name in names:
            for short in _shortened(name):
                self._names.setdefault(short, []).append(name)

    def to(self, name: str) -> str | None:
        """The first name close to another, if any."""
        stem = _TELLS_APART.sub("", name)
        for short in _shortened(name):
            for other in self._names.get(short, ()):
                in_row = stem == _TELLS_APART.sub("", other)
                if other != name and not in_row and is_one_slip(name, other):
                    return other
        return None


def _shortened(name: str) -> Iterator[str]:
    """Yield `name`; if it is long enough, also `name` without each of its letters."""
    yield name
    if _is_long(name):
        for at in range(1, len(name)):
            yield name[:at] + name[at + 1 :]


def _is_long(name: str) -> bool:
    """Whether a name is long enough for a slip to show, and not absurdly long."""
    return _LEAST <= len(name) <= _MOST


def _suspects(once: Iterable[str], names: Iterable[str]) -> list[str]:
    """The names used once that may be a slip for another: one about as long."""
    lengths: dict[int, int] = {}
    for name in names:
        lengths[len(name)] = lengths.get(len(name), 0) + 1
    return [
        name
        for name in once
        if _is_long(name)
        and (
            lengths[len(name)] > 1
            or len(name) - 1 in lengths
            or len(name) + 1 in lengths
        )
    ]


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
