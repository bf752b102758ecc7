"""Slips in queries, rules of memory, standing tasks, claims and skills.

As in `bench.mutation_words`, a kind yields every place where the slip can be made.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations, pairwise

from bench.mutation_base import Base, Edit, Kind, swap
from rapc.analysis.facts.logic import is_never
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import subformulas
from rapc.library.library import word_span

# --- queries and rules ----------------------------------------------------------------


def _query_of_itself(base: Base) -> Iterator[Edit]:
    """A query asks for itself, where it asked for a similar query or fact."""
    for query in base.library.queries.values():
        for part in subformulas(query.formula):
            if not isinstance(part, nodes.Proposition) or part.name == query.name:
                continue
            if len(part.args) == len(query.args):
                yield Edit(base.head(part), query.name)


def _compared_with_itself(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Compare):
        if isinstance(one.node.left, nodes.Var) and one.node.left != one.node.right:
            yield Edit(one.node.right.span, base.text(one.node.left.span))


def _case_twice(base: Base) -> Iterator[Edit]:
    """A case of a memory rule is copied and keeps its result."""
    for rule in base.library.memory_rules:
        for case in rule.cases:
            end = case.span.end
            text = base.text(case.span)
            yield Edit(Span(case.span.file, end, end), f"\n    {text}")


def _general_case_first(base: Base) -> Iterator[Edit]:
    for rule in base.library.memory_rules:
        for one, other in pairwise(rule.cases):
            if isinstance(other.result, nodes.Var):
                yield swap(base, one.span, other.span)


# --- steps ----------------------------------------------------------------------------


def _ended_by_another(base: Base) -> Iterator[Edit]:
    """`until` names another step of the net."""
    for net, step in base.steps():
        for note in step.annotations:
            if isinstance(note, nodes.UntilEnd | nodes.UntilStart):
                for other in net.steps:
                    if other.tag not in (note.tag, step.tag):
                        yield Edit(word_span(base.files, note.span, 1), other.tag)


def _end_each_other_by_start(base: Base) -> Iterator[Edit]:
    """Two steps that end each other do so by their starts."""
    for _, _, net in base.nets():
        for one, other in combinations(net.steps, 2):
            notes = [_until(one, other.tag), _until(other, one.tag)]
            first, second = notes
            if first is not None and second is not None:
                whole = Span(first.span.file, first.span.start, second.span.end)
                text = base.text(whole)
                yield Edit(whole, text.replace("(until-end", "(until-start"))


def _until(step: nodes.Step, tag: str) -> nodes.UntilEnd | None:
    for note in step.annotations:
        if isinstance(note, nodes.UntilEnd) and note.tag == tag:
            return note
    return None


# --- standing tasks -------------------------------------------------------------------


def _one_priority(base: Base) -> Iterator[Edit]:
    """A standing task gets the priority of another standing task."""
    for agenda in base.library.agendas.values():
        standing = [task for task in agenda.tasks if task.background]
        for one, other in combinations(standing, 2):
            text = base.text(one.span)
            old = f":priority {one.priority}"
            if one.priority != other.priority and old in text:
                yield Edit(one.span, text.replace(old, f":priority {other.priority}"))


def _fact_of_monitor_in_context(base: Base) -> Iterator[Edit]:
    """A fact of the monitor of a standing task is made a context."""
    for rap in base.raps:
        monitor = rap.monitor_state
        if not isinstance(monitor, nodes.And) or not is_never(rap.succeed):
            continue
        for method in rap.methods if len(rap.methods) == 1 else ():
            for part in monitor.parts if method.context is None else ():
                if isinstance(part, nodes.Proposition):
                    fact = base.text(part.span)
                    whole = Span(rap.span.file, monitor.span.start, method.span.end)
                    text = base.text(whole).replace(fact, "", 1)
                    head = f"(method (context {fact})"
                    yield Edit(whole, text.replace("(method", head, 1))


def _belief_of_a_moment(base: Base) -> Iterator[Edit]:
    """A belief has to be a hundred times younger."""
    for one in base.index.of(nodes.Believe):
        text = base.text(one.node.age.span)
        if text.isdigit() and int(text) > 0:
            yield Edit(one.node.age.span, str(int(text) / 100))


# --- claims and skills ----------------------------------------------------------------


def _claims_turned_round(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for method in rap.methods:
            for one, other in pairwise(method.claims):
                yield swap(base, one.span, other.span)


def _another_skill(base: Base) -> Iterator[Edit]:
    """A primitive enables another skill with as many arguments."""
    for one in base.index.of(nodes.Skills):
        for skill in one.node.enable:
            for name, form in base.library.skills.items():
                if name != skill.name and len(form.args) == len(skill.args):
                    at = skill.span.start + base.text(skill.span).index(skill.name)
                    yield Edit(Span(skill.span.file, at, at + len(skill.name)), name)


def _disables_another(base: Base) -> Iterator[Edit]:
    """A primitive disables another skill than the skills that it enables."""
    for one in base.index.of(nodes.Skills):
        enabled = {skill.name for skill in one.node.enable}
        for name, form in base.library.skills.items():
            if name not in enabled and not form.args:
                end = one.node.span.end - 1
                span = Span(one.node.span.file, end, end)
                yield Edit(span, f" (disable ({name}))")


KINDS: Mapping[str, tuple[str, Kind]] = {
    "query asks for itself": ("methods", _query_of_itself),
    "compared with itself": ("binding", _compared_with_itself),
    "case of a memory rule given twice": ("copies", _case_twice),
    "general case of a memory rule first": ("methods", _general_case_first),
    "`until` another step": ("order", _ended_by_another),
    "`until-start` for both ends": ("order", _end_each_other_by_start),
    "standing tasks of one priority": ("priorities", _one_priority),
    "fact of a monitor made a context": ("monitors", _fact_of_monitor_in_context),
    "belief a hundredth as old": ("sensing", _belief_of_a_moment),
    "claims the other way round": ("planning", _claims_turned_round),
    "another skill enabled": ("skills", _another_skill),
    "another skill disabled": ("skills", _disables_another),
}
"""Every kind of slip here, with the group that it is of."""
