"""RAP111: methods that are never chosen.

That is told by literals (`rapc.analysis.facts.logic`). Where a method is chosen the
monitor, preconditions and constraints of its RAP hold, `succeed` has no solution, and
`repeat-while` holds together with the context; what clauses of the RAP bind stays
theirs.

RAP112 to RAP116: clauses whose answer is settled before the world has a say.

A property with a default has a value whatever happens: a fact that asks for it with a
fresh variable always holds [L 2.20].
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence

import msgspec

from rapc.analysis.check import Pass, check
from rapc.analysis.checks.conditions import (
    CONTRADICTIONS,
    clash_at,
    first_clash,
    one_for_each_place,
    said,
)
from rapc.analysis.facts.logic import Clash, Literal, apart, follows, is_never, literals
from rapc.analysis.facts.resources import FirstValues
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import clauses, nodes
from rapc.ir.clauses import Clause
from rapc.ir.schema import operands
from rapc.ir.walk import given_names, variable_names, ways
from rapc.library.signature import CONSTANT_DEFAULTS, Signature
from rapc.library.signatures import Signatures

UNREACHABLE = Rule(
    code="RAP111",
    name="unreachable-method",
    severity=Severity.WARNING,
    summary="a method is never chosen, whatever happens",
    why="""A method is chosen when `succeed` has no solution and the monitor, the
preconditions and the constraints of its RAP hold (T 3.2.3). A context that contradicts
one of these, or from which `succeed` follows, never holds then; nor does `otherwise`
behind a method without a context. Where these clauses contradict each other no method
is ever chosen. The plan for that situation is missing, though it stands in the
text.""",
    ignore="where a method is kept for a situation that other libraries will bring "
    "about",
    source="T 3.2.2",
    example="""\
(declare-memory-proposition cart-at (?place))
(declare-primitive drive (?place) (okay))
(declare-primitive turn-round () (okay))
(define-rap (go-to ?place)
  (succeed (cart-at ?place))
  (method (context (not (cart-at ?place))) (primitive (drive ?place)))
  (method (context (cart-at ?place)) (primitive (turn-round))))
""",
    better="""\
(declare-memory-proposition cart-at (?place))
(declare-primitive drive (?place) (okay))
(declare-primitive turn-round () (okay))
(define-rap (go-to ?place)
  (succeed (cart-at ?place))
  (method (context (not (cart-at home))) (primitive (drive ?place)))
  (method (context (cart-at home)) (primitive (turn-round))))
