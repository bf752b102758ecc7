"""RAP133: methods that claim two things in opposite orders, by the agendas [L 8.27].

A method holds its claimed things while its steps wait. A step below the method may
claim a second thing. If another task of the agenda claims the things in the opposite
order at the same priority, the two tasks can deadlock. Only things without variables
count.

RAP084 and RAP086: claims without effect, and things whose names are misspelt.

RAP192, RAP194, RAP196 and RAP198: claims and uses that do not fit each other.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import things_needed
from rapc.analysis.facts.index import INDEX, Occurrence
from rapc.analysis.facts.names import renaming
from rapc.analysis.facts.statistics import LIMITS, THRESHOLDS
from rapc.analysis.facts.things import THINGS, Things, Use
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.names import Close, Suggestions, is_row, plural
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import steps
from rapc.library.library import Library, name_span

CROSSED = Rule(
    code="RAP133",
    name="crossed-claims",
    severity=Severity.WARNING,
    summary="two tasks of an agenda claim the same two things in opposite orders",
    ignore="where the two tasks never run at the same time",
    source="T 7.2.1",
)

_Things = frozenset[nodes.Thing]


class _Taken(msgspec.Struct, frozen=True):
    """A thing that is claimed while others are held."""

    thing: nodes.Thing
    held: _Things
    rap: nodes.DefineRap


_Orders = Mapping[tuple[nodes.Thing, nodes.Thing], Sequence[_Taken]]
"""The claims by pairs of a held thing and a claimed thing."""


_Known = dict[tuple[nodes.Thing, nodes.Thing], dict[_Things, _Taken]]
"""The claims of several tasks, by all held things; only the first of equal claims."""


@check(CROSSED)
def crossed_claims(run: Pass) -> Iterator[Diagnostic]:
    """Find tasks of an agenda that claim two things in opposite orders."""
    raps = run.library.raps.values()
    if not any(method.claims for rap in raps for method in rap.methods):
        return
    orders: dict[str, _Orders] = {}
    told: set[_Things] = set()
    for agenda in run.library.agendas.values():
        by_priority: dict[int, _Known] = {}
        for task in agenda.tasks:
            name = task.goal.name
            if name not in orders:
                orders[name] = _orders(run.library, name)
            others = by_priority.setdefault(task.priority, {})
            for one, other in _crossed(orders[name], others):
                pair = frozenset((one.thing, other.thing))
                if pair not in told:
                    told.add(pair)
                    yield _crossing(one, other)
            for key, taken in orders[name].items():
                known = others.setdefault(key, {})
                for other in taken:
                    known.setdefault(other.held, other)


def _orders(library: Library, goal: str) -> _Orders:
    """Return the certain orders of claims below a task."""
    found: dict[tuple[nodes.Thing, nodes.Thing], list[_Taken]] = {}
    waiting: list[tuple[str, _Things]] = [(goal, frozenset())]
    seen = set(waiting)
    while waiting and len(seen) < LIMITS.claims_below:
        name, held = waiting.pop()
        rap = library.raps.get(name)
        if rap is None or not rap.methods:
            continue
        own = [frozenset(things_needed(library, method)) for method in rap.methods]
        always = frozenset.intersection(*own) - held
        for wanted in sorted(always, key=format_formula):
            for thing in sorted(held, key=format_formula):
                taken = _Taken(wanted, held, rap)
                found.setdefault((thing, wanted), []).append(taken)
        for method, mine in zip(rap.methods, own, strict=True):
            for step in steps(method):
                below = (step.goal.name, held | mine)
                if below not in seen:
                    seen.add(below)
                    waiting.append(below)
    return found


def _crossed(orders: _Orders, others: _Known) -> Iterator[tuple[_Taken, _Taken]]:
    """Yield claims in opposite orders, unless a third thing prevents the deadlock."""
    for (thing, wanted), mine in orders.items():
        for other in others.get((wanted, thing), {}).values():
            one = next((one for one in mine if not one.held & other.held), None)
            if one is not None:
                yield one, other
                break


def _crossing(one: _Taken, other: _Taken) -> Diagnostic:
    first, second = format_formula(one.thing), format_formula(other.thing)
    return CROSSED.at(
        one.rap.name_span,
        f"`{one.rap.name}` claims `{first}` while `{second}` is held, "
        f"and `{other.rap.name}` claims them in the opposite order",
        labels=(
            Label(other.rap.name_span, f"claims `{second}` while `{first}` is held"),
        ),
        help="claim both things in one method, or in the same order",
    )


UNUSED_CLAIM = Rule(
    code="RAP084",
    name="unused-claim",
    severity=Severity.WARNING,
    summary="a RAP that runs once claims a thing that nothing else uses or claims",
    fix="unsafe: writes the similar thing, if there is one",
    ignore="where another library that runs at the same time uses the thing",
    source="L 8",
)

MISSPELT_THING = Rule(
    code="RAP086",
    name="misspelt-thing",
    severity=Severity.WARNING,
    summary="a thing is named once, and a similar thing exists",
    fix="unsafe: writes the similar thing",
    ignore="where both things are meant: choose a name that is less similar",
    source="L 8",
)


_Sort = tuple[str, int]
"""The name of a thing and the number of its arguments."""

_Places = Mapping[_Sort, Sequence[Occurrence[nodes.Thing]]]
"""The occurrences of things, each once for each method or declaration."""


@check(UNUSED_CLAIM, MISSPELT_THING)
def unused_claim(run: Pass) -> Iterator[Diagnostic]:
    """Find things without another use or claim, and misspelt names of things."""
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
            yield _unused_thing(run, named[0].node, near, places)


def _places(things: Iterable[Occurrence[nodes.Thing]]) -> _Places:
    found: dict[_Sort, dict[int, Occurrence[nodes.Thing]]] = {}
    for thing in things:
        sort = thing.node.name, len(thing.node.args)
        found.setdefault(sort, {}).setdefault(id(thing.parent), thing)
    return {sort: list(named.values()) for sort, named in found.items()}


def _misspelt(
    places: _Places,
) -> Iterator[tuple[Occurrence[nodes.Thing], Occurrence[nodes.Thing]]]:
    """Yield each thing named once that has a similar name, with the similar thing.

    If the similar name occurs several times, that name counts as correct. If both names
    occur once, a claim counts as the fault; of two claims, the claim further down.
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
    """Return whether a thing with a similar name is the intended thing."""
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
    return MISSPELT_THING.at(
        thing.span,
        f"nothing else uses or claims `{format_formula(thing)}`",
        labels=(Label(other.span, "a similar thing"),),
        help=f"did you mean `{other.name}`?",
        fix=renaming(run.library.files, thing.name, other.name, [thing.span]),
    )


