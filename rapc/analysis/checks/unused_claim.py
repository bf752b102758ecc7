"""RAP084 and RAP086: things that nobody else could want, or that are misspelt."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX, Occurrence
from rapc.analysis.facts.names import renaming
from rapc.analysis.facts.statistics import THRESHOLDS
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.names import Close, Suggestions, is_row, plural
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import steps

UNUSED = Rule(
    code="RAP084",
    name="unused-claim",
    severity=Severity.WARNING,
    summary="a RAP that runs once claims a thing that nothing else uses or claims",
    why="""A claim keeps other tasks from a thing that they use or claim. Things are not
declared. Here one task of an agenda leads to the RAP, by one step each, so that no
second task of the RAP claims the thing; no other RAP, primitive or skill names it with
as many arguments. The claim has no effect: another name was meant, or another RAP or
primitive lacks the thing.""",
    fix="unsafe: writes the thing that is spelled almost so, where there is one",
    ignore="where another library uses the thing, and runs beside this one",
    source="L 8",
    example="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(define-rap (go ?to) (method (primitive (drive ?to))))
(define-rap (visit ?to)
  (method (claims robot) (task-net (t1 (go ?to)))))
(define-agenda day (task (visit lab)))
""",
    better="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(define-rap (go ?to) (method (primitive (drive ?to))))
(define-rap (visit ?to)
  (method (claims wheels) (task-net (t1 (go ?to)))))
(define-agenda day (task (visit lab)))
""",
)

MISSPELT = Rule(
    code="RAP086",
    name="misspelt-thing",
    severity=Severity.WARNING,
    summary="a thing is named only once, and another one is spelled almost so",
    why="""Things are not declared: whoever uses or claims one keeps others off who name
it in the same way. One that nobody else names keeps nobody off, so two primitives that
need the same arm are under way at once. If it is another thing, give it a name that
shows so.""",
    fix="unsafe: writes the thing that is spelled almost so",
    ignore="where the two things are meant: give one of them a name that is less like "
    "the other",
    source="L 8",
    example="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(declare-primitive turn (?to) (okay) :uses (wheels))
(declare-primitive dock () (okay) :uses (wheles))
""",
    better="""\
(declare-primitive drive (?to) (okay) :uses (wheels))
(declare-primitive turn (?to) (okay) :uses (wheels))
(declare-primitive dock () (okay) :uses (wheels))
""",
)


_Sort = tuple[str, int]
"""A thing by its name and number of arguments."""

_Places = Mapping[_Sort, Sequence[Occurrence[nodes.Thing]]]
"""Where things are named, each once for each method or declaration."""


@check(UNUSED, MISSPELT)
def unused_claim(run: Pass) -> Iterator[Diagnostic]:
    """Find things that nothing else uses or claims, and names of things misspelt."""
    places = _places(run.result(INDEX).of(nodes.Thing))
    settled: set[_Sort] = set()
    for one, other in _misspelt(places):
        settled |= {_sort(one), _sort(other)}
        yield _close(run, one.node, other.node)
    users_known = not any(run.unsure(one.span) for one in _offers(run))
    if not run.complete or not users_known:
        return
    near = Suggestions(sorted({name for name, _ in places}))
    callers = _callers(run)
    for sort, named in places.items():
        if sort not in settled and _is_unused(named, places, callers):
            yield _finding(run, named[0].node, near, places)


def _places(things: Iterable[Occurrence[nodes.Thing]]) -> _Places:
    found: dict[_Sort, dict[int, Occurrence[nodes.Thing]]] = {}
    for thing in things:
        sort = thing.node.name, len(thing.node.args)
        found.setdefault(sort, {}).setdefault(id(thing.parent), thing)
    return {sort: list(named.values()) for sort, named in found.items()}