""",
)


class _Asked(msgspec.Struct, frozen=True):
    """A literal that holds where a method is chosen, and the clause that says so."""

    literal: Literal
    clause: str
    #: The literal as it is written, where its variables were given other names.
    written: Literal


class _Goal(msgspec.Struct, frozen=True):
    """A way to succeed, in variables of its own."""

    span: Span
    literals: Sequence[Literal]
    #: Its variables that are no inputs or resources.
    free: Container[str]


class _Chosen(msgspec.Struct, frozen=True):
    """What is so wherever a method of a RAP is chosen, and where findings go."""

    run: Pass
    #: The inputs and resources of the RAP.
    given: Container[str]
    held: list[_Asked]
    goals: Sequence[_Goal]

    def clash(self, own: Sequence[Literal]) -> Clash | None:
        """Return two literals that never hold together, of what is so and some more."""
        held = [one.literal for one in self.held]
        return first_clash(self.run, held, own, self.given) if held else None

    def goal_of(self, held: Sequence[Literal]) -> _Goal | None:
        """Return a way to succeed that follows from literals, if any does."""
        relations = self.run.signatures.relations
        for goal in self.goals if held else ():
            if follows(goal.literals, held, goal.free, relations, self.given):
                return goal
        return None


def _goal(formula: nodes.Formula, given: Container[str]) -> _Goal:
    renamed = apart(formula, given, "@goal")
    free = {name for name in variable_names(renamed) if name not in given}
    return _Goal(formula.span, tuple(literals(renamed)), free)


@check(UNREACHABLE, needs_whole="form")
def never_holds(run: Pass) -> Iterator[Diagnostic]:
    """Find methods that are never chosen."""
    never = {id(one.formula) for one in run.result(CONTRADICTIONS)}
    for rap in run.library.forms:
        if isinstance(rap, nodes.DefineRap):
            yield from one_for_each_place(_rap(run, rap, never))


def _rap(
    run: Pass, rap: nodes.DefineRap, never: Container[int]
) -> Iterator[Diagnostic]:
    given = given_names(rap)
    goals = [_goal(formula, given) for formula in _ways_to_succeed(rap)]
    at = _Chosen(run, given, list(_held(rap, given, never)), goals)
    hopeless = _succeeds_first(at, rap) or _apart(at, rap)
    if hopeless is not None:
        yield hopeless
        return
    looped = rap.repeat_while
    if looped is not None and id(looped) not in never:
        whole, found = _never(at, looped, "repeat-while")
        yield from found
        if whole:
            return
        at.held.extend(_Asked(one, "repeat-while", one) for one in literals(looped))
    always: nodes.Method | None = None
    behind: list[nodes.Formula] = []
    for method in rap.methods:
        if method.context is None:
            always = always or method
        elif id(method.context) not in never:
            if always is not None and _asks_otherwise(method.context):
                behind.append(method.context)
            else:
                yield from _never(at, method.context, "this method")[1]
    if always is not None and behind:
        yield _after_always(behind, always)


def _succeeds_first(at: _Chosen, rap: nodes.DefineRap) -> Diagnostic | None:
    """Find a clause that has to hold for a method, and holds with `succeed` alone."""
    for clause, formula in _required(rap) if rap.methods else ():
        own = [one.literal for one in at.held if one.clause == clause.word]
        goal = at.goal_of(own)
        if goal is not None:
            return clash_at(
                UNREACHABLE,
                f"no method is ever chosen: where `{clause.word}` holds, "
                "`succeed` does",
                formula.span,
                Label(goal.span, "the RAP has succeeded then"),
            )
    return None


def _apart(at: _Chosen, rap: nodes.DefineRap) -> Diagnostic | None:
    """Find clauses that have to hold for any method, and never hold together."""
    every = [one.literal for one in at.held]
    if not every or not rap.methods:
        return None
    clash = first_clash(at.run, (), every, at.given)
    if clash is None:
        return None
    asked = {id(one.literal): one for one in at.held}
    first, second = asked.get(id(clash.first)), asked.get(id(clash.second))
    if first is None or second is None or first.clause == second.clause:
        return None
    return clash_at(
        UNREACHABLE,
        f"no method is ever chosen: {said(second.written)} never holds where "
        f"`{first.clause}` does",
        clash.second.span,
        Label(clash.first.span, _why(first.clause)),
    )


def _held(
    rap: nodes.DefineRap, given: set[str], never: Container[int]
) -> Iterator[_Asked]:
    """Yield what holds where a method is chosen, in variables of its own.

    Clauses whose ids are among `never` hold nowhere, as is said of them already.
    """
    for clause, formula in _required(rap):
        if id(formula) not in never:
            yield from _named_apart(formula, given, clause.word)
    goal = rap.succeed
    for part in ways(goal):
        if isinstance(part, nodes.Not):
            yield from _named_apart(part.part, given, "succeed")


def _named_apart(
    formula: nodes.Formula, given: Container[str], clause: str
) -> Iterator[_Asked]:
    renamed = literals(apart(formula, given, f"@{clause}"))
    for one, written in zip(renamed, literals(formula), strict=True):
        yield _Asked(one, clause, written)


def _required(rap: nodes.DefineRap) -> Iterator[tuple[Clause, nodes.Formula]]:
    """Yield the clauses that hold where a method is chosen and keep no bindings."""
    for clause, formula in clauses.held(clauses.RAP, rap):
        if clause.required and not clause.hands_on:
            yield clause, formula


def _ways_to_succeed(rap: nodes.DefineRap) -> Iterator[nodes.Formula]:
    """The conjunctions of which none has a solution where a method is chosen."""
    goal = rap.succeed
    if goal is None:
        okay = nodes.Const("okay", span=rap.name_span)
        yield nodes.HistoryTest("last-result", (okay,), span=rap.name_span)
    elif isinstance(goal, nodes.Or):
        yield from goal.parts
    elif not isinstance(goal, nodes.Truth):
        yield goal


def _never(
    at: _Chosen, formula: nodes.Formula, what: str
) -> tuple[bool, Sequence[Diagnostic]]:
    """Say whether a formula never holds at a choice, or which branches of it do not."""
    dead: list[Diagnostic] = []
    own = list(literals(formula))
    whole = _refuted(at, own, own, formula.span, what)
    if whole is not None:
        return True, [whole]
    for place, literal in enumerate(own):
        if isinstance(literal.formula, nodes.Or) and literal.holds:
            before, behind = own[:place], own[place + 1 :]
            parts = literal.formula.parts
            branches = [(part.span, list(literals(part))) for part in parts]
            found = [
                _refuted(at, [*before, *branch, *behind], branch, span, "this branch")
                for span, branch in branches
            ]
            if parts and all(found):
                message = f"{what} is never chosen: no branch of this ever holds"
                label = (
                    found[0].labels[0]
                    if found[0] and found[0].labels
                    else Label(formula.span, "")
                )
                return True, [clash_at(UNREACHABLE, message, literal.span, label)]
            dead += [one for one in found if one is not None]
    return False, dead


def _refuted(
    at: _Chosen,
    own: Sequence[Literal],
    about: Sequence[Literal],
    span: Span,
    what: str,
) -> Diagnostic | None:
    """Say why literals, none of which contradict each other, never hold.

    Args:
        at: what is so where a method is chosen.
        own: the literals, in the order in which they are asked.
        about: those of them that may be told of.
        span: where they stand.
        what: what they are.
    """
    clash = at.clash(own)
    if clash is not None:
        clause = next((a.clause for a in at.held if a.literal is clash.first), None)
        if clause is None or not any(clash.second is one for one in about):
            return None
        return clash_at(
            UNREACHABLE,
            f"{said(clash.second)} never holds when a method is chosen",
            clash.second.span,
            Label(clash.first.span, _why(clause)),
        )
    held = [one.literal for one in at.held if one.clause != "succeed"]
    goal = at.goal_of([*held, *own])
    if goal is None:
        return None
    return clash_at(
        UNREACHABLE,
        f"{what} is never chosen: where this holds, `succeed` does",
        span,
        Label(goal.span, "the RAP has succeeded then"),
    )


def _why(clause: str) -> str:
    if clause == "succeed":
        return "this holds as long as `succeed` does not"
    return f"`{clause}` asks for this"


def _asks_otherwise(context: nodes.Formula) -> bool:
    return any(isinstance(one.formula, nodes.Otherwise) for one in literals(context))


def _after_always(
    contexts: Sequence[nodes.Formula], always: nodes.Method
) -> Diagnostic:
    further = [Label(other.span, "nor is this one") for other in contexts[1:]]
    return UNREACHABLE.at(
        contexts[0].span,
        "this method is never chosen: one before it has no context",
        labels=(Label(always.span, "this one holds whatever happens"), *further),
    )


COPY = Rule(
    code="RAP112",
    name="copied-method",
    severity=Severity.WARNING,
    summary="two methods of a RAP say the same",
    why="""A second method is another way to do a thing: it is chosen when the first has
