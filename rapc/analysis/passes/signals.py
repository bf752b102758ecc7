"""RAP023 and RAP024: skills and events that no declaration knows, or that miss it.

Skills are enabled and disabled, events awaited and matched by rules (semantics 8, S 3
and 4). Their names are written with a colon.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.arity import wrong_arity
from rapc.analysis.names import Names
from rapc.analysis.occurrences import Occurrences
from rapc.analysis.passes.occurrences import OCCURRENCES
from rapc.analysis.unknown import Unknown
from rapc.base.diagnostics import Rule, Severity
from rapc.ir import nodes
from rapc.library.library import name_span, word_span

UNDECLARED = Rule(
    code="RAP023",
    name="undeclared-signal",
    severity=Severity.ERROR,
    summary="a skill or an event is not declared",
    why="""Skills and events are what a world offers besides primitives. A skill that it
does not have cannot be enabled, and an event that it never sends is awaited for
ever.""",
    example="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall ?side))
    (wait-for (:wall-end) :succeed))))
""",
    better="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall ?side))
    (wait-for (:wall-ends) :succeed))))
""",
)

ARITY = Rule(
    code="RAP024",
    name="wrong-signal-arity",
    severity=Severity.ERROR,
    summary="a skill or an event has another number of arguments than was declared",
    why="""A skill is enabled with the arguments it was declared with, and an event is
sent with those it was declared with: another number of them never matches.""",
    example="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall))
    (wait-for (:wall-ends) :succeed))))
""",
    better="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall ?side))
    (wait-for (:wall-ends) :succeed))))
""",
)

Signal = nodes.Signal | nodes.Skill | nodes.WaitFor
Declared = nodes.DeclareSkill | nodes.DeclareEvent


def _run(run: Pass) -> None:
    occurrences = run.result(OCCURRENCES)
    _check(run, "skill", run.library.skills, _skills(occurrences))
    _check(run, "event", run.library.events, _events(occurrences))


ANALYZER = Analyzer(
    name="signals",
    doc="Finds skills and events that are not declared, or declared otherwise.",
    run=_run,
    needs=(OCCURRENCES,),
    rules=(UNDECLARED, ARITY),
)


def _check(
    run: Pass, what: str, known: Mapping[str, Declared], uses: Iterator[Signal]
) -> None:
    advice = f"declare it with `declare-{what}`, or `require` the file that does"
    unknown = Unknown(UNDECLARED, f"no {what} is called `{{}}`", Names(known), advice)
    files = run.library.files
    for use in uses:
        waits = isinstance(use, nodes.WaitFor)
        name = use.signal if isinstance(use, nodes.WaitFor) else use.name
        declared = known.get(name)
        if declared is None:
            place = use.span if waits else word_span(files, use.span, 0)
            unknown.add(name, place)
        elif len(declared.args) != len(use.args):
            said = (name, declared.args, name_span(files, declared))
            run.report(wrong_arity(ARITY, use, said))
    unknown.report(run)


def _skills(occurrences: Occurrences) -> Iterator[Signal]:
    for use in occurrences.of(nodes.Skills):
        yield from use.node.enable
        yield from use.node.disable


def _events(occurrences: Occurrences) -> Iterator[Signal]:
    for wait in occurrences.of(nodes.WaitFor):
        yield wait.node
    for rule in occurrences.of(nodes.EventRule):
        yield nodes.WaitFor(rule.node.signal, rule.node.args, "proceed", rule.node.span)
    for case in occurrences.of(nodes.ResultCase):
        if isinstance(case.node.result, nodes.Signal):
            yield case.node.result
