"""Slips in which one thing is taken for another that looks like it, or is near.

As in `bench.mutation_words`, a kind yields every place where the slip can be made.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import pairwise

from bench.mutation_base import Base, Edit, Kind, misspell, swap
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import formulas, subformulas
from rapc.library.library import word_span

# --- marks and parentheses ------------------------------------------------------------


def _mark_forgotten(base: Base) -> Iterator[Edit]:
    """`room` where `?room` was meant, in a fact, a goal or a request."""
    for used in base.index.of(nodes.Var):
        inside = isinstance(used.parent, nodes.Pattern | nodes.Goal)
        own = isinstance(used.parent, nodes.DefineRap)
        in_rap = type(used.owner) is nodes.DefineRap
        if inside and in_rap and not own and not used.node.anonymous:
            yield Edit(used.node.span, used.node.name.lstrip("?"))


def _mark_added(base: Base) -> Iterator[Edit]:
    """`?open` where `open` was meant."""
    for fact in base.facts():
        for term in fact.node.args:
            if isinstance(term, nodes.Const) and isinstance(term.value, str):
                yield Edit(term.span, f"?{base.text(term.span)}")


def _text_for_word(base: Base) -> Iterator[Edit]:
    for fact in base.facts():
        for term in fact.node.args:
            if isinstance(term, nodes.Const) and isinstance(term.value, str):
                yield Edit(term.span, f'"{base.text(term.span)}"')


def _word_quoted(base: Base) -> Iterator[Edit]:
    for fact in base.facts():
        for term in fact.node.args:
            if isinstance(term, nodes.Const) and isinstance(term.value, str):
                yield Edit(term.span, f"'{base.text(term.span)}")


def _conjuncts(base: Base) -> Iterator[tuple[nodes.And, nodes.Formula]]:
    for rap in base.raps:
        for one in formulas(rap):
            for part in subformulas(one.formula):
                if isinstance(part, nodes.And):
                    for inner in part.parts:
                        yield part, inner


def _formula_doubled(base: Base) -> Iterator[Edit]:
    for _, part in _conjuncts(base):
        yield Edit(part.span, f"({base.text(part.span)})")


def _closes_too_late(base: Base) -> Iterator[Edit]:
    """A `not` takes in the conjunct behind it."""
    for whole, _ in _conjuncts(base):
        for one, other in pairwise(whole.parts):
            if isinstance(one, nodes.Not) and base.text(one.span).startswith("(not"):
                span = Span(one.span.file, one.span.end - 1, other.span.end)
                between = base.files[one.span.file].text[one.span.end : other.span.end]
                yield Edit(span, f"{between})")


def _step_closes_too_late(base: Base) -> Iterator[Edit]:
    """The parenthesis of a step closes behind the next step."""
    for _, _, net in base.nets():
        for one, other in pairwise(net.steps):
            text = base.files[one.span.file].text
            span = Span(one.span.file, one.span.end - 1, other.span.end)
            yield Edit(span, f"{text[one.span.end : other.span.end]})")


# --- formulas -------------------------------------------------------------------------


def _or_for_and(base: Base) -> Iterator[Edit]:
    for whole in dict.fromkeys(whole for whole, _ in _conjuncts(base)):
        if base.text(whole.span).startswith("(and"):
            yield Edit(word_span(base.files, whole.span, 0), "or")


def _not_forgotten(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for one in formulas(rap):
            for part in subformulas(one.formula):
                if isinstance(part, nodes.Not):
                    yield Edit(part.span, base.text(part.part.span))


def _conjunct_twice(base: Base) -> Iterator[Edit]:
    for _, part in _conjuncts(base):
        if isinstance(part, nodes.Proposition):
            end = part.span.end
            yield Edit(Span(part.span.file, end, end), f" {base.text(part.span)}")


def _fact_compared(base: Base) -> Iterator[Edit]:
    """`(< (battery ?level) 20)` for a fact and a test of its value."""
    for whole, _ in _conjuncts(base):
        for one, other in pairwise(whole.parts):
            if isinstance(one, nodes.Proposition) and isinstance(other, nodes.Compare):
                last = one.args[-1] if one.args else None
                if isinstance(last, nodes.Var) and last == other.left:
                    span = Span(one.span.file, one.span.start, other.span.end)
                    right = base.text(other.right.span)
                    yield Edit(span, f"({other.op} {base.text(one.span)} {right})")


def _value_forgotten(base: Base) -> Iterator[Edit]:
    for call in base.index.of(nodes.Call):
        if call.node.function == "value":
            yield Edit(call.node.span, base.text(call.node.args[0].span))


def _other_name_for_an_input(base: Base) -> Iterator[Edit]:
    """A formula asks for `?it`, which nothing else speaks of, instead of an input."""
    for rap in base.raps:
        names = {v.name for v in rap.inputs}
        for one in formulas(rap):
            for part in subformulas(one.formula):
                for term in part.args if isinstance(part, nodes.Proposition) else ():
                    if isinstance(term, nodes.Var) and term.name in names:
                        yield Edit(term.span, "?it")


# --- steps ----------------------------------------------------------------------------


def _arrow_forgotten(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        if step.goal.outputs:
            text = base.files[step.span.file].text
            start = text.rindex("=>", 0, step.goal.outputs[0].span.start)
            yield Edit(Span(step.span.file, start, start + 2), "")


def _output_is_an_input(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        for arg in step.goal.args:
            for out in step.goal.outputs:
                if isinstance(arg, nodes.Var):
                    yield Edit(out.span, arg.name)


def _for_another_step(base: Base) -> Iterator[Edit]:
    for net, step in base.steps():
        for note in step.annotations:
            others = [s.tag for s in net.steps if s.tag != step.tag]
            if isinstance(note, nodes.For):
                for tag in others:
                    if tag != note.tag:
                        whole = base.text(note.span)
                        at = note.span.start + whole.rindex(note.tag)
                        span = Span(note.span.file, at, at + len(note.tag))
                        yield Edit(span, tag)


def _start_for_end(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        for note in step.annotations:
            if isinstance(note, nodes.UntilEnd):
                yield Edit(word_span(base.files, note.span, 0), "until-start")


def _step_dropped(base: Base) -> Iterator[Edit]:
    for _, _, net in base.nets():
        if len(net.steps) > 1:
            for step in net.steps:
                yield Edit(step.span, "", step.tag)


def _other_rap(base: Base) -> Iterator[Edit]:
    """A step asks for another RAP that takes as many inputs."""
    for _, step in base.steps():
        for rap in base.raps:
            same = len(rap.inputs) == len(step.goal.args)
            plain = not rap.outputs and not step.goal.outputs
            if same and plain and rap.name != step.goal.name:
                yield Edit(base.head(step.goal), rap.name)


def _other_primitive(base: Base) -> Iterator[Edit]:
    for request in base.requests():
        for name, form in base.library.primitives.items():
            if name != request.name and len(form.args) == len(request.args):
                yield Edit(base.head(request), name)


# --- clauses --------------------------------------------------------------------------


def _last_method_first(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        if len(rap.methods) > 1:
            yield swap(base, rap.methods[0].span, rap.methods[-1].span)


def _context_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for method in rap.methods:
            if method.context is not None:
                yield Edit(base.around(method.context.span), "")


def _context_outside(base: Base) -> Iterator[Edit]:
    """A method is closed before its context."""
    for rap in base.raps:
        for method in rap.methods:
            if method.context is not None:
                text = base.text(method.span)
                found = re.match(r"\(method(\s+[^\s()]+)?", text)
                assert found is not None
                at = method.span.start + found.end()
                yield Edit(Span(method.span.file, at, at), ")")


def _precondition_is_goal(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        goal = rap.succeed
        if goal is not None and rap.preconditions is not None:
            yield Edit(rap.preconditions.span, base.text(goal.span))


def _other_goal(base: Base) -> Iterator[Edit]:
    """`succeed` asks for another fact with as many arguments."""
    for rap in base.raps:
        goal = rap.succeed
        if isinstance(goal, nodes.Proposition):
            for form in base.relations():
                same = form.args is not None and len(form.args) == len(goal.args)
                if same and form.name != goal.name:
                    yield Edit(base.head(goal), form.name)


def _other_fact_awaited(base: Base) -> Iterator[Edit]:
    """A monitor asks for another fact with as many arguments."""
    for rap in base.raps:
        for part in subformulas(rap.monitor_state) if rap.monitor_state else ():
            if not isinstance(part, nodes.Proposition):
                continue
            for form in base.relations():
                same = form.args is not None and len(form.args) == len(part.args)
                if same and form.name != part.name:
                    yield Edit(base.head(part), form.name)


def _set_change_turned_round(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.ResourceChange):
        change = one.node
        if change.op.startswith("set"):
            yield swap(base, change.resource.span, change.amount.span)


def _thing_misspelt(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Thing):
        if one.node.args:
            yield misspell(base, word_span(base.files, one.node.span, 0))
        else:
            yield misspell(base, one.node.span)


def _background_forgotten(base: Base) -> Iterator[Edit]:
    for agenda in base.library.agendas.values():
        for task in agenda.tasks:
            text = base.text(task.span)
            if task.background:
                yield Edit(task.span, text.replace(" :background true", ""))


def _other_event(base: Base) -> Iterator[Edit]:
    """A primitive or a step waits for another event with as many arguments."""
    for one in base.index.of(nodes.WaitFor):
        for name, form in base.library.events.items():
            if name != one.node.signal and len(form.args) == len(one.node.args):
                text = base.text(one.node.span)
                at = one.node.span.start + text.index(one.node.signal)
                yield Edit(
                    Span(one.node.span.file, at, at + len(one.node.signal)), name
                )


def _skill_forgotten(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Skills):
        for skill in one.node.enable:
            if len(one.node.enable) > 1:
                yield Edit(skill.span, "", skill.name)


def _wait_forgotten(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Skills):
        for wait in one.node.waits:
            yield Edit(wait.span, "")


KINDS: Mapping[str, tuple[str, Kind]] = {
    "`?` forgotten": ("names", _mark_forgotten),
    "`?` before a word": ("names", _mark_added),
    "text for a word": ("names", _text_for_word),
    "quote before a word": ("names", _word_quoted),
    "thing misspelt": ("names", _thing_misspelt),
    "conjunct in two parentheses": ("parentheses", _formula_doubled),
    "`not` closed too late": ("parentheses", _closes_too_late),
    "step closed too late": ("parentheses", _step_closes_too_late),
    "method closed before its context": ("parentheses", _context_outside),
    "`or` for `and`": ("binding", _or_for_and),
    "`not` forgotten": ("binding", _not_forgotten),
    "fact inside a comparison": ("binding", _fact_compared),
    "`value` of a counter forgotten": ("binding", _value_forgotten),
    "fresh variable for an input": ("binding", _other_name_for_an_input),
    "conjunct given twice": ("binding", _conjunct_twice),
    "`=>` forgotten": ("arguments", _arrow_forgotten),
    "output is an input": ("arguments", _output_is_an_input),
    "arguments of `set-add` swapped": ("arguments", _set_change_turned_round),
    "`for` another step": ("order", _for_another_step),
    "`until-start` for `until-end`": ("order", _start_for_end),
    "step dropped": ("order", _step_dropped),
    "another RAP as a step": ("names", _other_rap),
    "another primitive": ("names", _other_primitive),
    "last method first": ("methods", _last_method_first),
    "context dropped": ("methods", _context_dropped),
    "precondition is the goal": ("methods", _precondition_is_goal),
    "`succeed` asks for another fact": ("methods", _other_goal),
    "monitor asks for another fact": ("monitors", _other_fact_awaited),
    "`:background true` forgotten": ("priorities", _background_forgotten),
    "another event awaited": ("skills", _other_event),
    "skill forgotten": ("skills", _skill_forgotten),
    "wait of skills forgotten": ("skills", _wait_forgotten),
}
"""The kinds of slips, each with the group that it is of."""
