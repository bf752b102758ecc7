"""Slips in single words: names, arguments, declarations, parentheses.

A kind yields every place of a library where the slip can be made; the bench draws some
of them. What is yielded changes one thing and no more.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from bench.mutation_base import Base, Edit, Kind, misspell, swap
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import name_span, word_span

# --- names ----------------------------------------------------------------------------


def _goal_name(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        yield misspell(base, base.head(step.goal))


def _predicate_name(base: Base) -> Iterator[Edit]:
    for fact in base.facts():
        yield misspell(base, base.head(fact.node))


def _primitive_name(base: Base) -> Iterator[Edit]:
    for request in base.requests():
        yield misspell(base, base.head(request))


def _variable_name(base: Base) -> Iterator[Edit]:
    for used in base.index.of(nodes.Var):
        word = base.text(used.node.span)
        if type(used.owner) is nodes.DefineRap and len(word) > len("?five"):
            yield misspell(base, used.node.span)


def _constants(base: Base) -> Iterator[nodes.Const]:
    for fact in base.facts():
        for term in fact.node.args:
            if isinstance(term, nodes.Const) and isinstance(term.value, str):
                yield term


def _constant(base: Base) -> Iterator[Edit]:
    for term in _constants(base):
        if len(base.text(term.span)) > len("four"):
            yield misspell(base, term.span)


def _result(base: Base) -> Iterator[Edit]:
    for asked in base.index.of(nodes.HistoryTest):
        for term in asked.node.args[-1:]:
            if isinstance(term, nodes.Const) and asked.node.query != "method-tried":
                yield misspell(base, term.span)


def _method_name(base: Base) -> Iterator[Edit]:
    for asked in base.index.of(nodes.HistoryTest):
        for term in asked.node.args[:1]:
            if isinstance(term, nodes.Const) and asked.node.query != "last-result":
                yield misspell(base, term.span)


def _tag(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        for note in step.annotations:
            if isinstance(note, nodes.UntilEnd | nodes.UntilStart):
                yield Edit(word_span(base.files, note.span, 1), f"{note.tag}9")
            if isinstance(note, nodes.For) and note.formula is None:
                yield Edit(word_span(base.files, note.span, 1), f"{note.tag}9")


_CLAUSES = re.compile(
    r"\((succeed|monitor-state|repeat-while|preconditions|constraints|resources)\b"
)


def _clause_word(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for found in _CLAUSES.finditer(base.text(rap.span)):
            at = rap.span.start
            span = Span(rap.span.file, at + found.start(1), at + found.end(1))
            yield misspell(base, span)


def _annotation_word(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        for note in step.annotations:
            if not isinstance(note, nodes.For) or note.formula is None:
                yield misspell(base, word_span(base.files, note.span, 0))


def _definition_name(base: Base) -> Iterator[Edit]:
    called = {used.name for used in base.uses("goal")}
    for rap in base.raps:
        if rap.name in called:
            yield misspell(base, rap.name_span)


def _declaration_name(base: Base) -> Iterator[Edit]:
    used = {fact.node.name for fact in base.facts()}
    for form in base.relations():
        if form.name in used:
            yield misspell(base, name_span(base.files, form))


def _agenda_task(base: Base) -> Iterator[Edit]:
    for agenda in base.library.agendas.values():
        for task in agenda.tasks:
            yield misspell(base, base.head(task.goal))


def _primitive_as_step(base: Base) -> Iterator[Edit]:
    counts = {len(form.args): name for name, form in base.library.primitives.items()}
    for _, step in base.steps():
        name = counts.get(len(step.goal.args))
        if name and not step.goal.outputs and name not in base.library.raps:
            yield Edit(base.head(step.goal), name)


def _predicate_as_step(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        for name, form in base.library.propositions.items():
            if form.args is not None and len(form.args) == len(step.goal.args):
                yield Edit(base.head(step.goal), name)
                break


# --- arguments ------------------------------------------------------------------------


def _goal_argument_dropped(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        for arg in step.goal.args[:1]:
            yield Edit(arg.span, "")


def _goal_argument_added(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        for arg in step.goal.args[:1]:
            yield Edit(arg.span, f"{base.text(arg.span)} {base.text(arg.span)}")


def _output_dropped(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        if step.goal.outputs:
            text = base.files[step.span.file].text
            start = text.rindex("=>", 0, step.goal.outputs[0].span.start)
            end = step.goal.outputs[-1].span.end
            yield Edit(Span(step.span.file, start, end), "")


def _constant_for_output(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        for term in step.goal.outputs:
            yield Edit(term.span, base.text(term.span).lstrip("?"))


def _swapped(base: Base, lists: Iterator[Sequence[nodes.Term]]) -> Iterator[Edit]:
    for args in lists:
        for one, other in pairwise(args):
            if base.text(one.span) != base.text(other.span):
                yield swap(base, one.span, other.span)


def _goal_arguments_swapped(base: Base) -> Iterator[Edit]:
    return _swapped(base, (step.goal.args for _, step in base.steps()))


def _fact_arguments_swapped(base: Base) -> Iterator[Edit]:
    return _swapped(base, (fact.node.args for fact in base.facts()))


def _request_arguments_swapped(base: Base) -> Iterator[Edit]:
    return _swapped(base, (request.args for request in base.requests()))


def _member_swapped(base: Base) -> Iterator[Edit]:
    tests = (t.node.args for t in base.index.of(nodes.SetTest) if len(t.node.args) > 1)
    return _swapped(base, tests)


def _fact_argument_dropped(base: Base) -> Iterator[Edit]:
    for fact in base.facts():
        if len(fact.node.args) > 1:
            yield Edit(fact.node.args[0].span, "")


def _fact_argument_added(base: Base) -> Iterator[Edit]:
    for fact in base.facts():
        for arg in fact.node.args[:1]:
            yield Edit(arg.span, f"{base.text(arg.span)} {base.text(arg.span)}")


def _value_dropped(base: Base) -> Iterator[Edit]:
    for fact in base.facts():
        declared = base.signatures.relations.get(fact.node.name)
        if declared is not None and declared.is_property and len(fact.node.args) > 1:
            yield Edit(fact.node.args[-1].span, "")


def _number_for_symbol(base: Base) -> Iterator[Edit]:
    for term in _constants(base):
        yield Edit(term.span, "3")


def _foreign_constant(base: Base) -> Iterator[Edit]:
    names = sorted({base.text(term.span) for term in _constants(base)})
    for at, term in enumerate(_constants(base)):
        yield Edit(term.span, names[at % len(names)])


def _other_variable(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        names = [v.name for v in rap.inputs]
        for method in rap.methods:
            for step in steps(method):
                for arg in step.goal.args:
                    others = [n for n in names if n != base.text(arg.span)]
                    if isinstance(arg, nodes.Var) and others:
                        yield Edit(arg.span, others[0])


# --- declarations and parentheses -----------------------------------------------------


def _declarations(base: Base) -> Iterator[tuple[str, nodes.TopForm]]:
    asked = {one.name for one in base.index.uses()}
    for table in (
        base.library.properties,
        base.library.propositions,
        base.library.primitives,
        base.library.queries,
        base.library.kinds,
    ):
        for name, form in table.items():
            if name in asked:
                yield name, form


def _declaration_dropped(base: Base) -> Iterator[Edit]:
    for name, form in _declarations(base):
        yield Edit(form.span, "", name)


def _definition_dropped(base: Base) -> Iterator[Edit]:
    called = {used.name for used in base.uses("goal")}
    for rap in base.raps:
        if rap.name in called:
            yield Edit(rap.span, "", rap.name)


def _definition_twice(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        end = rap.span.end
        yield Edit(Span(rap.span.file, end, end), f"\n\n{base.text(rap.span)}")


def _declared_argument_dropped(base: Base) -> Iterator[Edit]:
    used = {one.name for one in base.index.uses()}
    for form in base.relations():
        for arg in (form.args or ())[:1]:
            if form.name in used:
                yield Edit(arg.span, "")


def _declared_result_dropped(base: Base) -> Iterator[Edit]:
    """A result that a RAP asks for is declared no more."""
    asked = {
        term.value
        for one in base.index.of(nodes.HistoryTest)
        for term in one.node.args[-1:]
        if isinstance(term, nodes.Const)
    }
    for form in base.library.primitives.values():
        for result in form.results:
            if result in asked and result != "okay":
                text = base.text(form.span)
                for found in re.finditer(
                    rf"(?<=[( ]){re.escape(result)}(?=[ )])", text
                ):
                    at = form.span.start
                    span = Span(form.span.file, at + found.start(), at + found.end())
                    yield Edit(span, "", result)
                    break


def _resource_dropped(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Resource):
        yield Edit(one.node.span, "", one.node.variable.name)


def _kind_misspelt(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Argument):
        if one.node.kind is not None:
            yield misspell(base, word_span(base.files, one.node.span, 1))


def _brackets(base: Base, bracket: str) -> Iterator[Span]:
    for rap in base.raps:
        for at, letter in enumerate(base.text(rap.span), start=rap.span.start):
            if letter == bracket:
                yield Span(rap.span.file, at, at + 1)


def _closing_dropped(base: Base) -> Iterator[Edit]:
    for span in _brackets(base, ")"):
        yield Edit(span, "")


def _closing_added(base: Base) -> Iterator[Edit]:
    for span in _brackets(base, ")"):
        yield Edit(span, "))")


def _opening_dropped(base: Base) -> Iterator[Edit]:
    for span in _brackets(base, "("):
        yield Edit(span, "")


def _opening_added(base: Base) -> Iterator[Edit]:
    for span in _brackets(base, "("):
        yield Edit(span, "((")


KINDS: Mapping[str, tuple[str, Kind]] = {
    "RAP misspelt in a step": ("names", _goal_name),
    "predicate misspelt": ("names", _predicate_name),
    "primitive misspelt": ("names", _primitive_name),
    "variable misspelt once": ("names", _variable_name),
    "constant misspelt": ("names", _constant),
    "result misspelt": ("names", _result),
    "method misspelt in a question": ("names", _method_name),
    "tag misspelt": ("names", _tag),
    "clause misspelt": ("names", _clause_word),
    "annotation misspelt": ("names", _annotation_word),
    "RAP misspelt where it is defined": ("names", _definition_name),
    "predicate misspelt where it is declared": ("names", _declaration_name),
    "RAP misspelt in an agenda": ("names", _agenda_task),
    "primitive as a step": ("names", _primitive_as_step),
    "predicate as a step": ("names", _predicate_as_step),
    "argument of a step dropped": ("arguments", _goal_argument_dropped),
    "argument of a step added": ("arguments", _goal_argument_added),
    "outputs of a step dropped": ("arguments", _output_dropped),
    "word in place of an output": ("arguments", _constant_for_output),
    "arguments of a step swapped": ("arguments", _goal_arguments_swapped),
    "arguments of a fact swapped": ("arguments", _fact_arguments_swapped),
    "arguments of a request swapped": ("arguments", _request_arguments_swapped),
    "arguments of `member` swapped": ("arguments", _member_swapped),
    "argument of a fact dropped": ("arguments", _fact_argument_dropped),
    "argument of a fact added": ("arguments", _fact_argument_added),
    "value of a property dropped": ("arguments", _value_dropped),
    "number in place of a word": ("arguments", _number_for_symbol),
    "another constant of the library": ("arguments", _foreign_constant),
    "another input as argument": ("arguments", _other_variable),
    "declaration dropped": ("declarations", _declaration_dropped),
    "RAP dropped": ("declarations", _definition_dropped),
    "RAP given twice": ("declarations", _definition_twice),
    "argument dropped from a declaration": ("declarations", _declared_argument_dropped),
    "result dropped from a declaration": ("declarations", _declared_result_dropped),
    "resource dropped": ("declarations", _resource_dropped),
    "kind misspelt": ("declarations", _kind_misspelt),
    "closing parenthesis dropped": ("parentheses", _closing_dropped),
    "closing parenthesis added": ("parentheses", _closing_added),
    "opening parenthesis dropped": ("parentheses", _opening_dropped),
    "opening parenthesis added": ("parentheses", _opening_added),
}
"""The kinds of slips, each with the group that it is of."""