def _misspelt(
    places: _Places,
) -> Iterator[tuple[Occurrence[nodes.Thing], Occurrence[nodes.Thing]]]:
    """Yield things named once whose names are close to another, with that other.

    What several name is meant by all of them. Of two that are named once each, a claim
    is taken for the slip, and of two claims the one further down.
    """
    close: dict[int, Close] = {}
    for count in {count for _, count in places}:
        names = sorted(name for name, number in places if number == count)
        close[count] = Close(names, THRESHOLDS.close_thing)
    for (name, count), named in places.items():
        others = [
            places[other, count]
            for other in close[count].all_to(name)
            if not is_row(name, other) and _is_meant(places[other, count], named)
        ]
        if others:
            yield named[0], others[0][0]


def _is_meant(
    other: Sequence[Occurrence[nodes.Thing]], named: Sequence[Occurrence[nodes.Thing]]
) -> bool:
    """Whether a thing of a close name is what is meant by one that is named once."""
    (this, *further), that = named, other[0]
    if further or len(other) > 1:
        return not further
    if not isinstance(this.parent, nodes.Method):
        return False
    return not isinstance(that.parent, nodes.Method) or _is_above(that, this)


def _is_above(one: Occurrence[nodes.Thing], other: Occurrence[nodes.Thing]) -> bool:
    first, second = one.node.span, other.node.span
    return (first.file, first.start) < (second.file, second.start)


def _close(run: Pass, thing: nodes.Thing, other: nodes.Thing) -> Diagnostic:
    return MISSPELT.at(
        thing.span,
        f"nothing else uses or claims `{format_formula(thing)}`",
        labels=(Label(other.span, "a thing with a close name"),),
        help=f"did you mean `{other.name}`?",
        fix=renaming(run.library.files, thing.name, other.name, [thing.span]),
    )


# --- claims without effect ------------------------------------------------------------


def _callers(run: Pass) -> Mapping[str, Sequence[str | None]]:
    """Return by RAP the RAPs whose steps ask for it; None stands for an agenda."""
    found: dict[str, list[str | None]] = {}
    for agenda in run.library.agendas.values():
        for task in agenda.tasks:
            found.setdefault(task.goal.name, []).append(None)
    for rap in run.library.raps.values():
        for method in rap.methods:
            for step in steps(method):
                found.setdefault(step.goal.name, []).append(rap.name)
    return found


def _runs_once(name: str, callers: Mapping[str, Sequence[str | None]]) -> bool:
    """Whether one task of an agenda leads to a RAP, by one step each.

    A host may start any other RAP as often as it likes.
    """
    seen = set[str]()
    here: str | None = name
    while here is not None and here not in seen:
        seen.add(here)
        by = callers.get(here, ())
        if len(by) != 1:
            return False
        here = by[0]
    return here is None


def _is_unused(
    named: Sequence[Occurrence[nodes.Thing]],
    places: _Places,
    callers: Mapping[str, Sequence[str | None]],
) -> bool:
    """Whether nobody else names a thing, so that its claims have no effect.

    One that is named with other arguments elsewhere is a slip, however often it runs.
    """
    first = named[0]
    if any(
        not isinstance(one.parent, nodes.Method) or one.owner is not first.owner
        for one in named
    ):
        return False
    assert isinstance(first.owner, nodes.DefineRap)
    name, count = _sort(first)
    elsewhere = any(other == name and number != count for other, number in places)
    return elsewhere or _runs_once(first.owner.name, callers)


def _offers(run: Pass) -> Iterable[nodes.DeclarePrimitive | nodes.DeclareSkill]:
    """Return what may use things."""
    return (*run.library.primitives.values(), *run.library.skills.values())


def _sort(thing: Occurrence[nodes.Thing]) -> _Sort:
    return thing.node.name, len(thing.node.args)


def _finding(
    run: Pass, thing: nodes.Thing, near: Suggestions, places: _Places
) -> Diagnostic:
    written = format_formula(thing)
    others = sorted(count for name, count in places if name == thing.name)
    others.remove(len(thing.args))
    help_, meant = near.did_you_mean(thing.name), near.near(thing.name)
    if others:
        meant = None
        amount = plural(others[0], "argument") if others[0] else "no arguments"
        help_ = f"`{thing.name}` is named with {amount} elsewhere"
    return UNUSED.at(
        thing.span,
        f"nothing else uses or claims `{written}`",
        help=help_,
        fix=renaming(run.library.files, thing.name, meant, [thing.span]),
    )
