"""RAP152: cases of memory rules that are never taken [S 4.2]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.unknown_result import REASONS
from rapc.analysis.facts.effects import EFFECTS, Effects
from rapc.analysis.facts.index import INDEX
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes

DEAD = Rule(
    code="RAP152",
    name="dead-case",
    severity=Severity.WARNING,
    summary="a case of a memory rule can never be taken",
    why="""Of the cases of a `match-result` the first that matches is taken alone, so
what stands behind a case that matches everything, or behind the same case, is never
reached. A task ends with a result, not with a signal; an event is a signal, and has no
result. A task that ends well has the result `succeed`; one that fails has a result of a
primitive of its RAP or of one below it, the name of an event that fails one of them, or
a reason of the interpreter. An event that skills tell is heard by the rules of a RAP
only if such skills are on for it or for one below it. Methods that a problem solver
adds are not looked at.""",
    ignore="where a problem solver brings methods that end so",
    source="S 4.2",
    example="""\
(declare-memory-proposition at (?place))
(declare-primitive drive (?place) (okay stuck))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-memory-rule (go ?place) :finish
  (match-result
    (?result (rule (true (mem-del (at)))))
    (succeed (rule (true (mem-add (at ?place)))))))
""",
    better="""\
(declare-memory-proposition at (?place))
(declare-primitive drive (?place) (okay stuck))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-memory-rule (go ?place) :finish
  (match-result
    (succeed (rule (true (mem-add (at ?place)))))
    (?result (rule (true (mem-del (at)))))))
""",
)


@check(DEAD, needs_whole="form")
def dead_case(run: Pass) -> Iterator[Diagnostic]:
    """Find cases of memory rules that are never taken."""
    results = {r for form in run.library.primitives.values() for r in form.results}
    results |= {name.removeprefix(":") for name in run.library.events}
    told = {e for form in run.library.skills.values() for e in form.events or ()}
    for rule in run.result(INDEX).of(nodes.MemoryRule):
        dead = set[Span]()
        for found in _dead(rule.node):
            dead.add(found.span)
            yield found
        if not run.complete or rule.node.index.name not in run.library.raps:
            continue
        for found in _impossible(rule.node, run.result(EFFECTS), results, told):
            if found.span not in dead:
                yield found


def _impossible(
    rule: nodes.MemoryRule, effects: Effects, results: set[str], told: set[str]
) -> Iterator[Diagnostic]:
    """Tell of the cases for what never comes of a RAP, though of others it may."""
    name = rule.index.name
    for case in rule.cases:
        result = case.result
        if rule.when == "event":
            if (
                isinstance(result, nodes.Signal)
                and result.name in told
                and not effects.tells(name, result.name)
            ):
                message = f"no skill that `{name}` has on, or what is below it, tells "
                help = "move it to the RAP with that skill, or make it an event rule"
                yield _wrong(case, f"{message}`{result.name}`", help)
        elif isinstance(result, nodes.Const) and isinstance(result.value, str):
            failure = result.value
            if failure == "okay":
                message = "a task that ends well has the result `succeed`"
                yield _wrong(case, message, "write `succeed` for `okay`")
            elif failure in results - {*REASONS} and not effects.fails_with(
                name, failure
            ):
                message = f"`{name}` never fails with `{failure}`"
                help = "name a result of what it does, or remove the case"
                yield _wrong(case, message, help)


def _dead(rule: nodes.MemoryRule) -> Iterator[Diagnostic]:
    names = {v.name for v in rule.index.args if isinstance(v, nodes.Var)}
    names |= {v.name for v in rule.index.outputs if isinstance(v, nodes.Var)}
    every: nodes.ResultCase | None = None
    seen: dict[object, nodes.ResultCase] = {}
    for case in rule.cases:
        result = case.result
        first = every
        if isinstance(result, nodes.Const):
            first = first or seen.setdefault(result.value, case)
        if first not in (None, case):
            yield _behind(case, first)
        elif rule.when == "event" and isinstance(result, nodes.Const):
            text = f"`{result.value}` is a result, and this rule hears events"
            yield _wrong(case, text, "name the event: `((:event ?what) (rule ...))`")
        elif rule.when == "finish" and isinstance(result, nodes.Signal):
            text = f"`{result.name}` is an event, and this rule runs when a task ends"
            yield _wrong(case, text, "make it an `:event` rule, or name a result")
        if isinstance(result, nodes.Var) and result.name not in names:
            every = every or case


def _behind(case: nodes.ResultCase, first: nodes.ResultCase | None) -> Diagnostic:
    assert first is not None
    return DEAD.at(
        case.result.span,
        "this case is never reached",
        labels=(Label(first.result.span, "this one matches before it"),),
        help="put it before that one, or remove it",
    )


def _wrong(case: nodes.ResultCase, message: str, help: str) -> Diagnostic:
    return DEAD.at(case.result.span, message, help=help)
