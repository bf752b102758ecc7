"""Skills and the events that skills emit."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.library.library import word_span

UNTOLD_EVENT = Rule(
    code="RAP150",
    name="untold-event",
    severity=Severity.WARNING,
    summary="a primitive waits for an event that none of its skills emits",
    ignore="where a host or another task has enabled the skill that emits the event",
    source="S 3.2, 4.1",
)

UNUSED_SKILL = Rule(
    code="RAP151",
    name="unused-skill",
    severity=Severity.INFO,
    summary="a skill is declared but never enabled, although other skills are enabled",
    ignore="where the file lists everything that a world offers",
    source="S 2",
)

VAIN_DISABLE = Rule(
    code="RAP155",
    name="vain-disable",
    severity=Severity.WARNING,
    summary="a primitive disables a skill that it does not enable",
    ignore="never: the disabled skill stays unchanged",
    source="S 3.2",
)


@check(UNTOLD_EVENT, UNUSED_SKILL, VAIN_DISABLE, needs_whole="method")
def skill_use(run: Pass) -> Iterator[Diagnostic]:
    """Find events and skills that do not match."""
    enabled = [found.node for found in run.result(INDEX).of(nodes.Skill)]
    yield from _untold_events(run)
    yield from _disabled(run)
    yield from _unused(run, {skill.name for skill in enabled})


def _untold_events(run: Pass) -> Iterator[Diagnostic]:
    skills = run.library.skills
    told = {event for skill in skills.values() for event in skill.events or ()}
    events = run.library.events
    all_declared = all(skill.events is not None for skill in skills.values())
    around: set[str] | None = set()
    for method in run.result(INDEX).of(nodes.Method):
        around = _joined(around, _told_by(run, method.node.skills))
    for primitive in run.result(INDEX).of(nodes.Skills):
        own = _joined(around, _told_by(run, primitive.node.enable))
        if own is None:
            continue
        for wait in primitive.node.waits:
            if wait.signal in own:
                continue
            if wait.signal in told or (all_declared and wait.signal in events):
                yield _untold(run, wait)


def _told_by(run: Pass, skills: Iterable[nodes.Skill]) -> set[str] | None:
    """Return the events that some skills may emit; None for any event."""
    found: set[str] = set()
    for skill in skills:
        declared = run.library.skills.get(skill.name)
        if declared is None or declared.events is None:
            return None
        found.update(declared.events)
    return found


def _joined(one: set[str] | None, other: set[str] | None) -> set[str] | None:
    return None if one is None or other is None else one | other


def _untold(run: Pass, wait: nodes.WaitFor) -> Diagnostic:
    tellers = list(_tellers(run, wait.signal))
    instead = f"enable {' or '.join(tellers)}, or " if tellers else ""
    return UNTOLD_EVENT.at(
        wait.span,
        f"no enabled skill emits `{wait.signal}`",
        help=f"{instead}wait for another event",
    )


def _tellers(run: Pass, event: str) -> Iterator[str]:
    for name, skill in run.library.skills.items():
        if event in (skill.events or ()):
            yield f"`{name}`"


def _disabled(run: Pass) -> Iterator[Diagnostic]:
    for primitive in run.result(INDEX).of(nodes.Skills):
        on = {skill.name for skill in primitive.node.enable}
        for skill in primitive.node.disable:
            if skill.name not in on:
                yield VAIN_DISABLE.at(
                    skill.span,
                    f"this primitive does not enable `{skill.name}`",
                    help="a primitive disables its own skills when it ends, and no "
                    "other skills",
                )


def _unused(run: Pass, enabled: set[str]) -> Iterator[Diagnostic]:
    unread = run.unsure
    if not run.complete or not enabled & run.library.skills.keys():
        return
    if any(unread(form.span) for form in run.library.raps.values()):
        return
    with_raps = {rap.span.file for rap in run.library.raps.values()}
    for name, skill in run.library.skills.items():
        if name not in enabled and skill.span.file in with_raps:
            yield UNUSED_SKILL.at(
                word_span(run.library.files, skill.span, 1),
                f"nothing enables the skill `{name}`",
                help="enable the skill, or remove the declaration",
            )


NOTHING_AWAITED = Rule(
    code="RAP070",
    name="nothing-awaited",
    severity=Severity.WARNING,
    summary="a primitive enables skills and waits for no event",
    ignore="where the skill acts at once when it is enabled",
    source="S 3.2",
)


REPEATED_WAIT = Rule(
    code="RAP197",
    name="repeated-wait",
    severity=Severity.WARNING,
    summary="a primitive waits twice for the same event",
    ignore="never: the first wait decides",
    source="S 3.2",
)


@check(NOTHING_AWAITED, needs_whole="method")
def nothing_awaited(run: Pass) -> Iterator[Diagnostic]:
    """Find primitives that enable skills and wait for no event of success."""
    for use in run.result(INDEX).of(nodes.Skills):
        if use.node.enable and not use.node.waits:
            yield NOTHING_AWAITED.at(
                use.node.span,
                "this primitive waits for no event and ends at once",
                help="add `(wait-for (:event) :succeed)`",
            )
        elif use.node.waits and all(wait.mode == "fail" for wait in use.node.waits):
            yield NOTHING_AWAITED.at(
                use.node.span,
                "this primitive waits for no event with which it succeeds",
                help="add `(wait-for (:event) :succeed)`",
            )


@check(REPEATED_WAIT, needs_whole="method")
def repeated_waits(run: Pass) -> Iterator[Diagnostic]:
    """Find primitives that wait twice for the same event."""
    for use in run.result(INDEX).of(nodes.Skills):
        first: dict[tuple[str, tuple[nodes.Term, ...]], nodes.WaitFor] = {}
        for wait in use.node.waits:
            other = first.setdefault((wait.signal, wait.args), wait)
            if other is not wait:
                yield REPEATED_WAIT.at(
                    wait.span,
                    f"this primitive waits for `{wait.signal}` twice",
                    labels=(Label(other.span, "the first wait"),),
                    help="name a different event, or remove this wait: the first wait "
                    "decides",
                )
