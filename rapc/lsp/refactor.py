"""Refactorings of task-nets: steps become a RAP, a step becomes the steps of its RAP.

A refactoring is offered only if the order of the steps can be kept: annotations between
the steps and other steps must be plain orders, `(for tag)`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count
from typing import NamedTuple

from lsprotocol import types

from rapc.base.diagnostics import Edit, edited
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import own_methods
from rapc.lsp.navigation import workspace_edit
from rapc.lsp.workspace import View
from rapc.parser.formatter import formatted
from rapc.parser.names import Named


def refactorings(view: View, place: types.Range) -> Iterator[types.CodeAction]:
    """Yield the refactorings of the steps in a range."""
    start, end = view.then(place.start), view.then(place.end)
    if view.text.text != view.source.text:
        return
    net = _net_at(view, start, end)
    if net is None:
        return
    chosen = [one for one in net.steps if _meets(one.span, start, end)]
    if len(chosen) > 1 or (chosen and start < end):
        edits = _extracted(view, net, chosen)
        if edits is not None:
            kind = types.CodeActionKind.RefactorExtract
            title = (
                "Extract the steps into a RAP"
                if len(chosen) > 1
                else ("Extract the step into a RAP")
            )
            yield _action(view, title, kind, edits)
    elif len(chosen) == 1:
        edits = _inlined(view, net, chosen[0])
        if edits is not None:
            title = f"Inline `{chosen[0].goal.name}`"
            yield _action(view, title, types.CodeActionKind.RefactorInline, edits)


class _Net(NamedTuple):
    """A method with a task-net, and its form."""

    form: nodes.DefineRap
    method: nodes.Method
    steps: Sequence[nodes.Step]
    #: The span of the task-net.
    span: Span


def _net_at(view: View, start: int, end: int) -> _Net | None:
    for form in view.part.library.forms:
        if not isinstance(form, nodes.DefineRap) or form.span.file != view.name:
            continue
        for method in own_methods(form) if form.span.start <= start else ():
            body = method.body
            if isinstance(body, nodes.TaskNet) and _meets(body.span, start, end):
                return _Net(form, method, tuple(steps(method)), body.span)
    return None


def _meets(span: Span, start: int, end: int) -> bool:
    if start == end:
        return span.start <= start < span.end
    return span.start < end and start < span.end


def _action(
    view: View, title: str, kind: types.CodeActionKind, edits: Sequence[Edit]
) -> types.CodeAction:
    changes = [types.TextEdit(view.range(one.span), one.content) for one in edits]
    edit = workspace_edit(view, {view.workspace.uri(view.name): changes})
    return types.CodeAction(title, kind, edit=edit)


def _names(view: View, span: Span) -> list[Named]:
    """Return the variables and tags in a span of the file."""
    return [
        one
        for one in view.names.naming.names(span.file)
        if span.contains(one.span) and one.space in ("variable", "tag")
    ]


def _orders(
    net: _Net, inside: frozenset[str]
) -> tuple[list[nodes.For], list[nodes.For]] | None:
    """Return the orders from the inner steps to others, and from others to the inner.

    Returns None if an annotation that is not a plain order crosses.
    """
    out: list[nodes.For] = []
    into: list[nodes.For] = []
    for step in net.steps:
        for note in step.annotations:
            tag = note.reference if isinstance(note, nodes.Window) else None
            tag = getattr(note, "tag", tag)
            if tag is None or tag in ("now", "absolute"):
                continue
            if (step.tag in inside) == (tag in inside):
                continue
            if not isinstance(note, nodes.For) or note.formula is not None:
                return None
            (out if step.tag in inside else into).append(note)
    return out, into


# --- extraction -----------------------------------------------------------------------


def _extracted(
    view: View, net: _Net, chosen: Sequence[nodes.Step]
) -> Sequence[Edit] | None:
    """Return the edits that move steps into a RAP of their own."""
    orders = _orders(net, frozenset(one.tag for one in chosen))
    if orders is None:
        return None
    out, into = orders
    text = view.source.text
    inner = {one.span: _names(view, one.span) for one in chosen}
    used = _variables(name for names in inner.values() for name in names)
    around = _variables(
        one
        for one in _names(view, net.form.span)
        if not any(span.contains(one.span) for span in inner)
    )
    made = {
        term.name
        for one in chosen
        for term in one.goal.outputs
        if isinstance(term, nodes.Var)
    }
    if {one.variable.name for one in net.form.resources} & used.keys():
        return None
    outputs = [one for one in used if one in made and one in around]
    inputs = [one for one in used if one not in made and one in around]
    name = _free(f"{net.form.name}-{chosen[0].tag}", view.part.library.raps)
    removed = [Edit(one.span, "") for one in out]
    bodies = []
    for one in chosen:
        cuts = [edit for edit in removed if one.span.contains(edit.span)]
        bodies.append(_cut(text, one.span, cuts))
    results = f" => {' '.join(outputs)}" if outputs else ""
    index = " ".join([name, *inputs]) + results
    form = f"(define-rap ({index}) (method (task-net {chr(10).join(bodies)})))"
    tag = chosen[0].tag
    notes = "".join(f" (for {one})" for one in dict.fromkeys(note.tag for note in out))
    edits = [Edit(one.span, f"(for {tag})") for one in into]
    first, *rest = chosen
    edits.append(Edit(first.span, f"({tag} ({index}){notes})"))
    edits += [Edit(_with_gap(text, one.span), "") for one in rest]
    return [*edits, _new_form(view, net.form, form)]


def _variables(names: Iterable[Named]) -> dict[str, None]:
    return {one.name: None for one in names if one.space == "variable"}


def _free(name: str, taken: Mapping[str, object]) -> str:
    numbered = (f"{name}-{at}" for at in count(2))
    return name if name not in taken else next(n for n in numbered if n not in taken)


def _cut(text: str, span: Span, edits: Sequence[Edit]) -> str:
    """Return the text of a span after edits in the span."""
    moved = [
        Edit(Span("", e.span.start - span.start, e.span.end - span.start), e.content)
        for e in edits
    ]
    return edited(text[span.start : span.end], moved)


def _with_gap(text: str, span: Span) -> Span:
    """Return a span with the white space before it."""
    start = len(text[: span.start].rstrip())
    return Span(span.file, start, span.end)


def _new_form(view: View, after: nodes.DefineRap, form: str) -> Edit:
    """Return the insertion of a form, formatted, after a form."""
    text = formatted(SourceFile(view.name, form)).text.rstrip("\n")
    end = after.span.end
    return Edit(Span(view.name, end, end), f"\n\n{text}")


# --- inlining -------------------------------------------------------------------------


def _inlined(view: View, net: _Net, step: nodes.Step) -> Sequence[Edit] | None:
    """Return the edits that replace a step by the steps of its RAP."""
    rap = view.part.library.raps.get(step.goal.name)
    if rap is None or rap is net.form or not _is_plain(rap):
        return None
    (method,) = rap.methods
    called = list(steps(method))
    plain = all(map(_order, step.annotations))
    outputs = [*step.goal.outputs]
    if not called or not plain or step.priority or len(outputs) != len(rap.outputs):
        return None
    orders = _orders(net, frozenset([step.tag]))
    if orders is None or len(step.goal.args) != len(rap.inputs):
        return None
    _, into = orders
    source = view.part.loaded.files[rap.span.file].text
    here = view.source.text
    names = _renaming(view, net, step, rap)
    given = [*step.goal.args, *outputs]
    for variable, term in zip((*rap.inputs, *rap.outputs), given, strict=True):
        names[variable.name] = here[term.span.start : term.span.end]
    last = {one.tag for one in called} - {
        one.tag for one in called if any(map(_order, one.annotations))
    }
    targets = {_order(note) for one in called for note in one.annotations}
    first = [one.tag for one in called if one.tag not in targets]
    notes = "".join(f" {here[n.span.start : n.span.end]}" for n in step.annotations)
    bodies = []
    for one in called:
        edits = [
            Edit(name.span, names[name.name])
            for name in _names(view, one.span)
            if name.name in names
        ]
        body = _cut(source, one.span, edits)
        bodies.append(f"{body[:-1]}{notes})" if one.tag in last else body)
    starts = " ".join(f"(for {names[tag]})" for tag in first)
    indent = " " * (view.source.position(step.span.start).column - 1)
    replaced = Edit(step.span, f"\n{indent}".join(bodies))
    return [replaced, *(Edit(one.span, starts) for one in into)]


def _order(note: nodes.Annotation) -> str | None:
    """Return the tag of a plain order; None for other annotations."""
    is_order = isinstance(note, nodes.For) and note.formula is None
    return note.tag if is_order and isinstance(note, nodes.For) else None


def _is_plain(rap: nodes.DefineRap) -> bool:
    """Return whether a RAP has an index, one method with steps, and no clause else."""
    clauses = (
        *("duration", "monitor_state", "monitor_time", "repeat_while", "succeed"),
        *("preconditions", "constraints", "resources", "effects"),
    )
    if any(getattr(rap, clause) for clause in clauses) or len(rap.methods) != 1:
        return False
    method = rap.methods[0]
    parts = (method.context, method.notations, method.constraints)
    more = (method.claims, method.skills)
    return isinstance(method.body, nodes.TaskNet) and not any((*parts, *more))


def _renaming(
    view: View, net: _Net, step: nodes.Step, rap: nodes.DefineRap
) -> dict[str, str]:
    """Return new names for the tags and variables of a RAP that is put into a net."""
    taken = {one.name for one in _names(view, net.form.span)} - {step.tag}
    found: dict[str, str] = {}
    for one in _names(view, rap.methods[0].span):
        if one.name not in found:
            new = one.name
            if new in taken:
                known = dict.fromkeys((*taken, *found.values()))
                new = _free(f"{one.name}-{step.tag}", known)
            found[one.name] = new
    return found