# --- claims without effect ------------------------------------------------------------


def _callers(run: Pass) -> Mapping[str, Sequence[str | None]]:
    """Return, by RAP, the RAPs whose steps call that RAP; None is an agenda."""
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
    """Return whether a single task of an agenda leads to a RAP, by single steps.

    A host may start any other RAP several times.
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
    """Return whether a thing has no other use, so that its claims have no effect.

    A thing that occurs elsewhere with different arguments is a fault in any case.
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
    """Return the declarations that may use things."""
    return (*run.library.primitives.values(), *run.library.skills.values())


def _sort(thing: Occurrence[nodes.Thing]) -> _Sort:
    return thing.node.name, len(thing.node.args)


def _unused_thing(
    run: Pass, thing: nodes.Thing, near: Suggestions, places: _Places
) -> Diagnostic:
    written = format_formula(thing)
    others = sorted(count for name, count in places if name == thing.name)
    others.remove(len(thing.args))
    help_, meant = near.did_you_mean(thing.name), near.near(thing.name)
    if others:
        meant = None
        amount = plural(others[0], "argument") if others[0] else "no arguments"
        help_ = f"other uses of `{thing.name}` have {amount}"
    return UNUSED_CLAIM.at(
        thing.span,
        f"nothing else uses or claims `{written}`",
        help=help_,
        fix=renaming(run.library.files, thing.name, meant, [thing.span]),
    )


# --- claims and uses ------------------------------------------------------------------


VAIN_CLAIM = Rule(
    code="RAP192",
    name="vain-claim",
    severity=Severity.WARNING,
    summary="a method claims a different thing than its requests use",
    ignore="where the claim keeps other methods from running",
    source="L 8",
)

UNCLAIMED = Rule(
    code="RAP194",
    name="unclaimed-thing",
    severity=Severity.WARNING,
    summary="one method of a RAP does not claim a thing that the others claim",
    ignore="where the method may be interrupted between two requests",
    source="L 8",
)


@check(VAIN_CLAIM, UNCLAIMED, needs_whole="form")
def claims_and_uses(run: Pass) -> Iterator[Diagnostic]:
    """Compare the claims of each method with the things that are used below."""
    raps = run.library.raps.values()
    claiming = [rap for rap in raps if any(method.claims for method in rap.methods)]
    if not claiming or not run.complete:
        return
    things = run.result(THINGS)
    for rap in claiming:
        for method in rap.methods:
            used = list(things.of(method))
            yield from _vain_claims(method, used)
        yield from _unclaimed(rap, things)


