"""RAP123: a RAP that needs itself, with the inputs that it was given [L 3.42].

Steps whose inputs are inputs of their RAP or constants hand them on unchanged. A walk
along these leads back to the RAP with the inputs that it began with, or does not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.graph import components
from rapc.ir import nodes
from rapc.ir.printer import format_goal
from rapc.ir.walk import steps

ITSELF = Rule(
    code="RAP123",
    name="needs-itself",
    severity=Severity.WARNING,
    summary="a RAP needs itself, with the inputs that it was given",
    why="""A task that has an equal one among those above it can never be done: the
method that asks for it fails before it starts, `futile-loop` (T 3.2.5). A step may ask
for its own RAP with other inputs: to clear what lies below by clearing what lies on
top.""",
    ignore="never: the step fails as futile each time",
    source="T 3.2.5",
    example="""\
(define-rap (find ?thing)
  (method (task-net (t1 (find ?thing)))))
""",
    better="""\
(define-rap (look-for ?thing))
(define-rap (find ?thing)
  (method (task-net (t1 (look-for ?thing)))))
""",
)

_FAR = 6
"""So many RAPs a walk leads through at most."""

_MOST = 80
"""So many steps a walk takes at most."""


class _Call(msgspec.Struct, frozen=True):
    """A step that hands on inputs and constants alone."""

    step: nodes.Step
    #: The inputs: positions among those of the caller, or constants.
    args: tuple[int | nodes.Const, ...]


_Calls = Mapping[str, Sequence[_Call]]


@check(ITSELF, needs_whole="method")
def needs_itself(run: Pass) -> Iterator[Diagnostic]:
    """Find RAPs that need themselves, with the inputs that they were given."""
    calls = {
        rap.name: made
        for rap in run.library.raps.values()
        if (made := list(_handed_on(rap)))
    }
    told: set[int] = set()
    circling = _circling(calls)
    for rap in run.library.raps.values() if circling else ():
        path = _way_back(rap, calls) if rap.name in circling else None
        if path and not any(id(step) in told for step in path):
            told.update(id(step) for step in path)
            yield _finding(rap, path)


def _circling(calls: _Calls) -> set[str]:
    """Return the RAPs that calls lead back to, whatever these hand on."""
    names = {
        name: [call.step.goal.name for call in made] for name, made in calls.items()
    }
    return {
        name
        for circle in components(names, lambda name: names.get(name, ()))
        for name in circle
        if len(circle) > 1 or name in names.get(name, ())
    }


def _handed_on(rap: nodes.DefineRap) -> list[_Call]:
    places = {variable.name: at for at, variable in enumerate(rap.inputs)}
    found = []
    for method in rap.methods:
        for step in steps(method):
            args = [_handed(term, places) for term in step.goal.args]
            known = tuple([arg for arg in args if arg is not None])
            if len(known) == len(args):
                found.append(_Call(step, known))
    return found


def _handed(term: nodes.Term, places: Mapping[str, int]) -> int | nodes.Const | None:
    if isinstance(term, nodes.Const):
        return term
    return places.get(term.name) if isinstance(term, nodes.Var) else None


def _way_back(rap: nodes.DefineRap, calls: _Calls) -> list[nodes.Step] | None:
    """Return the steps along which a RAP needs itself, or None."""
    start: tuple[int | nodes.Const, ...] = tuple(range(len(rap.inputs)))
    waiting = [(rap.name, start, list[nodes.Step]())]
    seen = {(rap.name, start)}
    for _ in range(_MOST):
        if not waiting:
            return None
        name, args, path = waiting.pop(0)
        for call in calls.get(name, ()) if len(path) < _FAR else ():
            goal = call.step.goal.name
            if any(isinstance(a, int) and a >= len(args) for a in call.args):
                continue
            given = tuple([args[a] if isinstance(a, int) else a for a in call.args])
            if goal == rap.name and given == start:
                return [*path, call.step]
            if (goal, given) not in seen:
                seen.add((goal, given))
                waiting.append((goal, given, [*path, call.step]))
    return None


def _finding(rap: nodes.DefineRap, path: Sequence[nodes.Step]) -> Diagnostic:
    through = [f"`{step.goal.name}`" for step in path[:-1]]
    said = f", through {', '.join(through)}" if through else ""
    return ITSELF.at(
        path[0].goal.span,
        f"`{rap.name}` needs itself, with the inputs it was given{said}",
        labels=tuple(
            Label(step.goal.span, f"which needs `{format_goal(step.goal)}`")
            for step in path[1:]
        ),
        help="ask for another RAP, or for the same with other inputs",
    )
