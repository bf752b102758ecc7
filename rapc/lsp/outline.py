"""Symbols of files and of the workspace, and stretches that can be folded."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from lsprotocol import types

from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import KINDS, Named, name_span, own_methods
from rapc.lsp.workspace import View, Workspace
from rapc.parser.syntax import lists

_MOST = 500
"""The number of symbols that a search of the workspace returns."""

_Kind = types.SymbolKind

_KINDS: Mapping[type[nodes.Node], types.SymbolKind] = {
    nodes.DefineRap: _Kind.Function,
    nodes.DefineMethod: _Kind.Method,
    nodes.DefineQuery: _Kind.Operator,
    nodes.DefineAgenda: _Kind.Module,
    nodes.DefineTest: _Kind.Event,
    nodes.DeclareKind: _Kind.Enum,
    nodes.DeclareProposition: _Kind.Field,
    nodes.DeclareProperty: _Kind.Property,
    nodes.DeclareFunction: _Kind.Operator,
    nodes.DeclarePrimitive: _Kind.Interface,
    nodes.DeclareDatum: _Kind.Struct,
    nodes.DeclareSkill: _Kind.Interface,
    nodes.DeclareEvent: _Kind.Event,
}


def document_symbols(view: View) -> list[types.DocumentSymbol]:
    """Return the definitions and declarations of a file, with methods and steps."""
    return [_symbol(view, form) for form in _forms(view)]


def workspace_symbols(workspace: Workspace, query: str) -> list[types.WorkspaceSymbol]:
    """Return the definitions of all libraries whose names contain a text."""
    wanted = query.lower()
    found: dict[tuple[str, Span], types.WorkspaceSymbol] = {}
    for snapshot in list(workspace.snapshots.values()):
        for part in snapshot.parts:
            for form in (*part.library.forms, *part.library.tests):
                name = getattr(form, "name", "")
                key = (name, form.span)
                if type(form) not in _KINDS or wanted not in name or key in found:
                    continue
                if len(found) == _MOST:
                    return list(found.values())
                view = View(workspace, snapshot, part, form.span.file)
                place = view.location(name_span(part.loaded.files, form))
                found[key] = types.WorkspaceSymbol(place, name, _KINDS[type(form)])
    return list(found.values())


def _forms(view: View) -> Iterator[Named]:
    """Yield the forms of a file with a name."""
    library = view.part.library
    every = (*library.forms, *library.methods, *library.tests)
    here = [one for one in every if one.span.file == view.name]
    yield from sorted(
        (one for one in here if type(one) in _KINDS), key=lambda one: one.span.start
    )


def _symbol(view: View, form: Named) -> types.DocumentSymbol:
    name = getattr(form, "name", "")
    children: list[types.DocumentSymbol] = []
    detail = KINDS[type(form)][2] if type(form) in KINDS else "test"
    if isinstance(form, nodes.DefineMethod):
        name = f"{form.rap} {form.method.traced_name}"
        detail = "method"
        children = list(_steps(view, form.method))
    elif isinstance(form, nodes.DefineRap):
        for method in own_methods(form):
            start = view.range(method.span)
            steps_ = list(_steps(view, method))
            children.append(
                types.DocumentSymbol(
                    method.traced_name, _Kind.Method, start, start, children=steps_
                )
            )
    place = name_span(view.part.loaded.files, form)
    inner = place if form.span.contains(place) else form.span
    return types.DocumentSymbol(
        name or "?",
        _KINDS[type(form)],
        view.range(form.span),
        view.range(inner),
        detail=detail,
        children=children or None,
    )


def _steps(view: View, method: nodes.Method) -> Iterator[types.DocumentSymbol]:
    for step in steps(method):
        place = view.range(step.span)
        name = f"{step.tag} {step.goal.name}"
        yield types.DocumentSymbol(name, _Kind.Object, place, place)


def folding_ranges(view: View) -> list[types.FoldingRange]:
    """Return the lists and comments of a file that take more than one line."""
    unit = view.part.units[view.name]
    comment = types.FoldingRangeKind.Comment
    forms = _rows(view, ((one.start, one.end) for one in lists(unit.data)))
    comments = _rows(view, _blocks(view, [one.span for one in unit.comments]))
    return [
        *(types.FoldingRange(start, end) for start, end in forms),
        *(types.FoldingRange(start, end, kind=comment) for start, end in comments),
    ]


def _rows(view: View, spans: Iterable[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Yield the rows of spans of several lines; of spans in one row the outermost."""
    seen: set[int] = set()
    for start, end in spans:
        place = view.range(Span(view.name, start, end))
        first, last = place.start.line, place.end.line
        if last > first and first not in seen:
            seen.add(first)
            yield first, last


def _blocks(view: View, spans: Sequence[Span]) -> Iterator[tuple[int, int]]:
    """Yield comments; comments on lines one after another are one."""
    text = view.source.text
    at = 0
    while at < len(spans):
        start = end = at
        while end + 1 < len(spans):
            gap = text[spans[end].end : spans[end + 1].start]
            if gap.strip() or gap.count("\n") != 1:
                break
            end += 1
        yield spans[start].start, spans[end].end
        at = end + 1
