"""RAP112 to RAP116: clauses whose answer is settled before the world has a say.

A property with a default has a value whatever happens: a fact that asks for it with a
fresh variable always holds [L 2.20].
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.logic import is_never, literals
from rapc.analysis.facts.resources import FirstValues
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import clauses, nodes
from rapc.ir.schema import operands
from rapc.ir.walk import variable_names
from rapc.library.signature import CONSTANT_DEFAULTS, Signature
from rapc.library.signatures import Signatures

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
            given = {v.name for v in rap.inputs}
            given |= {r.variable.name for r in rap.resources}
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
    parts = succeed.parts if isinstance(succeed, nodes.Or) else (succeed,)
    if any(part is not None and first.holds(part) for part in parts):
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