failed (T 3.2.2). One that says the same in the same situation is no other way, and its
tries only put off the failure. Mostly it was copied to be changed.""",
    ignore="where the second one is there to be tried once more",
    source="T 3.2.2",
    example="""\
(declare-primitive push (?door) (okay))
(define-rap (open ?door)
  (method push (primitive (push ?door)))
  (method pull (primitive (push ?door))))
""",
    better="""\
(declare-primitive push (?door) (okay))
(declare-primitive pull (?door) (okay))
(define-rap (open ?door)
  (method push (primitive (push ?door)))
  (method pull (primitive (pull ?door))))
""",
)

AT_ONCE = Rule(
    code="RAP113",
    name="succeeds-at-once",
    severity=Severity.WARNING,
    summary="a RAP has succeeded before any of its methods can be chosen",
    why="""`succeed` is asked before a method is chosen (T 3.2.3). One that holds
whatever happens, because nothing in it can fail, makes the methods idle. A property has
a value even if nothing is known, its default: `(battery ?level)` always holds.""",
    ignore="never: leave the methods out if nothing is to be done",
    source="T 3.2.3",
    example="""\
(declare-memory-property battery (?level) unknown)
(declare-primitive read-gauge () (okay))
(define-rap (look-at-battery => ?level)
  (succeed (battery ?level))
  (method (primitive (read-gauge))))
