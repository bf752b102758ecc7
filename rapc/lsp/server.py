"""The language server: requests of the protocol, and the features that answer."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Generator
from typing import Any

from lsprotocol import types
from msgspec.structs import replace
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol
from pygls.protocol.language_server import lsp_method

from rapc.base.version import VERSION
from rapc.lsp.diagnostics import diagnostics
from rapc.lsp.hover import hover
from rapc.lsp.names import declared, definition_of
from rapc.lsp.project import Delays, Snapshot, Worker
from rapc.lsp.workspace import Workspace, name_of


class Protocol(LanguageServerProtocol):
    """The protocol with the texts and positions of `Workspace`, not those of pygls."""

    _server: Server

    @lsp_method(types.INITIALIZE)
    def lsp_initialize(
        self, params: types.InitializeParams
    ) -> Generator[Any, Any, types.InitializeResult]:
        """Choose the unit of positions, and offer only what the client supports."""
        self._server.begin(params)
        result = yield from super().lsp_initialize(params)
        units = types.PositionEncodingKind
        wide = self._server.rap.wide
        result.capabilities.position_encoding = units.Utf16 if wide else units.Utf32
        if not self._server.pulls:
            result.capabilities.diagnostic_provider = None
        return result

    @lsp_method(types.TEXT_DOCUMENT_DID_OPEN)
    def lsp_text_document__did_open(
        self, params: types.DidOpenTextDocumentParams
    ) -> None:
        """Add an open file."""
        self._server.opened(params.text_document)

    @lsp_method(types.TEXT_DOCUMENT_DID_CHANGE)
    def lsp_text_document__did_change(
        self, params: types.DidChangeTextDocumentParams
    ) -> None:
        """Apply edits."""
        self._server.edited(params)

    @lsp_method(types.TEXT_DOCUMENT_DID_CLOSE)
    def lsp_text_document__did_close(
        self, params: types.DidCloseTextDocumentParams
    ) -> None:
        """Remove an open file: the file on the disk counts again."""
        self._server.closed(params.text_document.uri)

    @lsp_method(types.SHUTDOWN)
    def lsp_shutdown(self, *args: Any) -> Generator[Any, Any, None]:
        """End the worker."""
        self._server.worker.stop()
        yield from super().lsp_shutdown(*args)


class Server(LanguageServer):
    """A language server for the folders of one editor."""

    rap: Workspace
    worker: Worker

    def __init__(self) -> None:
        super().__init__("rapc", VERSION, protocol_cls=Protocol)
        #: Whether the client requests diagnostics, rather than receives them.
        self.pulls = False
        #: The addresses of files with published diagnostics.
        self._published: set[str] = set()

    # --- the client ---------------------------------------------------------------

    def begin(self, params: types.InitializeParams) -> None:
        """Start the worker for the folders of the client."""
        general = params.capabilities.general
        encodings = (general and general.position_encodings) or []
        folders = [one.uri for one in params.workspace_folders or ()]
        if not folders and params.root_uri:
            folders = [params.root_uri]
        self.pulls = _refreshes(params.capabilities)
        self.rap = Workspace(
            types.PositionEncodingKind.Utf32 not in encodings, map(name_of, folders)
        )
        loop = asyncio.get_running_loop()

        def publish(snapshot: Snapshot) -> None:
            loop.call_soon_threadsafe(self._receive, snapshot)

        def log(message: str) -> None:
            loop.call_soon_threadsafe(self._log, message)

        self.worker = Worker(_delays(params.initialization_options), publish, log)
        self.worker.start()
        self.worker.tell(self.rap.work())

    def opened(self, document: types.TextDocumentItem) -> None:
        """Add an open file."""
        self.rap.open(document.uri, document.text, document.version)
        self.worker.tell(self.rap.work())

    def edited(self, params: types.DidChangeTextDocumentParams) -> None:
        """Apply edits to an open file."""
        name = name_of(params.text_document.uri)
        document = self.rap.documents[name]
        document.edit(params.content_changes, params.text_document.version)
        self.worker.tell(self.rap.work(), name, typed=True)

    def closed(self, uri: str) -> None:
        """Remove an open file."""
        self.rap.documents.pop(name_of(uri), None)
        self.worker.tell(self.rap.work())

    # --- snapshots ----------------------------------------------------------------

    def _receive(self, snapshot: Snapshot) -> None:
        """Use a snapshot from now on, and send its findings to the client."""
        self.rap.snapshots[snapshot.member] = snapshot
        self.publish()

    def publish(self) -> None:
        """Send the findings of all files; a client that requests them is notified."""
        found = {self.rap.uri(name) for name in self._files_with_findings()}
        if self.pulls:
            found -= {one.uri for one in self.rap.documents.values()}
            self.workspace_diagnostic_refresh(None)
        for uri in found | self._published:
            self.text_document_publish_diagnostics(
                types.PublishDiagnosticsParams(uri, diagnostics(self.rap, uri))
            )
        self._published = found

    def _files_with_findings(self) -> set[str]:
        found: set[str] = set()
        for snapshot in self.rap.snapshots.values():
            found |= {f.diagnostic.span.file for f in snapshot.report.findings}
            found |= snapshot.unreadable.keys()
        return found

    def _log(self, message: str) -> None:
        kind = types.MessageType.Warning
        self.window_log_message(types.LogMessageParams(kind, message))


def _refreshes(client: types.ClientCapabilities) -> bool:
    """Return whether a client requests diagnostics, and again after a refresh."""
    pulls = client.text_document is not None and client.text_document.diagnostic
    workspace = client.workspace
    told = workspace is not None and workspace.diagnostics
    return bool(pulls and told and told.refresh_support)


def _delays(options: object) -> Delays:
    """Return the delays from the options of the client, in milliseconds."""
    given = options if isinstance(options, dict) else {}
    delays = Delays()
    wanted = {"errors": given.get("errorDelay"), "everything": given.get("delay")}
    for name, value in wanted.items():
        if isinstance(value, int | float) and 0 <= value <= 60_000:
            delays = replace(delays, **{name: value / 1000})
    return delays


def make_server() -> Server:
    """Return a server with all features."""
    server = Server()

    @server.feature(types.TEXT_DOCUMENT_DIAGNOSTIC)
    def on_diagnostic(
        params: types.DocumentDiagnosticParams,
    ) -> types.RelatedFullDocumentDiagnosticReport:
        found = diagnostics(server.rap, params.text_document.uri)
        return types.RelatedFullDocumentDiagnosticReport(items=found)

    @server.feature(types.TEXT_DOCUMENT_HOVER)
    def on_hover(params: types.HoverParams) -> types.Hover | None:
        view = server.rap.view(params.text_document.uri)
        return None if view is None else hover(view, params.position)

    @server.feature(types.TEXT_DOCUMENT_DEFINITION)
    def on_definition(params: types.DefinitionParams) -> types.Location | None:
        view = server.rap.view(params.text_document.uri)
        if view is None:
            return None
        found = declared(view.part, view.name, view.then(params.position))
        return None if found is None else view.location(definition_of(view.part, found))

    return server


def serve() -> None:
    """Serve the editor on standard input and output until it ends the session."""
    sys.setswitchinterval(0.001)  # requests do not wait long for the worker
    with os.fdopen(os.dup(1), "wb") as output:
        os.dup2(2, 1)  # what is printed by mistake must not reach the editor
        make_server().start_io(stdout=output)
