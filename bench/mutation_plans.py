"""Slips in plans: copies, sensing, monitors, planning, structure, conditions, loops.

As in `bench.mutation_words`, a kind yields every place where the slip can be made.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Iterator, Mapping
from itertools import pairwise

from bench.mutation_base import Base, Edit, Kind, negated, swap
from rapc.analysis.facts.effects import reached
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import formulas, steps, subformulas
from rapc.library.library import word_span

# --- copies ---------------------------------------------------------------------------


def _behind(span: Span) -> Span:
    return Span(span.file, span.end, span.end)


def _step_twice(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        text = base.text(step.span)
        yield Edit(_behind(step.span), f"\n{text.replace(step.tag, 'again', 1)}")


def _goal_of_the_step_before(base: Base) -> Iterator[Edit]:
    for _, _, net in base.nets():
        for one, other in pairwise(net.steps):
            if one.goal != other.goal:
                yield Edit(other.goal.span, base.text(one.goal.span))


def _methods(
    base: Base,
) -> Iterator[tuple[nodes.DefineRap, nodes.Method, nodes.Method]]:
    for rap in base.raps:
        for one, other in pairwise(rap.methods):
            yield rap, one, other


def _context_of_another(base: Base) -> Iterator[Edit]:
    """A method is copied, and its context stays as it was."""
    for _, one, other in _methods(base):
        if one.context is not None and other.context not in (None, one.context):
            assert other.context is not None
            yield Edit(other.context.span, base.text(one.context.span))


def _body_of_another(base: Base) -> Iterator[Edit]:
    """A method is copied, and its body stays as it was."""
    for _, one, other in _methods(base):
        if one.body != other.body:
            yield Edit(other.body.span, base.text(one.body.span))


def _copied_otherwise(base: Base) -> Iterator[Edit]:
    """A method with no context of its own stands a second time, with a new name."""
    for rap in base.raps:
        for method in rap.methods[-1:]:
            if len(rap.methods) > 1 and method.name is not None:
                text = base.text(method.span)
                again = re.sub(r"\A\(method\s+[^\s()]+", "(method again", text)
                again = re.sub(r"\(context .*", "(context true)", again, count=1)
                if again.count("(") == again.count(")"):
                    yield Edit(_behind(method.span), f"\n{again}")


def _constant_left(base: Base) -> Iterator[Edit]:
    """Of a copied method, one constant is changed, and the others stay."""
    values = {
        value: kind.values
        for kind in base.library.kinds.values()
        for value in kind.values or ()
    }
    for rap in base.raps:
        for method in rap.methods:
            text = base.text(method.span)
            for value, others in values.items():
                word = rf"(?<=[( ]){re.escape(str(value))}(?=[ )])"
                places = [found.span() for found in re.finditer(word, text)]
                for start, end in places if len(places) > 1 else ():
                    at = method.span.start
                    span = Span(method.span.file, at + start, at + end)
                    near = [other for other in others or () if other != value]
                    for other in near[:1]:
                        yield Edit(span, str(other))


def _variable_left(base: Base) -> Iterator[Edit]:
    """A conjunct is copied, and its variable stays as it was."""
    for rap in base.raps:
        for one in formulas(rap):
            facts = [
                part
                for part in subformulas(one.formula)
                if isinstance(part, nodes.Proposition)
            ]
            for first, second in pairwise(facts):
                for mine, theirs in zip(first.args, second.args, strict=False):
                    both = isinstance(mine, nodes.Var) and isinstance(theirs, nodes.Var)
                    if first.name == second.name and both and mine != theirs:
                        yield Edit(theirs.span, base.text(mine.span))


def _step_argument_left(base: Base) -> Iterator[Edit]:
    """A step is copied, and one of its arguments stays as it was."""
    for _, _, net in base.nets():
        for one, other in pairwise(net.steps):
            if one.goal.name == other.goal.name:
                for mine, theirs in zip(one.goal.args, other.goal.args, strict=False):
                    if mine != theirs:
                        yield Edit(theirs.span, base.text(mine.span))


def _clause_of_the_rap_before(base: Base) -> Iterator[Edit]:
    """A RAP is copied with its inputs, and its `succeed` stays as it was."""
    for one, other in pairwise(base.raps):
        same = [v.name for v in one.inputs] == [v.name for v in other.inputs]
        if same and one.succeed and other.succeed and one.succeed != other.succeed:
            yield Edit(other.succeed.span, base.text(one.succeed.span))


# --- sensing --------------------------------------------------------------------------


def _belief_of_any_value(base: Base) -> Iterator[Edit]:
    """`(believe (tank ?) 50)`: any value will do, the default among them."""
    for one in base.index.of(nodes.Believe):
        if one.node.pattern.name in base.library.properties and one.node.pattern.args:
            last = one.node.pattern.args[-1]
            if base.text(last.span) != "?":
                yield Edit(last.span, "?")


def _unknown_allowed(base: Base) -> Iterator[Edit]:
    """`(n= ?level unknown)` is forgotten."""
    for one in base.index.of(nodes.Compare):
        unknown = one.node.op == "n=" and one.node.right == nodes.Const("unknown")
        if unknown and isinstance(one.parent, nodes.And):
            yield Edit(one.node.span, "")


def _belief_is_a_fact(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Believe):
        yield Edit(one.node.span, base.text(one.node.pattern.span))


def _older(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Believe):
        if isinstance(one.node.age, nodes.Const):
            yield Edit(one.node.age.span, f"{base.text(one.node.age.span)}00")


def _senses(base: Base, goal: nodes.Goal) -> bool:
    """Return whether a goal does nothing but sense: data come, or beliefs may."""
    forms = [
        base.library.primitives[method.body.request.name]
        for rap in reached(base.library, [goal.name]).values()
        for method in rap.methods
        if isinstance(method.body, nodes.Primitive)
        and method.body.request.name in base.library.primitives
    ]
    return bool(forms) and all(form.tells for form in forms)


def _sensing_dropped(base: Base) -> Iterator[Edit]:
    """A step that looks is dropped; others wait for nothing then."""
    for _, _, net in base.nets():
        for step in net.steps if len(net.steps) > 1 else ():
            if _senses(base, step.goal):
                yield _without(base, net, step)


def _without(base: Base, net: nodes.TaskNet, step: nodes.Step) -> Edit:
    """Return a net without a step, and without the annotations that name the step."""
    text = base.text(net.span)
    for other in reversed(net.steps):
        cut = [
            note.span
            for note in other.annotations
            if isinstance(note, nodes.For | nodes.UntilStart | nodes.UntilEnd)
            and note.tag == step.tag
        ]
        for span in [step.span] if other is step else reversed(cut):
            at = net.span.start
            text = text[: span.start - at] + text[span.end - at :]
    return Edit(net.span, text, step.tag)


def _sensing_unordered(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        notes = [note for note in step.annotations if isinstance(note, nodes.For)]
        if notes and _senses(base, step.goal):
            for note in notes:
                yield Edit(note.span, "")


# --- monitors -------------------------------------------------------------------------


def _monitored(base: Base) -> Container[str]:
    return {
        rap.name
        for rap in base.raps
        if rap.monitor_state is not None or rap.monitor_time is not None
    }


def _monitored_step_lowered(base: Base) -> Iterator[Edit]:
    """A step with a monitor gets the priority of the step that it is to interrupt."""
    names = _monitored(base)
    for _, step in base.steps():
        if step.goal.name in names and step.priority:
            text = base.text(step.span)
            yield Edit(step.span, text.replace(f" {step.priority} (", " (", 1))


def _monitored_step_unordered(base: Base) -> Iterator[Edit]:
    """A step with a monitor loses the end that another step set."""
    names = _monitored(base)
    for net, step in base.steps():
        tags = [s.tag for s in net.steps if s.goal.name in names]
        for note in step.annotations:
            if isinstance(note, nodes.UntilEnd) and note.tag in tags:
                yield Edit(note.span, "")


def _ended_at_once(base: Base) -> Iterator[Edit]:
    """A step is ended by the step that it waits for."""
    for _, step in base.steps():
        for note in step.annotations:
            if isinstance(note, nodes.For) and note.formula is None:
                yield Edit(_behind(note.span), f" (until-end {note.tag})")


def _conjunct_of_monitor_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        if isinstance(rap.monitor_state, nodes.And):
            for part in rap.monitor_state.parts:
                yield Edit(part.span, "")


def _monitor_in_succeed(base: Base) -> Iterator[Edit]:
    """The monitor is written where `succeed` belongs."""
    for rap in base.raps:
        if rap.monitor_state is not None and rap.succeed is not None:
            yield Edit(rap.succeed.span, base.text(rap.monitor_state.span))


# --- planning -------------------------------------------------------------------------


def _things(base: Base) -> Iterator[nodes.Thing]:
    for rap in base.raps:
        for method in rap.methods:
            yield from method.claims


def _claim_of_another(base: Base) -> Iterator[Edit]:
    """A method claims another thing than its steps use."""
    used = {t.node.name: t.node for t in base.index.of(nodes.Thing)}
    for thing in _things(base):
        for term in thing.args:
            if isinstance(term, nodes.Const):
                for kind in base.library.kinds.values():
                    values = kind.values or ()
                    if term.value in values:
                        others = [v for v in values if v != term.value]
                        yield from (Edit(term.span, str(v)) for v in others[:1])
        for name, other in used.items():
            if name != thing.name and not other.args and not thing.args:
                yield Edit(thing.span, name)


def _claim_dropped(base: Base) -> Iterator[Edit]:
    for thing in _things(base):
        yield Edit(thing.span, "", thing.name)


def _use_dropped(base: Base) -> Iterator[Edit]:
    for form in base.library.primitives.values():
        for thing in form.uses:
            yield Edit(thing.span, "", thing.name)


def _promise_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for effect in rap.effects:
            yield Edit(effect.span, "", rap.name)


def _promise_of_another(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for effect in rap.effects:
            for term in effect.pattern.args:
                for other in rap.inputs:
                    if isinstance(term, nodes.Var) and other != term:
                        yield Edit(term.span, base.text(other.span))


def _protections(base: Base) -> Iterator[tuple[nodes.For, nodes.Formula]]:
    for _, step in base.steps():
        for note in step.annotations:
            if isinstance(note, nodes.For) and note.formula is not None:
                yield note, note.formula


def _protection_dropped(base: Base) -> Iterator[Edit]:
    for note, _ in _protections(base):
        yield Edit(note.span, f"(for {note.tag})")


def _protection_of_another(base: Base) -> Iterator[Edit]:
    """`for` protects the fact with another input."""
    for _, step in base.steps():
        for note in step.annotations:
            fact = note.formula if isinstance(note, nodes.For) else None
            if isinstance(fact, nodes.Proposition):
                names = [a for a in step.goal.args if isinstance(a, nodes.Var)]
                for term in fact.args:
                    for other in names:
                        if isinstance(term, nodes.Var) and term != other:
                            yield Edit(term.span, base.text(other.span))


def _constrained(base: Base) -> Iterator[nodes.Formula]:
    for rap in base.raps:
        for part in (rap.constraints, *(m.constraints for m in rap.methods)):
            if part is not None:
                yield part


def _constraint_dropped(base: Base) -> Iterator[Edit]:
    for formula in _constrained(base):
        yield Edit(base.around(formula.span), "")


def _deadline_shortened(base: Base) -> Iterator[Edit]:
    for agenda in base.library.agendas.values():
        for task in agenda.tasks:
            text = base.text(task.span)
            found = re.search(r":deadline (\d+)", text)
            if found is not None:
                at = task.span.start + found.start(1)
                digits = found.group(1)
                span = Span(task.span.file, at, at + len(digits))
                yield Edit(span, str(int(digits) / 100))


def _second_user(base: Base) -> Iterator[Edit]:
    """A primitive enables two skills that use one thing."""
    for one in base.index.of(nodes.Skills):
        for skill in one.node.enable:
            mine = base.library.skills.get(skill.name)
            for other in base.library.skills.values() if mine is not None else ():
                shared = set(other.uses) & set(mine.uses if mine is not None else ())
                enabled = any(s.name == other.name for s in one.node.enable)
                if shared and not enabled and len(other.args) == len(skill.args):
                    text = base.text(skill.span).replace(skill.name, other.name, 1)
                    yield Edit(_behind(skill.span), f" {text}")


# --- structure ------------------------------------------------------------------------


def _net_emptied(base: Base) -> Iterator[Edit]:
    for _, _, net in base.nets():
        if net.steps:
            yield Edit(net.span, "(task-net)")


def _method_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for method in rap.methods if len(rap.methods) > 1 else ():
            yield Edit(method.span, "", str(method.name or rap.name))


def _step_removed(base: Base) -> Iterator[Edit]:
    """A step is dropped with all that names it."""
    for _, _, net in base.nets():
        for step in net.steps if len(net.steps) > 1 else ():
            yield _without(base, net, step)


def _goals_exchanged(base: Base) -> Iterator[Edit]:
    """Two steps in order are written the other way round."""
    for _, _, net in base.nets():
        for one, other in pairwise(net.steps):
            named = [n.tag for n in one.annotations if isinstance(n, nodes.For)]
            if other.tag in named and one.goal != other.goal:
                yield swap(base, one.goal.span, other.goal.span)


def _all_unordered(base: Base) -> Iterator[Edit]:
    """All `for` of a net are forgotten."""
    for _, _, net in base.nets():
        text, at = base.text(net.span), net.span.start
        notes = [n for s in net.steps for n in s.annotations]
        spans = [n.span for n in notes if isinstance(n, nodes.For)]
        for span in reversed(spans):
            text = text[: span.start - at] + text[span.end - at :]
        if len(spans) > 1:
            yield Edit(net.span, text)


# --- conditions -----------------------------------------------------------------------


def _negated(base: Base, asked: Iterable[nodes.Formula | None]) -> Iterator[Edit]:
    for formula in asked:
        if formula is not None and not isinstance(formula, nodes.Truth):
            yield negated(base, formula)


def _precondition_negated(base: Base) -> Iterator[Edit]:
    return _negated(base, (rap.preconditions for rap in base.raps))


def _constraint_negated(base: Base) -> Iterator[Edit]:
    return _negated(base, _constrained(base))


def _protection_negated(base: Base) -> Iterator[Edit]:
    return _negated(base, (formula for _, formula in _protections(base)))


def _context_negated(base: Base) -> Iterator[Edit]:
    facts = (
        method.context
        for rap in base.raps
        for method in rap.methods
        if isinstance(method.context, nodes.Proposition | nodes.Not | nodes.HistoryTest)
    )
    return _negated(base, facts)


def _precondition_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        if rap.preconditions is not None:
            yield Edit(base.around(rap.preconditions.span), "")


def _goal_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        goal = rap.succeed
        if goal is None or rap.repeat_while is not None or rap.outputs:
            continue
        if not isinstance(goal, nodes.Truth):
            yield Edit(base.around(goal.span), "")


def _other_result(base: Base) -> Iterator[Edit]:
    """A result is asked for that belongs to another primitive."""
    every = {
        result: None
        for form in base.library.primitives.values()
        for result in form.results
        if result != "okay"
    }
    for asked in base.index.of(nodes.HistoryTest):
        for term in asked.node.args[-1:]:
            if isinstance(term, nodes.Const) and asked.node.query != "method-tried":
                for other in every:
                    if term.value not in (other, "okay"):
                        yield Edit(term.span, other)


# --- loops ----------------------------------------------------------------------------


def _amount_zero(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.ResourceChange):
        if one.node.op.startswith("counter"):
            yield Edit(one.node.amount.span, "0")


def _limit_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        if isinstance(rap.repeat_while, nodes.And):
            for part in rap.repeat_while.parts:
                if isinstance(part, nodes.Compare):
                    yield Edit(part.span, "")


def _loop_negated(base: Base) -> Iterator[Edit]:
    return _negated(base, (rap.repeat_while for rap in base.raps))


def _limit_of_any_counter(base: Base) -> Iterator[Edit]:
    """The change is written to another resource of the RAP."""
    for rap in base.raps:
        names = [one.variable.name for one in rap.resources]
        for method in rap.methods:
            for step in steps(method):
                for note in step.annotations:
                    if isinstance(note, nodes.ResourceChange):
                        for name in names:
                            if base.text(note.resource.span) != name:
                                yield Edit(note.resource.span, name)


def _loop_is_goal(base: Base) -> Iterator[Edit]:
    """`repeat-while` asks for what `succeed` asks."""
    for rap in base.raps:
        loop, goal = rap.repeat_while, rap.succeed
        if loop is not None and goal is not None and not isinstance(goal, nodes.Truth):
            yield Edit(loop.span, base.text(goal.span))


def _loop_as_context(base: Base) -> Iterator[Edit]:
    """`repeat-while` is written as a precondition."""
    for rap in base.raps:
        if rap.repeat_while is not None and rap.preconditions is None:
            whole = base.around(rap.repeat_while.span)
            word = word_span(base.files, whole, 0)
            yield Edit(word, "preconditions")


KINDS: Mapping[str, tuple[str, Kind]] = {
    "step given twice": ("copies", _step_twice),
    "step with the goal of the one before": ("copies", _goal_of_the_step_before),
    "step copied with an argument left": ("copies", _step_argument_left),
    "method copied with its context": ("copies", _context_of_another),
    "method copied with its body": ("copies", _body_of_another),
    "last method copied without its context": ("copies", _copied_otherwise),
    "constant of a copied method changed once": ("copies", _constant_left),
    "variable of a copied conjunct left": ("copies", _variable_left),
    "RAP copied with its `succeed`": ("copies", _clause_of_the_rap_before),
    "belief of any value": ("sensing", _belief_of_any_value),
    "unknown value allowed": ("sensing", _unknown_allowed),
    "fact for a belief": ("sensing", _belief_is_a_fact),
    "belief a hundred times as old": ("sensing", _older),
    "sensing step dropped": ("sensing", _sensing_dropped),
    "sensing step unordered": ("sensing", _sensing_unordered),
    "monitored step as low as the others": ("monitors", _monitored_step_lowered),
    "`until` of a monitored step dropped": ("monitors", _monitored_step_unordered),
    "step ended by what it waits for": ("monitors", _ended_at_once),
    "conjunct of a monitor dropped": ("monitors", _conjunct_of_monitor_dropped),
    "monitor copied to `succeed`": ("monitors", _monitor_in_succeed),
    "claim of another thing": ("planning", _claim_of_another),
    "claim dropped": ("planning", _claim_dropped),
    "use of a primitive dropped": ("planning", _use_dropped),
    "promise dropped": ("planning", _promise_dropped),
    "promise of another variable": ("planning", _promise_of_another),
    "protection dropped": ("planning", _protection_dropped),
    "protection of another variable": ("planning", _protection_of_another),
    "constraint dropped": ("planning", _constraint_dropped),
    "deadline a hundredth as far": ("planning", _deadline_shortened),
    "two users of one thing enabled": ("planning", _second_user),
    "net emptied": ("structure", _net_emptied),
    "method dropped": ("structure", _method_dropped),
    "step dropped with its annotations": ("structure", _step_removed),
    "goals of two steps exchanged": ("structure", _goals_exchanged),
    "order of a net dropped": ("structure", _all_unordered),
    "precondition negated": ("conditions", _precondition_negated),
    "constraint negated": ("conditions", _constraint_negated),
    "protection negated": ("conditions", _protection_negated),
    "context negated": ("conditions", _context_negated),
    "precondition dropped": ("conditions", _precondition_dropped),
    "`succeed` dropped": ("conditions", _goal_dropped),
    "result of another primitive": ("conditions", _other_result),
    "amount 0": ("loops", _amount_zero),
    "limit of a loop dropped": ("loops", _limit_dropped),
    "`repeat-while` negated": ("loops", _loop_negated),
    "change of another resource": ("loops", _limit_of_any_counter),
    "`repeat-while` is the goal": ("loops", _loop_is_goal),
    "`repeat-while` as a precondition": ("loops", _loop_as_context),
}
"""Every kind of slip here, with the group that it is of."""
