"""RAP150, RAP151 and RAP155: events and skills that do not go together.

Events that no skill around tells, skills that nobody enables, and skills that are
disabled where they were not enabled. What a skill may tell stands in its declaration;
one that says nothing may tell any.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.ir import nodes
from rapc.library.library import word_span

UNTOLD = Rule(
    code="RAP150",
    name="untold-event",
    severity=Severity.WARNING,
    summary="a primitive waits for an event that none of its skills tells",
    why="""The event is one that skills tell, by their `:events`, but neither a skill of
this primitive nor one of the `skills` of a method does. So it can only come from
elsewhere, or never.""",
    ignore="where a host or another task has the skill on that tells it",
    source="S 3.2, 4.1",
    example="""\
(declare-event :seen ())
(declare-event :arrived ())
(declare-skill :look-out () :events (:seen))
(declare-skill :drive () :events (:arrived))
(define-rap (go) (method (primitive (enable (:drive)) (wait-for (:seen) :succeed))))
(define-rap (see) (method (primitive (enable (:look-out)) (wait-for (:seen) :succeed))))
""",
    better="""\
(declare-event :seen ())
(declare-event :arrived ())
(declare-skill :look-out () :events (:seen))
(declare-skill :drive () :events (:arrived))
(define-rap (go) (method (primitive (enable (:drive)) (wait-for (:arrived) :succeed))))
(define-rap (see) (method (primitive (enable (:look-out)) (wait-for (:seen) :succeed))))
""",
)

UNUSED = Rule(
    code="RAP151",
    name="unused-skill",
    severity=Severity.INFO,
    summary="a skill is declared that nothing enables, though others are enabled",
    why="""The world must offer every skill that is declared, or the library is refused
in it; and a skill that nothing enables may have been forgotten. A file without RAPs
may list all that a world offers (as `rapc worlds NAME --declare` prints it) for
libraries that use a part of it: its skills are not told of.""",
    ignore="where the file lists all that a world offers",
    source="S 2",
    example="""\
(declare-event :arrived ())
(declare-skill :drive () :events (:arrived))
(declare-skill :look-out ())
(define-rap (go) (method (primitive (enable (:drive)) (wait-for (:arrived) :succeed))))
""",
    better="""\
(declare-event :arrived ())
(declare-skill :drive () :events (:arrived))
(define-rap (go) (method (primitive (enable (:drive)) (wait-for (:arrived) :succeed))))
""",
)

DISABLED = Rule(
    code="RAP155",
    name="vain-disable",
    severity=Severity.WARNING,
    summary="a primitive disables a skill that it does not enable",
    why="""The skills of a primitive go off when it ends; `disable` says so for the
reader. It switches no others off: those of another task, or the `skills` of a method,
stay on.""",
    ignore="never: the skill that is named stays as it was",
    source="S 3.2",
    example="""\
(declare-event :arrived ())
(declare-skill :drive () :events (:arrived))
(declare-skill :look-out ())
(define-rap (go)
  (method
    (primitive (enable (:drive)) (wait-for (:arrived) :succeed) (disable (:look-out)))))
(define-rap (guard)
  (method
    (primitive (enable (:look-out)) (wait-for (:arrived) :succeed))))
""",
    better="""\
(declare-event :arrived ())
(declare-skill :drive () :events (:arrived))
(declare-skill :look-out ())
(define-rap (go)
  (method
    (primitive (enable (:drive)) (wait-for (:arrived) :succeed) (disable (:drive)))))
(define-rap (guard)
  (method
    (primitive (enable (:look-out)) (wait-for (:arrived) :succeed))))
""",
)


@check(UNTOLD, UNUSED, DISABLED, needs_whole="method")
def skill_use(run: Pass) -> Iterator[Diagnostic]:
    """Find events and skills that do not go together."""
    enabled = [found.node for found in run.result(INDEX).of(nodes.Skill)]
    yield from _untold_events(run)
    yield from _disabled(run)
    yield from _unused(run, {skill.name for skill in enabled})


def _untold_events(run: Pass) -> Iterator[Diagnostic]:
    skills = run.library.skills
    told = {event for skill in skills.values() for event in skill.events or ()}
    around: set[str] | None = set()
    for method in run.result(INDEX).of(nodes.Method):
        around = _joined(around, _told_by(run, method.node.skills))
    for primitive in run.result(INDEX).of(nodes.Skills):
        own = _joined(around, _told_by(run, primitive.node.enable))
        for wait in primitive.node.waits if own is not None else ():
            if own is not None and wait.signal in told and wait.signal not in own:
                yield _untold(run, wait)


def _told_by(run: Pass, skills: Iterable[nodes.Skill]) -> set[str] | None:
    """Return what some skills may tell; None if one of them may tell anything."""
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
    return UNTOLD.at(
        wait.span,
        f"no skill that is on here tells `{wait.signal}`",
        help=f"enable {' or '.join(tellers)}, or wait for another event",
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
                yield DISABLED.at(
                    skill.span,
                    f"this primitive does not enable `{skill.name}`",
                    help="its skills go off by themselves; others it leaves on",
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
            yield UNUSED.at(
                word_span(run.library.files, skill.span, 1),
                f"nothing enables the skill `{name}`",
                help="enable it somewhere, or remove its declaration",
            )
