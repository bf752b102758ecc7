"""RAP118: `repeat-while` that repeats nothing, or the same thing again and again.

A RAP is asked for `succeed`, then for `repeat-while`, before each method [L 3]. So it
goes round as long as the one does not hold and the other does. Two rounds in which a
method is chosen with equal bindings are all that a task has: the third is futile [L
3.38].
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import EFFECTS, Effect, done_by_method
from rapc.analysis.facts.logic import (
    apart,
    asked_by,
    follows,
    is_known,
    is_never,
    literals,
    through,
)
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import formulas, steps, subformulas, variable_names, variables

_SWEEP = """\
(declare-memory-proposition dirty (?room))
(declare-primitive sweep (?room) (okay) :on (okay (not (dirty ?room))))
(define-rap (clean ?room) (method (primitive (sweep ?room))))
(define-rap (clean-everything)
{}  (repeat-while (dirty ?room))
  (method (task-net (t1 (clean ?room)))))
"""

IDLE = Rule(
    code="RAP118",
    name="idle-loop",
    severity=Severity.WARNING,
    summary="`repeat-while` repeats nothing, or takes the same thing in each round",
    why="""A task chooses methods as long as `succeed` does not hold and `repeat-while`
does (T 3.2.3). Without `succeed` it is done as soon as one method has ended well, so
nothing is repeated. Where the methods change nothing that `repeat-while` or a context
asks for, each round finds what the one before has found; the third time the task fails,
`futile-loop` (T 3.2.5). A `repeat-while` that binds nothing is a condition for trying
again, and not looked at; nor is one without `succeed` behind a monitor. Say in
`succeed` when the work is done, and let each round take away what it has dealt with, or
remember it in a set.""",
    fix="unsafe: adds a `succeed` for when there is nothing left to repeat",
    ignore="where another task changes what is asked for in between",
    source="T 4.6",
    example=_SWEEP.format(""),
    better=_SWEEP.format("  (succeed (not (dirty ?)))\n"),
)


@check(IDLE, needs_whole="form")
def idle_loops(run: Pass) -> Iterator[Diagnostic]:
    """Find loops that repeat nothing, or do the same in each round."""
    told = {
        effect.pattern.name
        for datum in run.library.data.values()
        for effect in datum.on or ()
    }
    for rap in run.library.raps.values():
        if rap.repeat_while is None or not rap.methods:
            continue
        taken = _taken(run, rap.repeat_while) - _given(rap)
        if not taken:
            continue
        if rap.succeed is None and rap.monitor_state is None:
            yield _repeats_nothing(rap, rap.repeat_while)
        if rap.succeed and run.complete and not is_never(rap.succeed):
            yield from _same_again(run, rap, rap.repeat_while, min(taken), told)


def _repeats_nothing(rap: nodes.DefineRap, loop: nodes.Formula) -> Diagnostic:
    over = rap.methods[0].span.start
    word = f"(succeed (not {format_formula(loop)}))\n  "
    edit = Edit(Span(rap.span.file, over, over), word)
    return IDLE.at(
        loop.span,
        f"`{rap.name}` is done when a method has ended well once, and repeats nothing",
        labels=(Label(rap.name_span, "it has no `succeed`"),),
        help="say in `succeed` when the work is done",
        fix=Fix(Applicability.UNSAFE, "go on until there is none", (edit,)),
    )


def _same_again(
    run: Pass, rap: nodes.DefineRap, loop: nodes.Formula, taken: str, told: set[str]
) -> Iterator[Diagnostic]:
    """Yield a loop that surely takes the same thing in its second round."""
    done = run.result(EFFECTS).of(rap.name)
    if done is None or _counts(rap):
        return
    asked = [loop, *(m.context for m in rap.methods if m.context is not None)]
    if not all(is_known(run.library, one) or _asks_sets(run, one) for one in asked):
        return
    facts = {name for one in asked for name in asked_by(run.library, one)}
    if facts & {effect.name for effect in done} or facts & told:
        return
    if any(_is_enough(run, rap, method) for method in rap.methods):
        return
    yield IDLE.at(
        loop.span,
        f"each round finds the same `{taken}`: no method of `{rap.name}` "
        "changes what is asked for",
        help=_said(done),
    )


def _taken(run: Pass, loop: nodes.Formula) -> set[str]:
    """Return the variables that may take one thing after another.

    A property has one value at a time: what is bound to that is no loop over things.
    """
    found: set[str] = set()
    for one in subformulas(loop):
        if isinstance(one, nodes.Proposition):
            is_value = one.name in run.library.properties
            terms = one.args[:-1] if is_value else one.args
            found |= {t.name for t in terms if isinstance(t, nodes.Var)}
    return found - {"?"}


def _given(rap: nodes.DefineRap) -> set[str]:
    return {variable.name for variable in rap.inputs} | {
        resource.variable.name for resource in rap.resources
    }


def _counts(rap: nodes.DefineRap) -> bool:
    """Whether methods change resources, or hand them on: no choice equals another.

    A set that nothing asks for is the same again when it is given the same again.
    """
    own = {resource.variable.name for resource in rap.resources}
    asked = {
        variable.name for one in formulas(rap) for variable in variables(one.formula)
    }
    for method in rap.methods:
        for step in steps(method):
            for note in step.annotations:
                if isinstance(note, nodes.ResourceChange) and not (
                    note.op == "set-add"
                    and isinstance(note.resource, nodes.Var)
                    and note.resource.name not in asked
                ):
                    return True
            if any(isinstance(t, nodes.Var) and t.name in own for t in step.goal.args):
                return True
    return False


def _asks_sets(run: Pass, formula: nodes.Formula) -> bool:
    """Whether a formula asks facts and sets alone."""
    return all(
        isinstance(one, nodes.SetTest) or is_known(run.library, one)
        for one in through(run.library, formula)
        if not isinstance(one, nodes.And | nodes.Or | nodes.Not)
    )


def _is_enough(run: Pass, rap: nodes.DefineRap, method: nodes.Method) -> bool:
    """Whether `succeed` surely holds when a method has ended well."""
    assert rap.succeed is not None
    done = done_by_method(run.library, method)
    parts = rap.succeed.parts if isinstance(rap.succeed, nodes.Or) else (rap.succeed,)
    for part in parts:
        wanted = list(literals(apart(part, _given(rap), "@goal")))
        free = set(variable_names(*[one.formula for one in wanted])) - _given(rap)
        if follows(wanted, done, free, run.signatures.relations):
            return True
    return False


def _said(done: Sequence[Effect]) -> str:
    changed = sorted({f"`{effect.name}`" for effect in done})[:4]
    if not changed:
        return "remember in a set what was dealt with"
    return f"they change {', '.join(changed)}: ask for that, or remember it in a set"