""",
    better="""\
(declare-memory-property battery (?level) unknown)
(declare-primitive read-gauge () (okay))
(define-rap (look-at-battery => ?level)
  (succeed (and (battery ?level) (n= ?level unknown)))
  (method (primitive (read-gauge))))
""",
)

NEVER = Rule(
    code="RAP114",
    name="never-succeeds",
    severity=Severity.WARNING,
    summary="a RAP can never succeed, and no monitor lets it wait",
    why="""`(succeed nil)` makes a standing task: it acts whenever its monitor wakes it
and is never done (T 4.7.1). Without a monitor, and without a step that waits for a
signal or a time, its methods follow each other without a pause, until nothing changes
any more and the task fails.""",
    ignore="where the task is to go on until it fails as futile, as in a test",
    source="T 4.7.1",
    example="""\
(declare-primitive look () (okay))
(define-rap (keep-looking)
  (succeed nil)
  (method (primitive (look))))
""",
    better="""\
(declare-primitive look () (okay))
(define-rap (keep-looking)
  (succeed nil)
  (monitor-time now 10 15)
  (method (primitive (look))))
""",
)

ALWAYS = Rule(
    code="RAP115",
    name="monitor-always-holds",
    severity=Severity.WARNING,
    summary="a monitor holds whatever happens, so that it lets nothing wait",
    why="""A monitor keeps a task asleep until its formula holds (T 4.7.1). One in which
nothing can fail keeps nobody asleep: the methods follow each other without a pause. A
property has a value even if nothing is known, its default, so a fact that asks for it
with a fresh variable always holds; a test of the value is missing.""",
    ignore="never: leave the monitor out if the task is to wait for nothing",
    source="T 4.7.1",
    example="""\
(declare-memory-property battery (?level) unknown)
(define-rap (charge))
(define-rap (keep-charged)
  (succeed nil)
  (monitor-state (battery ?level))
  (method (task-net (t1 (charge)))))
""",
    better="""\
(declare-memory-property battery (?level) unknown)
(define-rap (charge))
(define-rap (keep-charged)
  (succeed nil)
  (monitor-state (and (battery ?level) (< ?level 20)))
  (method (task-net (t1 (charge)))))
""",
)

NOT_AT_FIRST = Rule(
    code="RAP116",
    name="never-begins",
    severity=Severity.WARNING,
    summary="a clause does not hold of a new set or counter, so no method begins",
    why="""`repeat-while`, `preconditions` and `constraints` have to hold before a
method is chosen. A set that the RAP declares is empty then, and a counter is where it
was set, for only the methods change them (T 4.8). A clause that asks for a member, or
for a number that counting would have to bring, never lets anything begin: mostly the
test is the wrong way round.""",
    ignore="where a host fills the set or sets the counter before the task begins",
    source="T 4.8.1",
    example="""\
(declare-memory-proposition room (?room))
(declare-memory-proposition seen (?thing))
(define-rap (look-in ?room))
(define-rap (look-everywhere)
  (succeed (seen keys))
  (resources (set ?seen))
  (repeat-while (and (room ?room) (member ?seen ?room)))
  (method (task-net (t1 (look-in ?room) (set-add ?seen ?room)))))
""",
    better="""\
(declare-memory-proposition room (?room))
(declare-memory-proposition seen (?thing))
(define-rap (look-in ?room))
(define-rap (look-everywhere)
  (succeed (seen keys))
  (resources (set ?seen))
  (repeat-while (and (room ?room) (not (member ?seen ?room))))
  (method (task-net (t1 (look-in ?room) (set-add ?seen ?room)))))
