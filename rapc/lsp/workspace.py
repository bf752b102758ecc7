"""The open files of the editor and the latest snapshots, as the features see them.

A request is answered at once from the latest snapshot of a library; places are moved by
the edits since. All of this belongs to the thread of the protocol.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from functools import cache, cached_property
from itertools import islice

from lsprotocol import types
from msgspec.structs import replace
from pygls.uris import from_fs_path, to_fs_path

from rapc.analysis import suppressions
from rapc.analysis.driver import Finding
from rapc.analysis.libraries import LibrarySpec
from rapc.analysis.naming import Naming
from rapc.base.files import STANDARD, SUFFIX, fold_line_ends, path_of
from rapc.base.source import SourceFile, Span
from rapc.lsp.positions import Change, Text, change, moved, moved_back
from rapc.lsp.project import Part, Snapshot, Syntax, Work
from rapc.parser.names import Named
from rapc.parser.rules.table import RULES as READER_RULES

_OF_READER = frozenset(rule.name for rule in READER_RULES)
"""The rules of the findings in a `Syntax`."""


class Document:
    """A file that is open in the editor, with the changes since it was opened."""

    def __init__(self, uri: str, text: Text, version: int, first: int) -> None:
        self.uri = uri
        self.text = text
        self.version = version
        self.changes: list[Change] = []
        #: The revision of the text when the file was opened.
        self.first = first

    @property
    def revision(self) -> int:
        """The number of the state of the text, in the order of all states."""
        return self.first + len(self.changes)

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

    def unchanged(self, span: Span) -> bool:
        """Return whether the text of a span of the file is the same in the editor."""
        now = self.text
        start, end = now.stretch(self.range(span))
        return now.text[start:end] == self.source.text[span.start : span.end]

    def beside(self, name: str) -> View:
        """Return another file of the same part."""
        return View(self.workspace, self.snapshot, self.part, name)

    @cached_property
    def names(self) -> Names:
        """The names of all libraries, this snapshot first."""
        return Names(self.workspace, self.snapshot)

    def named(self, position: types.Position) -> Named | None:
        """Return the name at a position in the editor."""
        return self.names.naming.at(self.name, self.then(position))


class Names:
    """The names of all libraries, with their places in the editor.

    A file that several libraries read has the state of the first one.
    """

    def __init__(self, workspace: Workspace, first: Snapshot) -> None:
        self._workspace = workspace
        others = (one for one in workspace.snapshots.values() if one is not first)
        self._read: dict[str, tuple[Snapshot, Part]] = {}
        loads = []
        for snapshot in (first, *others):
            for part in snapshot.parts:
                loads.append(part.loaded)
                for unit in part.loaded.units:
                    self._read.setdefault(unit.file.name, (snapshot, part))
        self.naming = Naming(loads)

    def view(self, name: str) -> View:
        """Return a file by its name in spans."""
        return View(self._workspace, *self._read[name], name)

    def location(self, span: Span) -> types.Location:
        """Return the place of a span in the editor."""
        return self.view(span.file).location(span)

    def unchanged(self, span: Span) -> bool:
        """Return whether the text of a span is the same in the editor."""
        return self.view(span.file).unchanged(span)


class Workspace:
    """The folders and open files of the editor, and the snapshots of libraries.

    Args:
        wide: whether positions count UTF-16 units; see `rapc.lsp.positions`.
        folders: the paths of the folders.
    """

    def __init__(self, wide: bool, folders: Iterable[str]) -> None:
        self.wide = wide
        self.folders = list(folders)
        #: Whether the client accepts edits with the versions of files.
        self.versions = False
        self.documents: dict[str, Document] = {}
        self._revisions = 0
        self.snapshots: dict[LibrarySpec, Snapshot] = {}
        #: The syntax errors of files that were edited after the last snapshot.
        self._syntax: dict[str, Syntax] = {}

    # --- files ----------------------------------------------------------------------

    def open(self, uri: str, text: str, version: int) -> str:
        """Add an open file and return its name."""
        name = name_of(uri)
        made = Text(name, fold_line_ends(text), self.wide)
        self.documents[name] = Document(uri, made, version, self._revisions)
        return name

    def close(self, uri: str) -> str:
        """Remove an open file and return its name."""
        name = name_of(uri)
        for alias in aliases(name):
            self._syntax.pop(alias, None)
        document = self.documents.pop(name, None)
        if document is not None:
            self._revisions = max(self._revisions, document.revision + 1)
        return name

    def work(self) -> Work:
        """Return the state of the open files for the worker."""
        texts: dict[str, str] = {}
        revisions: dict[str, int] = {}
        for name, document in self.documents.items():
            if not name.endswith(SUFFIX):
                continue  # the Python code of a world, or a configuration
            for alias in aliases(name):
                texts[alias] = document.text.text
                revisions[alias] = document.revision
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

    def version(self, uri: str) -> int | None:
        """Return the version of an open file if all its findings are of this version.

        A library that was checked only for errors has not all findings.
        """
        document = self.documents.get(name_of(uri))
        views = list(self.views(uri))
        if document is None or not views:
            return None
        current = all(
            view.snapshot.whole
            and view.snapshot.revisions.get(view.name) == document.revision
            for view in views
        )
        return document.version if current else None

    # --- places ---------------------------------------------------------------------

    def since(self, snapshot: Snapshot, name: str) -> Sequence[Change]:
        """Return the changes of a file since a snapshot."""
        document = self.document(name)
        if document is None:
            return []
        seen = snapshot.revisions.get(name, document.first)
        return document.changes[max(seen - document.first, 0) :]

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
            View(self, snapshot, part, name)
            for snapshot in self.snapshots.values()
            for name in names
            if (part := snapshot.part(name)) is not None
        ]
        found.sort(
            key=lambda view: (
                not view.snapshot.owns(view.name),
                -len(view.part.loaded.files),
            )
        )
        yield from found

    def view(self, uri: str) -> View | None:
        """Return the snapshot that decides about a file, if there is one yet."""
        return next(self.views(uri), None)

    def receive(self, snapshot: Snapshot) -> None:
        """Use a snapshot from now on."""
        self.snapshots[snapshot.spec] = snapshot
        for name, read in list(self._syntax.items()):
            if snapshot.revisions.get(name, -1) >= read.revision:
                del self._syntax[name]

    def receive_syntax(self, read: Syntax) -> None:
        """Use the syntax errors of a file, unless a snapshot has them."""
        snapshots = self.snapshots.values()
        if all(one.revisions.get(read.name, -1) < read.revision for one in snapshots):
            self._syntax[read.name] = read

    def latest(self, uri: str) -> Iterator[tuple[View, Finding]]:
        """Yield the findings of a file, with the syntax errors of its latest text."""
        reads = [self._syntax.get(name) for name in aliases(name_of(uri))]
        read = next(filter(None, reads), None)
        if read is None:
            yield from self.findings(uri)
            return
        for view, finding in self.findings(uri):
            if finding.diagnostic.rule not in _OF_READER:
                yield view, finding
        for view in islice(self.views(uri), 1):
            revisions = {**view.snapshot.revisions, view.name: read.revision}
            now = replace(view.snapshot, revisions=revisions)
            for finding in read.findings:
                yield View(self, now, view.part, view.name), finding

    def findings(self, uri: str) -> Iterator[tuple[View, Finding]]:
        """Yield the findings of a file in all libraries; see `merged_reports`."""
        views = list(self.views(uri))
        seen: set[tuple[str, Span, str]] = set()
        for view in views:
            for finding in view.snapshot.findings.get(view.name, ()):
                found = finding.diagnostic
                key = (found.rule, found.span, found.message)
                unused = found.rule == suppressions.UNUSED.name and not all(
                    finding in other.snapshot.findings.get(other.name, ())
                    for other in views
                )
                if key not in seen and not unused:
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


@cache  # the file system is asked once: each call lets the worker run first
def aliases(name: str) -> Sequence[str]:
    """Return the names of a file in spans: its path, and its standard name."""
    real, folder = os.path.realpath(name), _standard_folder()
    if real.startswith(folder + os.sep):
        return name, f"{STANDARD}{os.path.relpath(real, folder)}"
    return (name,)


@cache
def _standard_folder() -> str:
    return os.path.realpath(path_of(STANDARD))