def _vain_claims(method: nodes.Method, used: Sequence[Use]) -> Iterator[Diagnostic]:
    """Yield the claims of things that requests below use with other arguments.

    A method that claims several things of a name may keep one of them still.
    """
    for claim in method.claims:
        if any(other.name == claim.name for other in method.claims if other != claim):
            continue
        count = len(claim.args)
        alike = [
            one.thing
            for one in used
            if one.thing.name == claim.name and len(one.thing.args) == count
        ]
        if not alike or any(_fits(claim, thing) for thing in alike):
            continue
        written = sorted({format_formula(thing) for thing in alike})
        yield VAIN_CLAIM.at(
            claim.span,
            f"no request of this method uses `{format_formula(claim)}`",
            labels=(Label(method.body.span, "the steps of the method"),),
            help="claim the thing that the requests use: "
            f"{', '.join(f'`{one}`' for one in written[:3])}",
        )


def _fits(claim: nodes.Thing, used: nodes.Thing) -> bool:
    """Return whether a claim may be of a used thing."""
    return len(claim.args) == len(used.args) and all(
        one == other
        or (isinstance(other, nodes.Var) and other.anonymous)
        or isinstance(one, nodes.Const) is not isinstance(other, nodes.Const)
        for one, other in zip(claim.args, used.args, strict=True)
    )


def _unclaimed(rap: nodes.DefineRap, things: Things) -> Iterator[Diagnostic]:
    """Yield methods that use, but do not claim, what all other users claim.

    Only things with arguments count: methods that are alike but for the thing. A method
    with a single step has no pause in which another task may take the thing.
    """
    names = {
        claim.name: claim
        for method in rap.methods
        for claim in method.claims
        if claim.args
    }
    for name, claim in names.items():
        users = [
            method
            for method in rap.methods
            if any(one.free and one.thing.name == name for one in things.of(method))
        ]
        without = [
            method
            for method in users
            if not any(one.name == name for one in method.claims)
        ]
        if len(without) == 1 < len(users) and len(steps(without[0])) > 1:
            yield UNCLAIMED.at(
                without[0].body.span,
                f"this method uses `{name}`, but does not claim it",
                labels=(Label(claim.span, "another method claims it"),),
                help="claim the thing, so that no other task takes it between two "
                "requests",
            )


UNLIKE_USE = Rule(
    code="RAP196",
    name="unlike-use",
    severity=Severity.WARNING,
    summary="a primitive does not use a thing that all similar primitives use",
    ignore="where the primitive only looks at its argument",
    source="L 8",
)


@check(UNLIKE_USE)
def unlike_uses(run: Pass) -> Iterator[Diagnostic]:
    """Find primitives that lack a thing named by an argument of a certain kind.

    A primitive that uses other things, or reports a datum, may only look.
    """
    by_kind: dict[str, list[tuple[nodes.DeclarePrimitive, frozenset[str]]]] = {}
    for form in run.library.primitives.values():
        for arg in form.args:
            if arg.kind is not None:
                used = [one.name for one in form.uses if arg.variable in one.args]
                by_kind.setdefault(arg.kind, []).append((form, frozenset(used)))
    for kind, forms in by_kind.items():
        lacking = [form for form, used in forms if not used]
        others = [used for _, used in forms if used]
        if len(lacking) != 1 or len(others) < THRESHOLDS.uses_alike:
            continue
        (form,) = lacking
        if form.uses or form.tells:
            continue
        for name in sorted(frozenset.intersection(*others)):
            yield UNLIKE_USE.at(
                name_span(run.library.files, form),
                f"`{form.name}` does not use `{name}`, unlike the other primitives "
                f"with an argument of the kind `{kind}`",
                help=f"add `:uses (({name} ...))`",
            )


RIVAL_SKILLS = Rule(
    code="RAP198",
    name="rival-skills",
    severity=Severity.WARNING,
    summary="a method enables two skills that use the same thing",
    ignore="where the world shares the thing between the skills",
    source="S 2",
)


@check(RIVAL_SKILLS, needs_whole="method")
def rival_skills(run: Pass) -> Iterator[Diagnostic]:
    """Find skills that are enabled together, and use the same thing."""
    for rap in run.library.raps.values():
        for method in rap.methods:
            enabled = (
                method.body.enable if isinstance(method.body, nodes.Skills) else ()
            )
            first: dict[nodes.Thing, nodes.Skill] = {}
            for skill in (*method.skills, *enabled):
                form = run.library.skills.get(skill.name)
                for thing in form.uses if form is not None else ():
                    other = first.setdefault(thing, skill)
                    if other.name != skill.name and not thing.args:
                        yield RIVAL_SKILLS.at(
                            skill.span,
                            f"`{skill.name}` and `{other.name}` both use "
                            f"`{format_formula(thing)}`",
                            labels=(Label(other.span, "enabled here"),),
                            help="enable one skill at a time, or change their `:uses`",
                        )