""",
)


@check(COPY, AT_ONCE, NEVER, ALWAYS, NOT_AT_FIRST, needs_whole="form")
def settled(run: Pass) -> Iterator[Diagnostic]:
    """Find methods that say the same, and clauses whose answer is settled."""
    always = Always(run.signatures)
    for rap in run.library.forms:
        if isinstance(rap, nodes.DefineRap) and rap.methods:
            given = given_names(rap)
            yield from _copies(rap)
            yield from _settled(rap, always, given)


def _copies(rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    if len(rap.methods) == 1:
        return
    first: dict[object, nodes.Method] = {}
    for method in rap.methods:
        if isinstance(method.body, nodes.TaskNet) and not method.body.steps:
            continue
        said = (
            method.context,
            method.notations,
            method.constraints,
            method.claims,
            method.skills,
            method.body,
        )
        other = first.setdefault(said, method)
        if other is not method:
            yield COPY.at(
                method.span,
                f"this method of `{rap.name}` says what another one says",
                labels=(Label(other.span, "the other one"),),
                help="change it, or take it away",
            )


def _settled(
    rap: nodes.DefineRap, always: Always, given: set[str]
) -> Iterator[Diagnostic]:
    succeed, monitor = rap.succeed, rap.monitor_state
    first = FirstValues(rap.resources)
    if rap.resources:
        yield from _not_at_first(rap, first)
    if any(first.holds(way) for way in ways(succeed)):
        assert succeed is not None
        yield AT_ONCE.at(
            succeed.span,
            f"`succeed` of `{rap.name}` holds before anything has been changed",
            labels=tuple(Label(r.variable.span, "begins here") for r in rap.resources),
        )
    elif succeed is not None and always.holds(succeed, given):
        yield AT_ONCE.at(
            succeed.span,
            f"`succeed` of `{rap.name}` holds whatever happens",
            help=_ADVICE if not isinstance(succeed, nodes.Truth) else "",
        )
    elif succeed is not None and is_never(succeed) and not _waits(rap):
        yield NEVER.at(
            succeed.span,
            f"`{rap.name}` never succeeds, and has no monitor",
            help="say in `monitor-state` or `monitor-time` what it waits for",
        )
    if monitor is not None and always.holds(monitor, given):
        yield ALWAYS.at(
            monitor.span,
            f"the monitor of `{rap.name}` holds whatever happens",
            help=_ADVICE if not isinstance(monitor, nodes.Truth) else "",
        )


def _not_at_first(rap: nodes.DefineRap, first: FirstValues) -> Iterator[Diagnostic]:
    for clause, formula in clauses.held(clauses.RAP, rap):
        failing = first.fails(formula) if clause.is_condition else None
        if failing is not None:
            yield NOT_AT_FIRST.at(
                failing.span,
                f"`{clause.word}` of `{rap.name}` does not hold at first, "
                "so no method ever begins",
                labels=tuple(
                    Label(r.variable.span, "begins here") for r in rap.resources
                ),
            )


_ADVICE = "a property has a value even if nothing is known: test the value"


def _waits(rap: nodes.DefineRap) -> bool:
    """Whether a RAP has a monitor, or a step that waits for a signal or for a time."""
    if rap.monitor_state is not None or rap.monitor_time is not None:
        return True
    return any(
        isinstance(annotation, nodes.WaitFor | nodes.Window)
        for method in rap.methods
        if isinstance(method.body, nodes.TaskNet)
        for step in method.body.steps
        for annotation in step.annotations
    )


class Always:
    """Tells formulas that hold whatever memory holds.

    Args:
        signatures: what is declared.
    """

    def __init__(self, signatures: Signatures) -> None:
        self._relations = signatures.predicates

    def holds(self, formula: nodes.Formula, given: set[str]) -> bool:
        """Whether a formula always holds where the variables `given` have values."""
        bound = set(given)
        return all(
            literal.holds and self._one(literal.formula, bound)
            if not isinstance(literal.formula, nodes.Truth)
            else literal.formula.value is literal.holds
            for literal in literals(formula)
        )

    def _one(self, formula: nodes.Formula, bound: set[str]) -> bool:
        if isinstance(formula, nodes.Or):
            holds = any(self.holds(part, bound) for part in formula.parts)
            bound.update(variable_names(formula))
            return holds
        if not isinstance(formula, nodes.Proposition):
            return False
        declared = self._relations.get(formula.name)
        if declared is None or not _has_default(declared):
            return False
        terms = declared.full(formula.args)
        if len(terms) != declared.most:
            return False
        value = terms[-1]
        fresh = isinstance(value, nodes.Var) and value.name not in bound
        known = all(
            isinstance(term, nodes.Const)
            or (isinstance(term, nodes.Var) and term.name in bound)
            for term in terms[:-1]
        )
        bound.update(v.name for v in operands(formula).matched if type(v) is nodes.Var)
        return fresh and known


def _has_default(declared: Signature) -> bool:
    return declared.is_property and declared.default in CONSTANT_DEFAULTS
