"""Definitions, uses, renaming, and the hierarchy of calls."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from lsprotocol import types
from pygls.exceptions import JsonRpcException

from rapc.analysis.naming import NamingError
from rapc.base.files import names_at
from rapc.base.source import Span
from rapc.errors import LoadError, in_a_line
from rapc.ir import nodes
from rapc.library.loader import resolve
from rapc.lsp.workspace import View
from rapc.lsp.worlds import handlers, names_in_worlds
from rapc.parser.names import Named

Edits = Mapping[str, Sequence[types.TextEdit]]
"""The edits of each file, by its address."""


class RefusedRequestError(JsonRpcException):
    """A request that cannot be carried out; the editor shows the message."""

    CODE = -32803
    MESSAGE = "Request failed"


def definition(view: View, position: types.Position) -> list[types.Location]:
    """Return where a name is defined.

    At a declaration of a primitive or a datum, the handler in Python is the answer; at
    a `require`, the required files.
    """
    required = _required(view, view.then(position))
    if required:
        return required
    named = view.named(position)
    if named is None:
        return []
    if named.defines and named.space in ("primitive", "datum"):
        return handlers(view.workspace, named.name) or [_place(view, named)]
    return [_place(view, one) for one in view.names.naming.definitions(named)]


def implementation(view: View, position: types.Position) -> list[types.Location]:
    """Return the handlers in Python of a primitive or datum."""
    named = view.named(position)
    if named is None or named.space not in ("primitive", "datum"):
        return []
    return handlers(view.workspace, named.name)


async def references(
    view: View, position: types.Position, declaration: bool
) -> list[types.Location]:
    """Return all uses of a name, with its declarations if wanted.

    A thread looks for the uses: a name may have thousands.
    """
    named = view.named(position)
    if named is None:
        return []
    found = await asyncio.to_thread(view.names.naming.occurrences, named)
    places = [_place(view, one) for one in found if declaration or not one.defines]
    if named.space in ("primitive", "datum"):
        places += handlers(view.workspace, named.name, worlds=False)
    return places


def highlights(view: View, position: types.Position) -> list[types.DocumentHighlight]:
    """Return the uses of a name in its own file."""
    named = view.named(position)
    if named is None:
        return []
    kinds = types.DocumentHighlightKind
    return [
        types.DocumentHighlight(
            view.range(one.span), kinds.Write if one.defines else kinds.Read
        )
        for one in view.names.naming.occurrences_beside(named)
    ]


def _place(view: View, named: Named) -> types.Location:
    return view.names.location(named.span)


def _required(view: View, offset: int) -> list[types.Location]:
    """Return the start of each file that a `require` at an offset means."""
    found = view.part.index.at(view.name, offset)
    if found is None or not isinstance(found.node, nodes.Require):
        return []
    return [
        types.Location(view.workspace.uri(name), _START)
        for name in required_files(view, found.node)
    ]


_START = types.Range(types.Position(0, 0), types.Position(0, 0))


def required_files(view: View, form: nodes.Require) -> list[str]:
    """Return the names of the files that a `require` means."""
    target = resolve(form.name, view.name, ())
    try:
        return [] if target is None else list(names_at(target, tests=False))
    except LoadError:  # the folder has been removed
        return []


def links(view: View) -> list[types.DocumentLink]:
    """Return the `require` forms that mean a single file, as links."""
    found = []
    for form in view.part.library.forms:
        if isinstance(form, nodes.Require) and form.span.file == view.name:
            files = required_files(view, form)
            if len(files) == 1:
                uri = view.workspace.uri(files[0])
                start = view.source.text.index('"', form.span.start)
                end = view.source.text.index('"', start + 1) + 1
                name = view.range(view.source.span(start, end))
                found.append(types.DocumentLink(name, target=uri))
    return found


# --- renaming -----------------------------------------------------------------------


def prepare_rename(
    view: View, position: types.Position
) -> types.PrepareRenamePlaceholder | None:
    """Return the name that would be renamed at a position."""
    named = view.named(position)
    if named is None or not view.names.unchanged(named.span):
        return None
    return types.PrepareRenamePlaceholder(view.range(named.span), named.name)


async def rename(view: View, position: types.Position, new: str) -> types.WorkspaceEdit:
    """Return the edits that rename a name in all files.

    A thread looks for the edits: all files with the name are parsed again.

    Raises:
        RefusedRequestError: if the name cannot be renamed.
    """
    named = view.named(position)
    if named is None:
        raise RefusedRequestError("no name at this position")
    try:
        code, naming = names_in_worlds(view), view.names.naming
        edits = await asyncio.to_thread(naming.renamed, named, new, code)
    except NamingError as error:
        raise RefusedRequestError(in_a_line(error)) from error
    changes: dict[str, list[types.TextEdit]] = {}
    for edit in edits:
        if not view.names.unchanged(edit.span):
            raise RefusedRequestError("the file has changed; try again")
        place = view.names.location(edit.span)
        made = types.TextEdit(place.range, edit.content)
        changes.setdefault(place.uri, []).append(made)
    return workspace_edit(view, changes)


def workspace_edit(view: View, changes: Edits) -> types.WorkspaceEdit:
    """Return edits of files, with the versions of the open files they are for."""
    documents = {one.uri: one for one in view.workspace.documents.values()}
    edits: list[Any] = []
    for uri, made in changes.items():
        version = documents[uri].version if uri in documents else None
        identity = types.OptionalVersionedTextDocumentIdentifier(uri, version)
        edits.append(types.TextDocumentEdit(identity, list(made)))
    if view.workspace.versions:
        return types.WorkspaceEdit(document_changes=edits)
    return types.WorkspaceEdit(
        changes={uri: list(made) for uri, made in changes.items()}
    )


# --- calls --------------------------------------------------------------------------


def prepare_calls(
    view: View, position: types.Position
) -> list[types.CallHierarchyItem]:
    """Return the RAP at a position."""
    named = view.named(position)
    if named is None or named.space != "RAP":
        return []
    return list(_items(view, named.name))


def _items(view: View, name: str) -> Iterator[types.CallHierarchyItem]:
    rap = view.part.library.raps.get(name)
    if rap is not None:
        yield types.CallHierarchyItem(
            name,
            types.SymbolKind.Function,
            view.workspace.uri(rap.span.file),
            view.range(rap.span),
            view.range(rap.name_span),
        )


def incoming(view: View, name: str) -> list[types.CallHierarchyIncomingCall]:
    """Return the RAPs whose steps call a RAP."""
    found: dict[str, list[types.Range]] = {}
    for use in view.part.index.uses_of("goal", name):
        if isinstance(use.owner, nodes.DefineRap):
            place = use.place(view.part.loaded.files)
            found.setdefault(use.owner.name, []).append(view.range(place))
    return [
        types.CallHierarchyIncomingCall(item, ranges)
        for caller, ranges in found.items()
        for item in _items(view, caller)
    ]


def outgoing(view: View, name: str) -> list[types.CallHierarchyOutgoingCall]:
    """Return the RAPs that the steps of a RAP call."""
    found: dict[str, list[types.Range]] = {}
    rap = view.part.library.raps.get(name)
    for use in view.part.index.uses() if rap is not None else ():
        if use.use == "goal" and use.owner is rap:
            place: Span = use.place(view.part.loaded.files)
            found.setdefault(use.name, []).append(view.range(place))
    return [
        types.CallHierarchyOutgoingCall(item, ranges)
        for called, ranges in found.items()
        for item in _items(view, called)
    ]
