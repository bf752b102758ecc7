"""RAP140 to RAP142: goals and effects that no action of a RAP can make true.

A finding requires that all possible effects of the RAP are known
(`rapc.analysis.facts.effects`). A goal may already be true in part; therefore a goal is
hopeless only if no part of the goal can be made true.

RAP144 and RAP145: effects that a RAP has and does not declare, or the reverse.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.clashes import follows_expanded, rules_out
from rapc.analysis.facts.effects import (
    EFFECTS,
    Effect,
    done_by_method,
    goals_of_method,
    may_establish,
)
from rapc.analysis.facts.logic import (
    Literal,
    asked_through,
    expanded,
    fact_name,
    is_never,
    literals,
)
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.graph import components
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import ways
from rapc.library.library import Library, calls_of

HOPELESS = Rule(
    code="RAP140",
    name="hopeless-goal",
    severity=Severity.WARNING,
    summary="no action of a RAP can make its `succeed` true",
    ignore="where the world makes the formula true, and the methods only wait",
    source="T 3.2.5",
)

ENDLESS = Rule(
    code="RAP141",
    name="endless-reaction",
    severity=Severity.WARNING,
    summary="no action of a standing task can end the state that wakes the task",
    ignore="where the state ends by itself while the task runs",
    source="T 4.7.1",
)

EMPTY = Rule(
    code="RAP142",
    name="empty-promise",
    severity=Severity.WARNING,
    summary="a RAP declares an effect that its actions cannot have, or "
    "that contradicts it",
    ignore="where the world brings about the effect, and the primitive "
    "cannot declare the effect",
    source="T 7.4.1",
)


@check(HOPELESS, ENDLESS, EMPTY, needs_whole="form")
def hopeless(run: Pass) -> Iterator[Diagnostic]:
    """Find goals, reactions and declared effects that their RAP cannot achieve."""
    effects = run.result(EFFECTS)
    hopeless: dict[str, Diagnostic] = {}
    for rap in run.library.raps.values():
        wanted = rap.succeed or rap.effects
        if not run.complete or not rap.methods or not wanted:
            continue
        denied = list(_denied(rap))
        yield from denied
        again = list(_brought_about(run, rap))
        yield from again
        done = effects.of(rap.name)
        if done is not None:
            lost = _hopeless(run, rap, done)
            if lost is not None:
                hopeless[rap.name] = lost
                continue
            promised = () if denied else _empty(run, rap, done)
            endless = () if again else _endless(run, rap, done)
            yield from (*endless, *promised)
    for name in _causes(run.library, hopeless) if hopeless else ():
        yield hopeless[name]


def _hopeless(
    run: Pass, rap: nodes.DefineRap, done: Sequence[Effect]
) -> Diagnostic | None:
    goal = rap.succeed
    if goal is None or is_never(goal):
        return None
    if any(_way_can_come(run.library, way, done) for way in ways(goal)):
        return None
    return HOPELESS.at(
        goal.span, f"no action of `{rap.name}` can make this true", help=_said(done)
    )


def _causes(library: Library, hopeless: Container[str]) -> Iterator[str]:
    """Yield the hopeless RAPs that call no other hopeless RAP, directly or indirectly.

    Of hopeless RAPs that call each other in a cycle, only the first is yielded.
    """
    raps = library.raps
    calls = {rap.name: calls_of(rap, raps) for rap in raps.values()}
    lost: set[str] = set()
    for circle in components(calls, lambda name: calls.get(name, ())):
        below = any(other in lost for name in circle for other in calls.get(name, ()))
        own = [name for name in circle if name in hopeless]
        if own and not below:
            yield min(own, key=list(calls).index)
        if below or own:
            lost.update(circle)


def _endless(
    run: Pass, rap: nodes.DefineRap, done: Sequence[Effect]
) -> Iterator[Diagnostic]:
    monitor = rap.monitor_state
    if monitor is None or not _stands(rap):
        return
    if asked_through(run.library, monitor) and not _ends(run.library, monitor, done):
        yield ENDLESS.at(
            monitor.span,
            f"no action of `{rap.name}` can end the state that wakes the task",
            help=_said(done),
        )


def _stands(rap: nodes.DefineRap) -> bool:
    """Return whether only the monitor of a RAP wakes its task, again and again."""
    return rap.monitor_time is None and is_never(rap.succeed)


def _brought_about(run: Pass, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    """Find a monitor that surely holds after any method has succeeded."""
    monitor = rap.monitor_state
    if monitor is None or not _stands(rap):
        return
    if all(_wakes_again(run, rap, method, monitor) for method in rap.methods):
        yield ENDLESS.at(
            monitor.span,
            f"the actions of `{rap.name}` bring about the state that wakes the task",
            help="query the opposite in the monitor, or change the actions",
        )


def _wakes_again(
    run: Pass, rap: nodes.DefineRap, method: nodes.Method, monitor: nodes.Formula
) -> bool:
    """Return whether a monitor surely holds after a method has succeeded."""
    library = run.library
    given = {variable.name for variable in rap.inputs}
    done = [*done_by_method(library, method), *goals_of_method(library, method)]
    held = list(expanded(library, done))
    return bool(held) and all(
        follows_expanded(run, held, wanted.formula, given)
        if wanted.holds
        else rules_out(run, held, wanted.formula, given)
        for wanted in literals(monitor)
    )


def _ends(library: Library, monitor: nodes.Formula, done: Sequence[Effect]) -> bool:
    """Return whether an effect may keep a part of a monitor from holding."""
    return any(
        may_establish(library, Literal(one.formula, not one.holds), done)
        for one in literals(monitor)
        if not isinstance(one.formula, _BESIDE)
    )


def _said(done: Sequence[Effect]) -> str:
    names = sorted({f"`{effect.name}`" for effect in done})
    if not names:
        return "the declared effects of its actions change nothing in memory"
    return (
        "the declared effects of its actions change only "
        f"{', '.join(names[:_SHOWN_NAMES])}"
        + (", ..." if len(names) > _SHOWN_NAMES else "")
    )


_SHOWN_NAMES = 6
"""The maximum number of names of facts in a message."""


def _way_can_come(library: Library, way: nodes.Formula, done: Sequence[Effect]) -> bool:
    """Return whether an effect may make a conjunction hold; True if unknown.

    Values of comparisons come from the facts beside the comparison, or are unknown.
    """
    asked = [one for one in literals(way) if not isinstance(one.formula, _BESIDE)]
    return not asked or any(may_establish(library, one, done) for one in asked)


_BESIDE = (nodes.Compare, nodes.Truth)


def _denied(rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    """Yield the effects whose denial is also an effect, or the goal."""
    asked = {one.formula: one for one in literals(rap.succeed)}
    first: dict[nodes.Proposition, nodes.DeclaredEffect] = {}
    for effect in rap.effects:
        if effect.possible:
            continue
        other = first.setdefault(effect.pattern, effect)
        if other.negated is not effect.negated:
            yield EMPTY.at(
                effect.span,
                "the opposite of this effect is declared, too",
                labels=(Label(other.span, "declared here"),),
            )
            continue
        one = asked.get(effect.pattern)
        if one is not None and one.holds is effect.negated:
            yield EMPTY.at(
                effect.span,
                "`succeed` requires the opposite of this effect",
                labels=(Label(one.span, "queried here"),),
            )
    yield from _against_each_way(rap)


def _against_each_way(rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    """Yield an effect if the effects deny each of the ways to succeed."""
    every = rap.succeed.parts if isinstance(rap.succeed, nodes.Or) else ()
    told = {effect.pattern: effect for effect in rap.effects if not effect.possible}
    denied = [
        (told[one.formula], one)
        for way in every
        for one in literals(way)
        if isinstance(one.formula, nodes.Pattern)
        and one.formula in told
        and told[one.formula].negated is one.holds
    ]
    ways_denied = {way for way in every for _, one in denied if one in literals(way)}
    if denied and len(ways_denied) == len(every):
        effect, one = denied[0]
        yield EMPTY.at(
            effect.span,
            "every branch of `succeed` requires the opposite of an effect",
            labels=(Label(one.span, "queried here"),),
        )


def _empty(
    run: Pass, rap: nodes.DefineRap, done: Sequence[Effect]
) -> Iterator[Diagnostic]:
    asked = {one.formula for one in literals(rap.succeed)}
    for effect in rap.effects:
        fact = effect.pattern
        promised = Literal(fact, not effect.negated)
        if fact not in asked and not may_establish(run.library, promised, done):
            yield EMPTY.at(
                effect.span,
                f"no action of `{rap.name}` can have the effect `{promised.written}`",
                help=_said(done),
            )


LACKING = Rule(
    code="RAP144",
    name="lacking-effect",
    severity=Severity.INFO,
    opt_in=True,
    summary="a RAP declares effects, but not an effect that all its methods have",
    ignore="where a planner does not need the effect",
    source="T 7.4.1",
)


UNCONFIRMED = Rule(
    code="RAP145",
    name="unconfirmed-effect",
    severity=Severity.INFO,
    opt_in=True,
    summary="a RAP declares an effect that one of its methods does not have",
    ignore="where the world brings about the effect, and the primitive "
    "cannot declare the effect",
    source="T 7.4.1",
)


@check(LACKING, UNCONFIRMED, needs_whole="form")
def declared_effects(run: Pass) -> Iterator[Diagnostic]:
    """Find effects of methods that the RAP does not declare, or the reverse."""
    for rap in run.library.raps.values():
        if rap.effects and rap.methods:
            yield from (*_lacking(run, rap), *_unconfirmed(run, rap))


def _lacking(run: Pass, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    every = [done_by_method(run.library, method) for method in rap.methods]
    common = {fact_name(one) for one in every[0]}.intersection(
        *({fact_name(one) for one in there} for there in every[1:])
    )
    named = {effect.pattern.name for effect in rap.effects}
    lacking = [one for one in every[0] if fact_name(one) in common - named]
    for one in lacking[:1]:
        yield LACKING.at(
            rap.effects[0].span,
            f"`{rap.name}` does not declare its effect `{format_formula(one.formula)}`",
            labels=(Label(one.span, "declared here"),),
            help=f"add `{one.written}`",
        )


def _unconfirmed(run: Pass, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    effects = run.result(EFFECTS)
    asked = {(one.formula, one.holds) for one in literals(rap.succeed)}
    known = [effects.of_method(method) for method in rap.methods]
    for effect in rap.effects:
        promised = Literal(effect.pattern, not effect.negated)
        if (promised.formula, promised.holds) in asked or not run.complete:
            continue
        without = [
            method
            for method, (done, _) in zip(rap.methods, known, strict=True)
            if not may_establish(run.library, promised, done)
        ]
        if len(without) == len(rap.methods) and all(whole for _, whole in known):
            continue
        if without:
            yield UNCONFIRMED.at(
                without[0].span,
                f"no action of this method of `{rap.name}` has the effect "
                f"`{promised.written}`",
                labels=(Label(effect.span, "declared here"),),
                help="declare the effects of the primitives, or require the effect "
                "in `succeed`",
            )
            return
