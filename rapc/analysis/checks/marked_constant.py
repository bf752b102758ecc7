"""RAP104: a variable that stands where its name, without the mark, is a constant."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.bindings import BINDINGS
from rapc.analysis.checks.constants import CONSTANTS
from rapc.analysis.facts.index import INDEX, Form, VariableAt
from rapc.analysis.facts.usage import (
    CENSUS,
    PLACE_KINDS,
    PLACES,
    Census,
    Constant,
    Place,
    PlaceKinds,
    sort_of,
)
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.ir import nodes

MARKED = Rule(
    code="RAP104",
    name="marked-constant",
    severity=Severity.WARNING,
    summary="a variable is used only once, and its name is a constant of that place",
    why="""A variable that occurs once matches anything: `(door front ?open)` holds of a
door that is shut. Where the library has a constant of that name at the same place, or a
closed kind lists it, the constant was meant, and the question mark is one too many. If
anything will do, write a bare `?`, or another name; then nothing is reported.""",
    fix="unsafe: takes the question mark away",
    ignore="where anything will do and the name is to say what stands there: write "
    "another name",
    source="T 4.1",
    example="""\
(declare-memory-property door (?door ?state) unknown)
(declare-primitive drive (?door) (okay))
(declare-primitive push (?door) (okay))
(define-rap (pass ?door)
  (method (context (door ?door ?open)) (primitive (drive ?door))))
(define-rap (shut ?door)
  (method (context (door ?door open)) (primitive (push ?door))))
""",
    better="""\
(declare-memory-property door (?door ?state) unknown)
(declare-primitive drive (?door) (okay))
(declare-primitive push (?door) (okay))
(define-rap (pass ?door)
  (method (context (door ?door open)) (primitive (drive ?door))))
(define-rap (shut ?door)
  (method (context (door ?door open)) (primitive (push ?door))))
""",
)


@check(MARKED, needs_whole="form")
def marked_constant(run: Pass) -> Iterator[Diagnostic]:
    """Find variables used once that are named like a constant of their place."""
    kinds = run.result(PLACE_KINDS)
    places = run.result(PLACES)
    missing = run.result(BINDINGS).missing
    constants = run.result(CONSTANTS).value
    census = run.result(CENSUS)
    for variable, owner in _used_once(run):
        there = places.of(owner, variable.name)
        if not there or (id(owner), variable.name) in constants:
            continue
        (place,) = there
        if any(m.variable is variable for m in missing.get(id(owner), ())):
            continue
        wanted = kinds.of((place,))
        others = list(_others(census, kinds, variable.name[1:], place))
        others = [o for o in others if (id(o.form), variable.name) not in constants]
        if _are_sure(others, owner):
            yield _finding(variable, others[0].const.span)
        elif any(_lists(run, kind, variable.name[1:]) for kind in wanted):
            yield _finding(variable, None)


_ENOUGH = 4
"""So many constants of a place are kept of those that are the same."""


def _others(
    census: Census, kinds: PlaceKinds, word: str, place: Place
) -> Iterator[Constant]:
    """Yield constants of a name at a place, and at places of its kinds."""
    every = census.standing(word) if sort_of(word) not in ("number", "text") else ()
    told = [c for c in every if c.count and type(c.form) is not nodes.DefineTest]
    yield from [one for one in told if place in one.places][:_ENOUGH]
    for kind in kinds.of((place,)):
        yield from [one for one in told if kind in kinds.of(one.places)][:_ENOUGH]


def _used_once(run: Pass) -> Iterator[tuple[nodes.Var, Form]]:
    """Yield variables that occur once in a form with a body, with the form."""
    for owner, names in run.result(INDEX).variables():
        for name, uses in names.items() if isinstance(owner, _BODIES) else ():
            if len(uses) == 1 and name != "?" and not _is_declared(uses[0]):
                yield uses[0][0], owner


_BODIES = (nodes.DefineRap, nodes.DefineQuery, nodes.MemoryRule, nodes.EventRule)


def _is_declared(use: VariableAt) -> bool:
    """Whether this is where an input, an output or an argument is declared."""
    _, parent, own = use
    return parent is own or isinstance(parent, nodes.Argument | nodes.Resource)


def _are_sure(constants: Sequence[Constant], owner: Form) -> bool:
    """Whether constants are more than one word that may itself lack its mark."""
    elsewhere = any(one.form is not owner for one in constants)
    return elsewhere or len({one.const.span for one in constants}) > 1


def _lists(run: Pass, kind: str, word: str) -> bool:
    return word in (run.signatures.kinds.values(kind) or ())


def _finding(variable: nodes.Var, other: Span | None) -> Diagnostic:
    word = variable.name[1:]
    fix = Fix(Applicability.UNSAFE, f"write `{word}`", (Edit(variable.span, word),))
    return MARKED.at(
        variable.span,
        f"`{variable.name}` is used only here, and matches anything",
        labels=(Label(other, "the constant stands here"),) if other else (),
        help=f"did you mean `{word}`? if anything will do, write `?`",
        fix=fix,
    )
