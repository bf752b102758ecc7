"""Slips in what is meant: binding, order, monitors, loops, methods, effects, sensing.

As in `bench.mutation_words`, a kind yields every place where the slip can be made.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from itertools import pairwise

from bench.mutation_base import Base, Edit, Kind, negated, swap
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import formulas
from rapc.library.library import word_span

# --- binding --------------------------------------------------------------------------


def _conjunct_dropped(base: Base) -> Iterator[Edit]:
    for _, formula in base.contexts():
        for part in formula.parts:
            if isinstance(part, nodes.Proposition):
                yield Edit(part.span, "")


def _conjunct_negated(base: Base) -> Iterator[Edit]:
    for _, formula in base.contexts():
        for part in formula.parts:
            if isinstance(part, nodes.Proposition):
                yield Edit(part.span, f"(not {base.text(part.span)})")


def _conjuncts_turned_round(base: Base) -> Iterator[Edit]:
    for _, formula in base.contexts():
        for one, other in pairwise(formula.parts):
            if isinstance(other, nodes.Compare):
                yield swap(base, one.span, other.span)


def _conjunct_made_a_choice(base: Base) -> Iterator[Edit]:
    for _, formula in base.contexts():
        for part in formula.parts:
            if isinstance(part, nodes.Proposition):
                yield Edit(part.span, f"(or {base.text(part.span)} true)")


def _equals_binds(base: Base) -> Iterator[Edit]:
    for _, formula in base.contexts():
        for part in formula.parts:
            if isinstance(part, nodes.Proposition) and part.args:
                last = base.text(part.args[-1].span)
                start = part.args[-2].span.end if len(part.args) > 1 else None
                if last.startswith("?") and start:
                    fact = base.files[part.span.file].text[part.span.start : start]
                    yield Edit(part.span, f"(= {last} {fact}))")


def _input_renamed(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for variable in rap.inputs:
            yield Edit(variable.span, f"{base.text(variable.span)}-given")


def _output_renamed(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for variable in rap.outputs:
            yield Edit(variable.span, f"{base.text(variable.span)}-given")


def _and_dropped(base: Base) -> Iterator[Edit]:
    for _, formula in base.contexts():
        inside = base.text(formula.span)[len("(and") : -1].strip()
        yield Edit(formula.span, inside)


# --- order ----------------------------------------------------------------------------


def _notes(
    base: Base, kind: type
) -> Iterator[tuple[nodes.TaskNet, nodes.Step, nodes.Annotation]]:
    for net, step in base.steps():
        for note in step.annotations:
            if isinstance(note, kind):
                yield net, step, note


def _for_dropped(base: Base) -> Iterator[Edit]:
    for _, _, note in _notes(base, nodes.For):
        yield Edit(note.span, "")


def _for_itself(base: Base) -> Iterator[Edit]:
    for _, step, note in _notes(base, nodes.For):
        if isinstance(note, nodes.For) and note.formula is None:
            yield Edit(word_span(base.files, note.span, 1), step.tag)


def _for_both_ways(base: Base) -> Iterator[Edit]:
    for net, step, note in _notes(base, nodes.For):
        assert isinstance(note, nodes.For)
        for other in net.steps:
            if other.tag == note.tag:
                end = other.span.end - 1
                yield Edit(Span(other.span.file, end, end), f" (for {step.tag})")


def _until_dropped(base: Base) -> Iterator[Edit]:
    for _, _, note in _notes(base, nodes.UntilEnd | nodes.UntilStart):  # type: ignore[arg-type]
        yield Edit(note.span, "")


def _until_itself(base: Base) -> Iterator[Edit]:
    for _, step, note in _notes(base, nodes.UntilEnd | nodes.UntilStart):  # type: ignore[arg-type]
        yield Edit(word_span(base.files, note.span, 1), step.tag)


def _tag_twice(base: Base) -> Iterator[Edit]:
    for _, _, net in base.nets():
        for one, other in pairwise(net.steps):
            yield Edit(base.head(other), one.tag)


def _tag_left_out(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        yield Edit(base.head(step), "")


def _window_turned_round(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Window):
        yield swap(base, one.node.start.span, one.node.stop.span)


def _monitor_time_turned_round(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.MonitorTime):
        yield swap(base, one.node.start.span, one.node.stop.span)


def _monitor_time_now(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.MonitorTime):
        yield Edit(one.node.start.span, "0")


# --- monitors and priorities ----------------------------------------------------------


def _monitors(base: Base) -> Iterator[tuple[nodes.DefineRap, nodes.Formula]]:
    for rap in base.raps:
        if rap.monitor_state is not None:
            yield rap, rap.monitor_state


def _monitor_negated(base: Base) -> Iterator[Edit]:
    for _, formula in _monitors(base):
        yield negated(base, formula)


def _monitor_test_dropped(base: Base) -> Iterator[Edit]:
    for _, formula in _monitors(base):
        if isinstance(formula, nodes.And):
            for part in formula.parts:
                if isinstance(part, nodes.Compare):
                    yield Edit(part.span, "")


def _monitor_dropped(base: Base) -> Iterator[Edit]:
    for _, formula in _monitors(base):
        yield Edit(base.around(formula.span), "", "monitor-state")


def _monitor_binds_age(base: Base) -> Iterator[Edit]:
    for believe in base.index.of(nodes.Believe):
        rap = believe.owner
        if isinstance(rap, nodes.DefineRap) and rap.monitor_state is not None:
            inside = rap.monitor_state.span
            if inside.start <= believe.node.span.start < inside.end:
                yield Edit(believe.node.age.span, "?age")


def _never_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        if isinstance(rap.succeed, nodes.Truth) and not rap.succeed.value:
            yield Edit(base.around(rap.succeed.span), "", "(succeed nil)")


def _task_lowered(base: Base) -> Iterator[Edit]:
    """A task that stands by is given the priority of what it is to interrupt."""
    for agenda in base.library.agendas.values():
        for task in agenda.tasks:
            text = base.text(task.span)
            if task.background and task.priority:
                old = f":priority {task.priority}"
                yield Edit(task.span, text.replace(old, ":priority 0"))


def _step_raised(base: Base) -> Iterator[Edit]:
    for _, step in base.steps():
        if step.priority == 0:
            yield Edit(base.head(step), f"{step.tag} 50")


# --- methods and loops ----------------------------------------------------------------


def _loop_dropped(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        if rap.repeat_while is not None:
            yield Edit(base.around(rap.repeat_while.span), "")


def _calls_itself(base: Base) -> Iterator[Edit]:
    for rap, _, net in base.nets():
        for step in net.steps:
            if not step.goal.outputs and not rap.outputs and len(net.steps) == 1:
                own = " ".join([rap.name, *(v.name for v in rap.inputs)])
                yield Edit(step.goal.span, f"({own})")


def _clauses(
    base: Base, clause: str
) -> Iterator[tuple[nodes.DefineRap, nodes.Formula]]:
    for rap in base.raps:
        for one in formulas(rap):
            if one.clause.word == clause:
                yield rap, one.formula


def _succeed_never(base: Base) -> Iterator[Edit]:
    for rap, formula in _clauses(base, "succeed"):
        if rap.monitor_state is None and rap.monitor_time is None:
            yield Edit(formula.span, "nil")


def _succeed_always(base: Base) -> Iterator[Edit]:
    for rap, formula in _clauses(base, "succeed"):
        if rap.methods and not rap.outputs:
            yield Edit(formula.span, "true")


def _succeed_negated(base: Base) -> Iterator[Edit]:
    for rap, formula in _clauses(base, "succeed"):
        if not rap.outputs and not isinstance(formula, nodes.Truth):
            yield negated(base, formula)


def _context_is_succeed(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for method in rap.methods:
            if (
                rap.succeed
                and method.context
                and not isinstance(rap.succeed, nodes.Truth)
            ):
                yield Edit(method.context.span, base.text(rap.succeed.span))


def _context_contradicts(base: Base) -> Iterator[Edit]:
    """A context asks for what the precondition forbids."""
    for rap in base.raps:
        for method in rap.methods:
            if rap.preconditions and method.context:
                denied = f"(not {base.text(rap.preconditions.span)})"
                whole = f"(and {base.text(method.context.span)} {denied})"
                yield Edit(method.context.span, whole)


def _method_twice(base: Base) -> Iterator[Edit]:
    for rap in base.raps:
        for method in rap.methods:
            text = base.text(method.span)
            again = re.sub(r"^\(method(\s+[^\s()]+)?", "(method again", text)
            end = method.span.end
            yield Edit(Span(method.span.file, end, end), f"\n  {again}")


def _value_twice(base: Base) -> Iterator[Edit]:
    """A conjunction asks one property for two values."""
    for _, formula in base.contexts():
        for part in formula.parts:
            if not isinstance(part, nodes.Proposition):
                continue
            declared = base.signatures.relations.get(part.name)
            last = part.args[-1] if part.args else None
            if declared and declared.is_property and isinstance(last, nodes.Const):
                text = base.text(part.span)
                start = last.span.start - part.span.start
                end = part.span.end
                other = "false" if last.value == "true" else "elsewhere"
                yield Edit(Span(part.span.file, end, end), f" {text[:start]}{other})")


# --- effects and sensing --------------------------------------------------------------


def _changes(base: Base) -> Iterator[nodes.ResourceChange]:
    for one in base.index.of(nodes.ResourceChange):
        yield one.node


def _wrong_resource(base: Base) -> Iterator[Edit]:
    other = {"set": "counter", "counter": "set"}
    for change in _changes(base):
        sort, verb = change.op.split("-")
        yield Edit(base.head(change), f"{other[sort]}-{verb}")


def _verb_turned_round(base: Base) -> Iterator[Edit]:
    other = {"add": "sub", "sub": "add"}
    for change in _changes(base):
        sort, verb = change.op.split("-")
        yield Edit(base.head(change), f"{sort}-{other[verb]}")


def _change_dropped(base: Base) -> Iterator[Edit]:
    for change in _changes(base):
        yield Edit(change.span, "", base.text(change.resource.span))


def _amount_no_number(base: Base) -> Iterator[Edit]:
    for change in _changes(base):
        if change.op.startswith("counter"):
            yield Edit(change.amount.span, "one")


def _effect_negated(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.DeclaredEffect):
        if not one.node.negated and not one.node.possible:
            yield Edit(one.node.span, f"(not {base.text(one.node.span)})")


def _on_dropped(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.ResultEffects):
        for effect in one.node.effects:
            yield Edit(effect.span, "")


def _age_dropped(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Believe):
        yield Edit(one.node.age.span, "")


def _age_zero(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Believe):
        if isinstance(one.node.age, nodes.Const):
            yield Edit(one.node.age.span, "0")


def _sensor_name_dropped(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.SensorName):
        if isinstance(one.parent, nodes.And):
            yield Edit(one.node.span, "")


def _comparison_turned_round(base: Base) -> Iterator[Edit]:
    other = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}
    for one in base.index.of(nodes.Compare):
        if one.node.op in other:
            yield Edit(base.head(one.node), other[one.node.op])


def _compared_with_word(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Compare):
        if isinstance(one.node.right, nodes.Const) and one.node.op in (
            "<",
            ">",
            "<=",
            ">=",
        ):
            yield Edit(one.node.right.span, "many")


def _foreign_operator(base: Base) -> Iterator[Edit]:
    for one in base.index.of(nodes.Compare):
        if one.node.op == "n=":
            yield Edit(base.head(one.node), "!=")


KINDS: Mapping[str, tuple[str, Kind]] = {
    "conjunct dropped": ("binding", _conjunct_dropped),
    "conjunct negated": ("binding", _conjunct_negated),
    "test before what it tests": ("binding", _conjuncts_turned_round),
    "conjunct made a choice": ("binding", _conjunct_made_a_choice),
    "`=` used to bind": ("binding", _equals_binds),
    "input renamed in the index": ("binding", _input_renamed),
    "output renamed in the index": ("binding", _output_renamed),
    "`and` forgotten": ("binding", _and_dropped),
    "`for` dropped": ("order", _for_dropped),
    "`for` of its own step": ("order", _for_itself),
    "`for` both ways": ("order", _for_both_ways),
    "`until` dropped": ("order", _until_dropped),
    "`until` of its own step": ("order", _until_itself),
    "tag given twice": ("order", _tag_twice),
    "tag forgotten": ("order", _tag_left_out),
    "window turned round": ("order", _window_turned_round),
    "`monitor-time` turned round": ("monitors", _monitor_time_turned_round),
    "`monitor-time` from 0": ("monitors", _monitor_time_now),
    "monitor negated": ("monitors", _monitor_negated),
    "test dropped from a monitor": ("monitors", _monitor_test_dropped),
    "monitor dropped": ("monitors", _monitor_dropped),
    "monitor binds an age": ("monitors", _monitor_binds_age),
    "`(succeed nil)` dropped": ("monitors", _never_dropped),
    "standing task as low as the work": ("priorities", _task_lowered),
    "step of priority 50": ("priorities", _step_raised),
    "`repeat-while` dropped": ("loops", _loop_dropped),
    "step is its own RAP": ("loops", _calls_itself),
    "`succeed` never": ("loops", _succeed_never),
    "`succeed` always": ("loops", _succeed_always),
    "`succeed` negated": ("loops", _succeed_negated),
    "context says what `succeed` says": ("methods", _context_is_succeed),
    "context against the precondition": ("methods", _context_contradicts),
    "method given twice": ("methods", _method_twice),
    "property with two values": ("methods", _value_twice),
    "set for counter": ("effects", _wrong_resource),
    "`add` for `sub`": ("effects", _verb_turned_round),
    "change of a resource dropped": ("effects", _change_dropped),
    "amount no number": ("effects", _amount_no_number),
    "declared effect negated": ("effects", _effect_negated),
    "declared effect dropped": ("effects", _on_dropped),
    "age of a belief dropped": ("sensing", _age_dropped),
    "age of a belief 0": ("sensing", _age_zero),
    "`know-sensor-name` dropped": ("sensing", _sensor_name_dropped),
    "comparison turned round": ("sensing", _comparison_turned_round),
    "compared with a word": ("sensing", _compared_with_word),
    "operator of another language": ("sensing", _foreign_operator),
}
"""The kinds of slips, each with the group that it is of."""
