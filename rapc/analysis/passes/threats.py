"""RAP126: steps that may undo what another step protects for a third.

Between the end of a step with `(formula for t)` and the start of t, any step may run
that order allows there: a threat, as planners with partial orders call it. What a step
brings about is taken from its RAP where that is certain: declared `effects`, `succeed`,
and what all of its primitives do if they end `okay`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.literals import Conjunction, Literal, literals, names
from rapc.analysis.passes.task_nets import TASK_NETS, Net, sure_nets
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes
from rapc.ir.printer import format_formula, format_goal
from rapc.library.library import Library

_WORLD = """\
(declare-memory-proposition bay-open ())
(declare-primitive open-bay () (okay) :on (okay (bay-open)))
(declare-primitive close-bay () (okay) :on (okay (not (bay-open))))
(declare-primitive unload () (okay))
(define-rap (open) (method (primitive (open-bay))))
(define-rap (close) (method (primitive (close-bay))))
(define-rap (empty) (method (primitive (unload))))
"""

THREAT = Rule(
    code="RAP126",
    name="threatened-protection",
    severity=Severity.WARNING,
    summary="a step may undo what another step protects with `for`",
    why="""A formula with `for` has to hold until the step begins that it is for; if it
does not, the work is done in vain. A step that surely makes it false, and that order
allows in between, may come just then: only priority or chance tells. Put that step
before the one that protects, or after the one that needs what is protected.""",
    example=_WORLD
    + """\
(define-rap (deliver)
  (method (task-net
    (t1 (open) ((bay-open) for t2))
    (t2 (empty))
    (t3 (close)))))
""",
    better=_WORLD
    + """\
(define-rap (deliver)
  (method (task-net
    (t1 (open) ((bay-open) for t2))
    (t2 (empty) (for t3))
    (t3 (close)))))
""",
)


def _run(run: Pass) -> None:
    for steps, net in sure_nets(run):
        for found in _threats(run, steps, net):
            run.report(found)


ANALYZER = Analyzer(
    name="threats",
    doc="Finds steps that may undo what another step protects for a third.",
    run=_run,
    needs=(TASK_NETS,),
    rules=(THREAT,),
    needs_whole="method",
)


def _threats(run: Pass, steps: Sequence[nodes.Step], net: Net) -> Iterator[Diagnostic]:
    protected = list(_protected(steps))
    if not protected or net.order is None:
        return
    places = {step.tag: at for at, step in enumerate(steps)}
    before, after = _reach(net, net.order)
    changes: dict[str, list[tuple[int, Literal]]] = {}
    for at, step in enumerate(steps):
        for effect in _done(run.library, step.goal) if at not in net.early else ():
            changes.setdefault(_name(effect), []).append((at, effect))
    for at, note, wanted in protected:
        other = places[note.tag]
        apart = before[at] | after[other] | 1 << at | 1 << other
        for by, effect in changes.get(_name(wanted), ()):
            if not apart >> by & 1 and _contradict(run, wanted, effect):
                yield _finding(note, wanted, steps[by])


def _protected(
    steps: Sequence[nodes.Step],
) -> Iterator[tuple[int, nodes.For, Literal]]:
    """Yield the facts that steps protect, each with the step's position and where."""
    for at, step in enumerate(steps):
        for note in step.annotations:
            if isinstance(note, nodes.For):
                for one in literals(note.formula):
                    if _name(one):
                        yield at, note, one


def _reach(net: Net, order: Sequence[int]) -> tuple[list[int], list[int]]:
    """Return for each step those before it and those after it, as sets of bits."""
    before = [0] * len(order)
    after = [0] * len(order)
    for at in order:
        for edge in net.edges[at]:
            before[at] |= before[edge.before] | 1 << edge.before
    for at in reversed(order):
        for edge in net.edges[at]:
            after[edge.before] |= after[at] | 1 << at
    return before, after


def _name(literal: Literal) -> str:
    """The name of the fact that a literal is about; nothing if it is about none."""
    fact = literal.formula
    return fact.name if isinstance(fact, nodes.Proposition) else ""


def _contradict(run: Pass, wanted: Literal, effect: Literal) -> bool:
    given = names(wanted.formula) | names(effect.formula)
    both = Conjunction(run.signatures.relations, given)
    both.add(wanted)
    return both.add(effect) is not None


def _done(library: Library, goal: nodes.Goal) -> list[Literal]:
    """Return what surely comes of a goal that is reached, in the caller's terms."""
    rap = library.raps.get(goal.name)
    if rap is None:
        return []
    found = [_effect(effect) for effect in rap.effects]
    found += [one for one in literals(rap.succeed) if _name(one)]
    if rap.succeed is None:
        found += _of_methods(library, rap)
    return _put_in(
        found, {v.name: t for v, t in zip(rap.inputs, goal.args, strict=False)}
    )


def _of_methods(library: Library, rap: nodes.DefineRap) -> list[Literal]:
    """Return what every method of a RAP brings about, if each is a primitive."""
    every: list[list[Literal]] = []
    for method in rap.methods:
        if not isinstance(method.body, nodes.Primitive):
            return []
        request = method.body.request
        form = library.primitives.get(request.name)
        if form is None:
            return []
        given = dict(
            zip([a.variable.name for a in form.args], request.args, strict=False)
        )
        okay = [on for on in form.on if on.result == "okay"]
        done = [_effect(e) for on in okay for e in on.effects if not e.possible]
        every.append(_put_in(done, given))
    return (
        [one for one in every[0] if all(one in row for row in every)] if every else []
    )


def _effect(effect: nodes.DeclaredEffect) -> Literal:
    return Literal(effect.pattern, not effect.negated)


def _put_in(found: Sequence[Literal], given: Mapping[str, nodes.Term]) -> list[Literal]:
    """Return literals with terms for their variables, without those that keep some."""
    made = []
    for one in found:
        fact = one.formula
        assert isinstance(fact, nodes.Proposition)
        args = [
            given.get(term.name) if isinstance(term, nodes.Var) else term
            for term in fact.args
        ]
        plain = [arg for arg in args if isinstance(arg, nodes.Var | nodes.Const)]
        if len(plain) == len(args):
            made.append(
                Literal(msgspec.structs.replace(fact, args=tuple(plain)), one.holds)
            )
    return made


def _finding(note: nodes.For, undone: Literal, step: nodes.Step) -> Diagnostic:
    written = format_formula(undone.formula)
    if not undone.holds:
        written = f"(not {written})"
    return Diagnostic(
        rule=THREAT.name,
        message=f"step `{step.tag}` may undo `{written}` before `{note.tag}` begins",
        span=note.span,
        labels=(
            Label(step.goal.span, f"`{format_goal(step.goal)}` may run in between"),
        ),
        help=f"put `{step.tag}` before this step, or after `{note.tag}`",
    )
