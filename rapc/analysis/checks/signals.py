"""RAP023 and RAP024: skills and events that no declaration knows, or that miss it.

Skills are enabled and disabled, events awaited and matched by rules [S 3, 4].
Their names are written with a colon.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.names import UnknownNames, misuses, wrong_arity
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.ir import nodes

_AS_DECLARED = """\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall ?side))
    (wait-for (:wall-ends) :succeed))))
"""

UNDECLARED = Rule(
    code="RAP023",
    name="undeclared-signal",
    severity=Severity.ERROR,
    summary="a skill or an event is not declared",
    why="""Skills and events are what a world offers besides primitives. A skill that it
does not have cannot be enabled, and an event that it never sends is awaited for
ever.""",
    fix="unsafe: writes the name that is spelled almost so, where there is one",
    source="S 2",
    example="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall ?side))
    (wait-for (:wall-end) :succeed))))
""",
    better=_AS_DECLARED,
)

ARITY = Rule(
    code="RAP024",
    name="wrong-signal-arity",
    severity=Severity.ERROR,
    summary="a skill or an event has another number of arguments than was declared",
    why="""A skill is enabled with the arguments it was declared with, and an event is
sent with those it was declared with: another number of them never matches.""",
    source="S 2",
    example="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall))
    (wait-for (:wall-ends) :succeed))))
""",
    better=_AS_DECLARED,
)


@check(UNDECLARED, ARITY)
def signals(run: Pass) -> Iterator[Diagnostic]:
    """Find skills and events that are not declared, or declared otherwise."""
    unknown = UnknownNames(UNDECLARED)
    for one in misuses(run, ("skill", "event"), "unknown"):
        unknown.add(one.fault, one.used.place(run.library.files), one.used.owner)
    for skill in run.result(INDEX).of(nodes.DeclareSkill):
        for name in skill.node.events or ():
            if name not in run.signatures.events:
                fault = run.signatures.unknown("event", name)
                unknown.add(fault, skill.node.span, skill.owner)
    yield from unknown.findings(run)
    yield from wrong_arity(run, ARITY, ("skill", "event"))
