"""The open files of the editor and the latest snapshots, as the features see them.

A request is answered at once from the latest snapshot of a library; places are moved by
the edits since. All of this belongs to the thread of the protocol.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from functools import cache

from lsprotocol import types
from pygls.uris import from_fs_path, to_fs_path

from rapc.analysis.driver import Finding
from rapc.base.files import STANDARD, fold_line_ends, path_of
from rapc.base.source import SourceFile, Span
from rapc.lsp.positions import Change, Text, change, moved, moved_back
from rapc.lsp.project import Member, Part, Snapshot, Work


class Document:
    """A file that is open in the editor, with the changes since it was opened."""

    def __init__(self, uri: str, text: Text, version: int) -> None:
        self.uri = uri
        self.text = text
        self.version = version
        self.changes: list[Change] = []

    def edit(
        self, events: Iterable[types.TextDocumentContentChangeEvent], version: int
    ) -> None:
        """Apply edits of the client, in order."""
        for event in events:
            new, made = change(self.text, event)
            self.text = Text(self.text.name, new, self.text.wide)
            self.changes.append(made)
        self.version = version


class View:
    """A file of a snapshot, with places in the present texts.

    Args:
        workspace: the open files.
        snapshot: the snapshot.
        part: the part of the snapshot with the file.
        name: the name of the file in spans of the part.
    """

    def __init__(
        self, workspace: Workspace, snapshot: Snapshot, part: Part, name: str
    ) -> None:
        self.workspace = workspace
        self.snapshot = snapshot
        self.part = part
        self.name = name

    @property
    def source(self) -> SourceFile:
        """The file as the snapshot has it."""
        return self.part.loaded.files[self.name]

    @property
    def text(self) -> Text:
        """The file as the editor has it."""
        return self.workspace.text(self.snapshot, self.part, self.name)

    def then(self, position: types.Position) -> int:
        """Return the offset in the snapshot of a position in the editor."""
        offset = self.text.offset(position)
        return moved_back(offset, self.workspace.since(self.snapshot, self.name))

    def range(self, span: Span) -> types.Range:
        """Return the range in the editor of a span of any file."""
        return self.workspace.range(self.snapshot, self.part, span)

    def location(self, span: Span) -> types.Location:
        """Return the file and range in the editor of a span."""
        return types.Location(self.workspace.uri(span.file), self.range(span))

    def beside(self, name: str) -> View:
        """Return another file of the same part."""
        return View(self.workspace, self.snapshot, self.part, name)


class Workspace:
    """The folders and open files of the editor, and the snapshots of libraries.

    Args:
        wide: whether positions count UTF-16 units; see `rapc.lsp.positions`.
        folders: the paths of the folders.
    """

    def __init__(self, wide: bool, folders: Iterable[str]) -> None:
        self.wide = wide
        self.folders = list(folders)
        self.documents: dict[str, Document] = {}
        self.snapshots: dict[Member, Snapshot] = {}

    # --- files ----------------------------------------------------------------------

    def open(self, uri: str, text: str, version: int) -> str:
        """Add an open file and return its name."""
        name = name_of(uri)
        made = Text(name, fold_line_ends(text), self.wide)
        self.documents[name] = Document(uri, made, version)
        return name

    def work(self) -> Work:
        """Return the state of the open files for the worker."""
        texts: dict[str, str] = {}
        revisions: dict[str, int] = {}
        for name, document in self.documents.items():
            for alias in aliases(name):
                texts[alias] = document.text.text
                revisions[alias] = len(document.changes)
        return Work(texts, revisions, tuple(self.folders))

    def document(self, name: str) -> Document | None:
        """Return the open file of a name in spans."""
        return self.documents.get(name) or self.documents.get(path(name))

    def uri(self, name: str) -> str:
        """Return the address of a file by its name in spans."""
        document = self.document(name)
        if document is not None:
            return document.uri
        return from_fs_path(path(name)) or name

    # --- places ---------------------------------------------------------------------

    def since(self, snapshot: Snapshot, name: str) -> Sequence[Change]:
        """Return the changes of a file since a snapshot."""
        document = self.document(name)
        seen = snapshot.revisions.get(name)
        return [] if document is None or seen is None else document.changes[seen:]

    def text(self, snapshot: Snapshot, part: Part, name: str) -> Text:
        """Return the text of a file in the editor, or on the disk."""
        document = self.document(name)
        if document is not None:
            return document.text
        return Text(name, part.loaded.files[name].text, self.wide)

    def range(self, snapshot: Snapshot, part: Part, span: Span) -> types.Range:
        """Return the range in the editor of a span."""
        if span.file not in part.loaded.files:
            return types.Range(types.Position(0, 0), types.Position(0, 0))
        changes = self.since(snapshot, span.file)
        start, end = moved(span.start, changes), moved(span.end, changes)
        return self.text(snapshot, part, span.file).range(start, end)

    # --- snapshots ------------------------------------------------------------------

    def views(self, uri: str) -> Iterator[View]:
        """Yield the snapshots with a file, those whose own file it is first."""
        names = aliases(name_of(uri))
        found = [
            (not snapshot.owns(name), at, View(self, snapshot, part, name))
            for at, snapshot in enumerate(self.snapshots.values())
            for name in names
            if (part := snapshot.part(name)) is not None
        ]
        yield from (view for _, _, view in sorted(found, key=lambda one: one[:2]))

    def view(self, uri: str) -> View | None:
        """Return the snapshot that decides about a file, if there is one yet."""
        return next(self.views(uri), None)

    def findings(self, uri: str) -> Iterator[tuple[View, Finding]]:
        """Yield the findings of a file.

        The libraries that the file belongs to report all their findings, others only
        errors.
        """
        seen: set[tuple[str, Span, str]] = set()
        first: View | None = None
        for view in self.views(uri):
            first = first or view
            of_all = view.snapshot.owns(view.name) or view is first
            for finding in view.snapshot.report.findings:
                found = finding.diagnostic
                if found.span.file != view.name:
                    continue
                key = (found.rule, found.span, found.message)
                if key not in seen and (of_all or finding.severity.word == "error"):
                    seen.add(key)
                    yield view, finding


def path(name: str) -> str:
    """Return the path of a file by its name in spans."""
    found = str(path_of(name))
    return os.path.realpath(found) if name.startswith(STANDARD) else found


def name_of(uri: str) -> str:
    """Return the name of a file by its address: a path, or the address of a buffer."""
    found = to_fs_path(uri) if uri.startswith("file:") else None
    return uri if found is None else os.path.normpath(found)


def aliases(name: str) -> Sequence[str]:
    """Return the names of a file in spans: its path, and its standard name."""
    real, folder = os.path.realpath(name), _standard_folder()
    if real.startswith(folder + os.sep):
        return name, f"{STANDARD}{os.path.relpath(real, folder)}"
    return (name,)


@cache
def _standard_folder() -> str:
    return os.path.realpath(path_of(STANDARD))
