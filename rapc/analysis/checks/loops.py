"""RAP118: `repeat-while` without repetition, or with identical repetitions.

Before each method the interpreter evaluates `succeed` and then `repeat-while` [L 3]. A
RAP repeats as long as `succeed` does not hold and `repeat-while` holds. A task may
choose a method with equal bindings in two rounds; the third such round is futile [L
3.38].

RAP123: a RAP that calls itself with its own inputs [L 3.42].

A step whose arguments are inputs of its RAP or constants passes these values on
unchanged. The check follows such steps and reports a path that returns to the RAP with
the initial inputs.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.effects import (
    ACTING,
    EFFECTS,
    Effect,
    acts_itself,
    done_by_method,
    reached,
)
from rapc.analysis.facts.logic import (
    asked_by,
    entails,
    is_known,
    is_never,
)
from rapc.analysis.facts.statistics import LIMITS
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.graph import circles
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.printer import format_formula, format_goal
from rapc.ir.walk import (
    formulas,
    given_names,
    steps,
    subformulas,
    substitute,
    through_queries,
    variable_names,
    ways,
)
from rapc.library.library import Library, own_methods

IDLE = Rule(
    code="RAP118",
    name="idle-loop",
    severity=Severity.WARNING,
    summary="`repeat-while` repeats nothing, or finds the same thing in each round",
    fix="unsafe: adds a `succeed` that holds when nothing is left",
    ignore="where another task changes the queried facts meanwhile",
    source="T 4.6",
)


@check(IDLE, needs_whole="form")
def idle_loops(run: Pass) -> Iterator[Diagnostic]:
    """Find loops without repetition, and loops with identical rounds."""
    told = {
        effect.pattern.name
        for datum in run.library.data.values()
        for effect in datum.on or ()
    }
    for rap in run.library.raps.values():
        if rap.repeat_while is None or not rap.methods:
            continue
        taken = _taken(run, rap.repeat_while) - given_names(rap)
        if not taken:
            continue
        if rap.succeed is None and rap.monitor_state is None:
            yield _repeats_nothing(rap, rap.repeat_while)
        if rap.succeed and run.complete and not is_never(rap.succeed):
            yield from _same_again(run, rap, rap.repeat_while, min(taken), told)


EARLY = Rule(
    code="RAP188",
    name="early-end",
    severity=Severity.WARNING,
    summary="a RAP without `succeed` ends after a method that only waits, or "
    "after one round of a loop with several methods",
    ignore="where the methods only repeat after failures",
    source="T 3.2.3",
)


@check(EARLY, needs_whole="form")
def early_ends(run: Pass) -> Iterator[Diagnostic]:
    """Find RAPs that end when any of several unlike methods has succeeded.

    A loop of requests that may fail repeats after failures, until one method succeeds.
    """
    for rap in run.library.raps.values():
        if rap.succeed is not None or len(rap.methods) == 1 or not rap.methods:
            continue
        own = {resource.variable.name for resource in rap.resources}
        contexts = [m.context for m in rap.methods if m.context is not None]
        counted = not own.isdisjoint(variable_names(*contexts))
        waits = [method for method in rap.methods if _only_waits(run, method)]
        if (rap.repeat_while is not None or counted) and not _may_fail(run, rap):
            place = (rap.repeat_while or contexts[0]).span
            why = "and repeats only after failures"
            without = "this limits only repetitions after failures"
        elif waits and len(waits) < len(rap.methods):
            place = waits[0].body.span
            why = "also when the method has only waited"
            without = "this method only waits"
        else:
            continue
        yield EARLY.at(
            rap.name_span,
            f"`{rap.name}` ends when any of its methods has succeeded, {why}",
            labels=(Label(place, without),),
            help="add `succeed` with the state that all methods work towards",
        )


def _may_fail(run: Pass, rap: nodes.DefineRap) -> bool:
    """Return whether a request below a RAP has several results."""
    requests = [
        method.body.request.name
        for below in reached(run.library, [rap.name]).values()
        for method in below.methods
        if isinstance(method.body, nodes.Primitive)
    ]
    declared = [run.library.primitives.get(name) for name in requests]
    return any(form is not None and len(form.results) > 1 for form in declared)


def _only_waits(run: Pass, method: nodes.Method) -> bool:
    """Return whether a method waits or acts, but changes nothing that is declared."""
    done, whole = run.result(EFFECTS).of_method(method)
    if not isinstance(method.body, nodes.TaskNet) or not whole or done:
        return False
    acting = run.result(ACTING)
    return acts_itself(method) or any(s.goal.name in acting for s in steps(method))


def _repeats_nothing(rap: nodes.DefineRap, loop: nodes.Formula) -> Diagnostic:
    word, own = f"(succeed (not {format_formula(loop)}))", own_methods(rap)
    over = own[0].span.start if own else rap.span.end - 1
    word = f"{word}\n  " if own else f"\n  {word}"
    edit = Edit(Span(rap.span.file, over, over), word)
    return IDLE.at(
        loop.span,
        f"`{rap.name}` ends when a method has succeeded once, and repeats nothing",
        labels=(Label(rap.name_span, "the RAP has no `succeed`"),),
        help="add a `succeed` that holds when the work is done",
        fix=Fix(
            Applicability.UNSAFE, "add `succeed` for the end of the repetition", (edit,)
        ),
    )


def _same_again(
    run: Pass, rap: nodes.DefineRap, loop: nodes.Formula, taken: str, told: set[str]
) -> Iterator[Diagnostic]:
    """Yield a loop that surely binds the same value in its second round."""
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
        f"each round finds the same `{taken}`: no method of "
        f"`{rap.name}` changes the queried facts",
        help=_said(done),
    )


def _taken(run: Pass, loop: nodes.Formula) -> set[str]:
    """Return the variables that may take different values in turn.

    A property has one value at a time: a variable with that value is no loop over
    things.
    """
    found: set[str] = set()
    for one in subformulas(loop):
        if isinstance(one, nodes.Proposition):
            is_value = one.name in run.library.properties
            terms = one.args[:-1] if is_value else one.args
            found |= {t.name for t in terms if isinstance(t, nodes.Var)}
    return found - {"?"}


def _counts(rap: nodes.DefineRap) -> bool:
    """Return whether methods change or pass on resources, so that choices differ.

    A `set-add` to a set that no formula queries does not count as a change.
    """
    own = {resource.variable.name for resource in rap.resources}
    asked = variable_names(*[one.formula for one in formulas(rap)])
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
    """Return whether a formula queries only facts and sets."""
    return all(
        isinstance(one, nodes.SetTest) or is_known(run.library, one)
        for one in through_queries(formula, run.library.queries)
        if not isinstance(one, nodes.And | nodes.Or | nodes.Not)
    )


def _is_enough(run: Pass, rap: nodes.DefineRap, method: nodes.Method) -> bool:
    """Return whether `succeed` surely holds after a method has succeeded."""
    done, given = done_by_method(run.library, method), given_names(rap)
    relations = run.signatures.relations
    return any(entails(done, way, given, relations) for way in ways(rap.succeed))


def _said(done: Sequence[Effect]) -> str:
    changed = sorted({f"`{effect.name}`" for effect in done})[:4]
    if not changed:
        return "store the processed values in a set"
    return (
        f"the methods change {', '.join(changed)}: query these, or "
        "store the values in a set"
    )


ITSELF = Rule(
    code="RAP123",
    name="needs-itself",
    severity=Severity.WARNING,
    summary="a RAP requires itself with the same inputs",
    ignore="never: the step fails as futile each time",
    source="T 3.2.5",
)


@check(ITSELF, needs_whole="method")
def needs_itself(run: Pass) -> Iterator[Diagnostic]:
    """Find RAPs that call themselves with their own inputs."""
    raps = run.library.raps
    calls = {name: list(_handing_on(rap)) for name, rap in raps.items()}
    names = {name: [s.goal.name for s in made] for name, made in calls.items()}
    circling = {name for circle in circles(names) for name in circle}
    told: set[int] = set()
    for rap in raps.values() if circling else ():
        path = _way_back(run.library, rap, calls) if rap.name in circling else None
        if path and not any(id(step) in told for step in path):
            told.update(id(step) for step in path)
            yield _needing(rap, path)


def _handing_on(rap: nodes.DefineRap) -> Iterator[nodes.Step]:
    """Yield the steps that pass on only inputs and constants."""
    for method in rap.methods:
        for step in steps(method):
            if all(
                isinstance(t, nodes.Const) or t in rap.inputs for t in step.goal.args
            ):
                yield step


def _way_back(
    library: Library, rap: nodes.DefineRap, calls: Mapping[str, Sequence[nodes.Step]]
) -> list[nodes.Step] | None:
    """Return the steps along which a RAP calls itself, or None."""
    start: tuple[nodes.Term, ...] = rap.inputs
    waiting = deque([(rap, start, list[nodes.Step]())])
    seen = {(rap.name, start)}
    for _ in range(LIMITS.walk_steps):
        if not waiting:
            return None
        here, args, path = waiting.popleft()
        terms = {v.name: term for v, term in zip(here.inputs, args, strict=False)}
        for step in calls[here.name] if len(path) < LIMITS.walk_depth else ():
            if not terms.keys() >= {*variable_names(*step.goal.args)}:
                continue
            goal = substitute(step.goal, terms)
            if goal.name == rap.name and goal.args == start:
                return [*path, step]
            if goal.name in calls and (goal.name, goal.args) not in seen:
                seen.add((goal.name, goal.args))
                waiting.append((library.raps[goal.name], goal.args, [*path, step]))
    return None


def _needing(rap: nodes.DefineRap, path: Sequence[nodes.Step]) -> Diagnostic:
    through = [f"`{step.goal.name}`" for step in path[:-1]]
    said = f", through {', '.join(through)}" if through else ""
    return ITSELF.at(
        path[0].goal.span,
        f"`{rap.name}` requires itself with the same inputs{said}",
        labels=tuple(
            Label(step.goal.span, f"this RAP requires `{format_goal(step.goal)}`")
            for step in path[1:]
        ),
        help="use another RAP, or the same RAP with different inputs",
    )
