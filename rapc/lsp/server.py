"""The language server: requests of the protocol, and the features that answer."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
import sys
import threading
from collections.abc import Callable, Generator
from contextlib import suppress
from typing import Any, TypeVar

from lsprotocol import types
from msgspec.structs import replace
from pygls.io_ import StdoutWriter, run_async
from pygls.lsp.server import LanguageServer
from pygls.protocol import LanguageServerProtocol
from pygls.protocol.language_server import lsp_method

from rapc.analysis.libraries import LibrarySpec
from rapc.base.files import SUFFIX
from rapc.base.version import VERSION
from rapc.lsp import (
    actions,
    commands,
    formatting,
    hints,
    navigation,
    outline,
    tokens,
    worlds,
)
from rapc.lsp.complete import MOST, completions
from rapc.lsp.diagnostics import diagnostics
from rapc.lsp.hover import hover
from rapc.lsp.positions import Text
from rapc.lsp.project import Delays, Snapshot, Syntax, Worker
from rapc.lsp.workspace import View, Workspace, aliases, name_of

T = TypeVar("T")

_PIECE = 1 << 16
"""The number of bytes that are read at once."""

_PATIENCE = 10.0
"""The number of seconds that a request waits for the first snapshot of a file."""


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
        #: Whether the client has the command `hints.SHOW_CALLERS`.
        self.shows_callers = False
        #: The requests that make the client ask for hints again.
        self.refreshes: list[str] = []
        #: Set when the next snapshot arrives.
        self._arrival = asyncio.Event()
        #: The last published diagnostics of each file.
        self._published: dict[str, list[types.Diagnostic]] = {}

    async def read(self, stdin: int) -> None:
        """Receive messages from a file until its end.

        A thread reads. The reader of pygls also uses a thread, and waits for the worker
        several times in each message.
        """
        stream = asyncio.StreamReader()

        def receive(piece: bytes) -> None:
            if piece:
                stream.feed_data(piece)
            else:
                stream.feed_eof()

        give = _passed(receive)

        def read() -> None:
            while piece := os.read(stdin, _PIECE):
                give(piece)
            give(b"")

        threading.Thread(target=read, daemon=True, name="input").start()
        report = self.report_server_error
        await run_async(threading.Event(), stream, self.protocol, error_handler=report)

    # --- the client ---------------------------------------------------------------

    def begin(self, params: types.InitializeParams) -> None:
        """Start the worker for the folders of the client."""
        general = params.capabilities.general
        encodings = (general and general.position_encodings) or []
        folders = [one.uri for one in params.workspace_folders or ()]
        if not folders and params.root_uri:
            folders = [params.root_uri]
        self.pulls = _pulls(params.capabilities)
        self.refreshes = _refreshes(params.capabilities)
        self.rap = Workspace(
            types.PositionEncodingKind.Utf32 not in encodings, map(name_of, folders)
        )
        self.shows_callers = _flag(params.initialization_options, "showCallers")
        workspace = params.capabilities.workspace
        edits = workspace and workspace.workspace_edit
        self.rap.versions = bool(edits and edits.document_changes)
        self.worker = Worker(
            _delays(params.initialization_options),
            _passed(self._receive),
            _passed(self._receive_syntax),
            _passed(self._forget),
            _passed(self._log),
        )
        self.worker.start()
        self.worker.tell(self.rap.work())

    def opened(self, document: types.TextDocumentItem) -> None:
        """Add an open file."""
        name = self.rap.open(document.uri, document.text, document.version)
        self.worker.tell(self.rap.work(), aliases(name))

    def edited(self, params: types.DidChangeTextDocumentParams) -> None:
        """Apply edits to an open file."""
        name = name_of(params.text_document.uri)
        document = self.rap.documents[name]
        document.edit(params.content_changes, params.text_document.version)
        self.worker.tell(self.rap.work(), aliases(name), typed=True)

    def closed(self, uri: str) -> None:
        """Remove an open file."""
        name = self.rap.close(uri)
        self.worker.tell(self.rap.work(), aliases(name))

    # --- snapshots ----------------------------------------------------------------

    def _receive(self, snapshot: Snapshot) -> None:
        """Use a snapshot from now on, and send its findings to the client."""
        before = self.rap.snapshots.get(snapshot.spec)
        self.rap.receive(snapshot)
        names = files_with_findings(snapshot)
        self._publish(names if before is None else names | files_with_findings(before))
        self._arrival.set()
        self._arrival = asyncio.Event()
        if snapshot.whole:
            for method in self.refreshes:
                self.protocol.send_request(method, None)

    def _receive_syntax(self, read: Syntax) -> None:
        """Send the syntax errors of an edited file to the client."""
        self.rap.receive_syntax(read)
        if self.pulls:
            self.workspace_diagnostic_refresh(None)
        else:
            self._send(self.rap.uri(read.name))

    def _forget(self, gone: list[LibrarySpec]) -> None:
        """Remove the snapshots of libraries that are no longer there."""
        names: set[str] = set()
        for spec in gone:
            snapshot = self.rap.snapshots.pop(spec, None)
            if snapshot is not None:
                names |= files_with_findings(snapshot)
        self._publish(names)

    def _publish(self, names: set[str]) -> None:
        """Send the findings of files and of the open files to the client."""
        found = {self.rap.uri(name) for name in names}
        opened = {one.uri for one in self.rap.documents.values()}
        if self.pulls:
            found -= opened
            self.workspace_diagnostic_refresh(None)
        else:
            found |= opened
        for uri in sorted(found):
            self._send(uri, again=uri in opened)

    def _send(self, uri: str, *, again: bool = False) -> None:
        """Send the findings of a file to the client, if they have changed.

        Args:
            uri: the address of the file.
            again: whether to send the same findings again, for their version.
        """
        told = diagnostics(self.rap, uri)
        if again or told != self._published.get(uri, []):
            self._published[uri] = told
            version = self.rap.version(uri)
            params = types.PublishDiagnosticsParams(uri, told, version)
            self.text_document_publish_diagnostics(params)

    # --- requests -----------------------------------------------------------------

    def view(self, params: Any) -> View | None:
        """Return the latest snapshot with the file of a request."""
        return self.rap.view(params.text_document.uri)

    async def first_view(self, params: Any) -> View | None:
        """Return `view`; for an open file without a snapshot, wait for the first one.

        For requests that editors send when they open a file, and not again.
        """
        end = asyncio.get_running_loop().time() + _PATIENCE
        while True:
            found = self.view(params)
            left = end - asyncio.get_running_loop().time()
            if found is not None or left <= 0 or self.text(params) is None:
                return found
            with suppress(TimeoutError):
                await asyncio.wait_for(self._arrival.wait(), left)

    def text(self, params: Any) -> Text | None:
        """Return the text of the open RAP file of a request."""
        name = name_of(params.text_document.uri)
        document = self.rap.document(name) if name.endswith(SUFFIX) else None
        return None if document is None else document.text

    def _log(self, message: str) -> None:
        kind = types.MessageType.Warning
        self.window_log_message(types.LogMessageParams(kind, message))


def _passed(receive: Callable[[T], None]) -> Callable[[T], None]:
    """Return a function that calls `receive` in the event loop of the caller."""
    loop = asyncio.get_running_loop()

    def give(result: T) -> None:
        with suppress(RuntimeError):  # the loop is closed: the session is over
            loop.call_soon_threadsafe(receive, result)

    return give


def files_with_findings(snapshot: Snapshot) -> set[str]:
    """Return the names of the files that a snapshot has findings about."""
    return {*snapshot.findings, *snapshot.unreadable}


def _refreshes(client: types.ClientCapabilities) -> list[str]:
    """Return the requests to ask for hints again that a client supports."""
    workspace = client.workspace
    if workspace is None:
        return []
    known = {
        types.WORKSPACE_CODE_LENS_REFRESH: workspace.code_lens,
        types.WORKSPACE_INLAY_HINT_REFRESH: workspace.inlay_hint,
    }
    return [method for method, one in known.items() if one and one.refresh_support]


def _pulls(client: types.ClientCapabilities) -> bool:
    """Return whether a client requests diagnostics, and again after a refresh."""
    pulls = client.text_document is not None and client.text_document.diagnostic
    workspace = client.workspace
    told = workspace is not None and workspace.diagnostics
    return bool(pulls and told and told.refresh_support)


def _flag(options: object, name: str) -> bool:
    return isinstance(options, dict) and options.get(name) is True


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
    for add in (_add_texts, _add_names, _add_actions, _add_hints, _add_files):
        add(server)
    return server


def _add_texts(server: Server) -> None:
    """Add diagnostics, colours, formatting and the structure of files."""
    feature = server.feature

    @feature(
        types.TEXT_DOCUMENT_DIAGNOSTIC,
        types.DiagnosticOptions(
            inter_file_dependencies=True, workspace_diagnostics=False
        ),
    )
    def on_diagnostic(
        params: types.DocumentDiagnosticParams,
    ) -> types.RelatedFullDocumentDiagnosticReport:
        found = diagnostics(server.rap, params.text_document.uri)
        return types.RelatedFullDocumentDiagnosticReport(items=found)

    @feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, tokens.LEGEND)
    @server.thread()
    def on_tokens(params: types.SemanticTokensParams) -> types.SemanticTokens | None:
        text = server.text(params)
        return None if text is None else tokens.semantic_tokens(text)

    @feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE, tokens.LEGEND)
    @server.thread()
    def on_some_tokens(
        params: types.SemanticTokensRangeParams,
    ) -> types.SemanticTokens | None:
        text = server.text(params)
        rows = range(params.range.start.line, params.range.end.line + 1)
        return None if text is None else tokens.semantic_tokens(text, rows)

    @feature(types.TEXT_DOCUMENT_FORMATTING)
    @server.thread()
    def on_format(params: types.DocumentFormattingParams) -> list[types.TextEdit]:
        text = server.text(params)
        return [] if text is None else formatting.format_file(text)

    @feature(types.TEXT_DOCUMENT_RANGE_FORMATTING)
    @server.thread()
    def on_format_range(
        params: types.DocumentRangeFormattingParams,
    ) -> list[types.TextEdit]:
        text = server.text(params)
        return [] if text is None else formatting.format_range(text, params.range)

    @feature(
        types.TEXT_DOCUMENT_ON_TYPE_FORMATTING,
        types.DocumentOnTypeFormattingOptions("\n"),
    )
    def on_typed(
        params: types.DocumentOnTypeFormattingParams,
    ) -> list[types.TextEdit]:
        text = server.text(params)
        return [] if text is None else formatting.format_typed(text, params.position)

    @feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
    async def on_symbols(
        params: types.DocumentSymbolParams,
    ) -> list[types.DocumentSymbol]:
        view = await server.first_view(params)
        return [] if view is None else outline.document_symbols(view)

    @feature(types.WORKSPACE_SYMBOL)
    def on_workspace_symbols(
        params: types.WorkspaceSymbolParams,
    ) -> list[types.WorkspaceSymbol]:
        return outline.workspace_symbols(server.rap, params.query)

    @feature(types.TEXT_DOCUMENT_FOLDING_RANGE)
    async def on_folding(params: types.FoldingRangeParams) -> list[types.FoldingRange]:
        view = await server.first_view(params)
        return [] if view is None else outline.folding_ranges(view)

    @feature(types.TEXT_DOCUMENT_DOCUMENT_LINK)
    async def on_links(params: types.DocumentLinkParams) -> list[types.DocumentLink]:
        view = await server.first_view(params)
        return [] if view is None else navigation.links(view)


def _add_names(server: Server) -> None:
    """Add hover, definitions, uses, renaming and the hierarchy of calls."""
    feature = server.feature

    @feature(types.TEXT_DOCUMENT_HOVER)
    def on_hover(params: types.HoverParams) -> types.Hover | None:
        view = server.view(params)
        return None if view is None else hover(view, params.position)

    @feature(types.TEXT_DOCUMENT_DEFINITION)
    def on_definition(params: types.DefinitionParams) -> list[types.Location]:
        uri = params.text_document.uri
        if uri.endswith(".py"):
            return worlds.declarations(server.rap, uri, params.position)
        view = server.view(params)
        return [] if view is None else navigation.definition(view, params.position)

    @feature(types.TEXT_DOCUMENT_IMPLEMENTATION)
    def on_implementation(
        params: types.ImplementationParams,
    ) -> list[types.Location]:
        view = server.view(params)
        return [] if view is None else navigation.implementation(view, params.position)

    @feature(types.TEXT_DOCUMENT_REFERENCES)
    async def on_references(params: types.ReferenceParams) -> list[types.Location]:
        view = server.view(params)
        wanted = params.context.include_declaration
        if view is None:
            return []
        return await navigation.references(view, params.position, wanted)

    @feature(types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT)
    def on_highlight(
        params: types.DocumentHighlightParams,
    ) -> list[types.DocumentHighlight]:
        view = server.view(params)
        return [] if view is None else navigation.highlights(view, params.position)

    @feature(types.TEXT_DOCUMENT_PREPARE_RENAME)
    def on_prepare_rename(
        params: types.PrepareRenameParams,
    ) -> types.PrepareRenamePlaceholder | None:
        view = server.view(params)
        return (
            None if view is None else navigation.prepare_rename(view, params.position)
        )

    @feature(types.TEXT_DOCUMENT_RENAME, types.RenameOptions(prepare_provider=True))
    async def on_rename(params: types.RenameParams) -> types.WorkspaceEdit | None:
        view = server.view(params)
        if view is None:
            return None
        return await navigation.rename(view, params.position, params.new_name)

    @feature(types.TEXT_DOCUMENT_PREPARE_CALL_HIERARCHY)
    def on_calls(
        params: types.CallHierarchyPrepareParams,
    ) -> list[types.CallHierarchyItem]:
        view = server.view(params)
        return [] if view is None else navigation.prepare_calls(view, params.position)

    @feature(types.CALL_HIERARCHY_INCOMING_CALLS)
    def on_incoming(
        params: types.CallHierarchyIncomingCallsParams,
    ) -> list[types.CallHierarchyIncomingCall]:
        view = server.rap.view(params.item.uri)
        return [] if view is None else navigation.incoming(view, params.item.name)

    @feature(types.CALL_HIERARCHY_OUTGOING_CALLS)
    def on_outgoing(
        params: types.CallHierarchyOutgoingCallsParams,
    ) -> list[types.CallHierarchyOutgoingCall]:
        view = server.rap.view(params.item.uri)
        return [] if view is None else navigation.outgoing(view, params.item.name)


def _add_actions(server: Server) -> None:
    """Add code actions and commands."""
    kinds = types.CodeActionKind
    offered = [kinds.QuickFix, kinds.RefactorExtract, kinds.RefactorInline]

    @server.feature(
        types.TEXT_DOCUMENT_CODE_ACTION,
        types.CodeActionOptions([*offered, kinds.SourceFixAll]),
    )
    def on_actions(params: types.CodeActionParams) -> list[types.CodeAction]:
        view = server.view(params)
        wanted = params.context.only
        return [] if view is None else actions.actions(view, params.range, wanted)

    @server.command(actions.FIX_ALL)
    async def on_fix_all(uri: str) -> None:
        await commands.fix_all(server, server.rap, uri)

    @server.command(hints.RUN_TESTS)
    async def on_run_tests(uri: str, name: str) -> bool:
        return await commands.run_test(server, server.rap, uri, name)

    @server.command(hints.RUN_AGENDA)
    async def on_run_agenda(uri: str, agenda: str, world: str) -> bool:
        return await commands.run_agenda(server, server.rap, uri, agenda, world)


def _add_hints(server: Server) -> None:
    """Add completion, signatures, hints and lenses."""

    @server.feature(
        types.TEXT_DOCUMENT_COMPLETION,
        types.CompletionOptions(trigger_characters=["(", "?", ":", '"']),
    )
    def on_completion(params: types.CompletionParams) -> types.CompletionList:
        view = server.view(params)
        found = [] if view is None else completions(view, params.position)
        return types.CompletionList(len(found) >= MOST, found)

    @server.feature(
        types.TEXT_DOCUMENT_SIGNATURE_HELP,
        types.SignatureHelpOptions(trigger_characters=[" ", "("]),
    )
    def on_signature(params: types.SignatureHelpParams) -> types.SignatureHelp | None:
        view = server.view(params)
        return None if view is None else hints.signature_help(view, params.position)

    @server.feature(types.TEXT_DOCUMENT_INLAY_HINT)
    async def on_hints(params: types.InlayHintParams) -> list[types.InlayHint]:
        view = await server.first_view(params)
        if view is None:
            return []
        start, end = view.then(params.range.start), view.then(params.range.end)
        return hints.inlay_hints(view, start, end)

    @server.feature(types.TEXT_DOCUMENT_CODE_LENS)
    async def on_lenses(params: types.CodeLensParams) -> list[types.CodeLens]:
        view = await server.first_view(params)
        return [] if view is None else hints.lenses(view, server.shows_callers)


def _add_files(server: Server) -> None:
    """Add changes of files and folders outside of the editor."""

    @server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def on_files(params: types.DidChangeWatchedFilesParams) -> None:
        server.worker.tell(server.rap.work())

    @server.feature(types.TEXT_DOCUMENT_DID_SAVE)
    def on_save(params: types.DidSaveTextDocumentParams) -> None:
        name = name_of(params.text_document.uri)
        server.worker.tell(server.rap.work(), aliases(name))

    @server.feature(types.WORKSPACE_DID_CHANGE_WORKSPACE_FOLDERS)
    def on_folders(params: types.DidChangeWorkspaceFoldersParams) -> None:
        gone = {name_of(one.uri) for one in params.event.removed}
        added = [name_of(one.uri) for one in params.event.added]
        kept = [one for one in server.rap.folders if one not in gone]
        server.rap.folders = [*kept, *added]
        server.worker.tell(server.rap.work())

    @server.feature(types.INITIALIZED)
    def on_initialized(params: types.InitializedParams) -> None:
        client = server.client_capabilities.workspace
        watched = client is not None and client.did_change_watched_files
        if not (watched and watched.dynamic_registration):
            return
        patterns = ("**/*.rap", "**/rapc.toml", "**/pyproject.toml")
        options = types.DidChangeWatchedFilesRegistrationOptions(
            [types.FileSystemWatcher(one) for one in patterns]
        )
        method = types.WORKSPACE_DID_CHANGE_WATCHED_FILES
        registration = types.Registration("files", method, options)
        server.client_register_capability(types.RegistrationParams([registration]))


def is_fault(record: logging.LogRecord) -> bool:
    """Return whether a record is to be logged: a refused request is no fault."""
    error = record.exc_info[1] if record.exc_info else None
    return not isinstance(error, navigation.RefusedRequestError)


def serve() -> None:
    """Serve the editor on standard input and output until it ends the session.

    Ctrl-C ends the process at once, by the system's default.
    """
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    logging.getLogger("pygls.protocol.json_rpc").addFilter(is_fault)
    sys.setswitchinterval(0.0002)  # requests do not wait long for the worker
    with os.fdopen(os.dup(1), "wb") as output:
        os.dup2(2, 1)  # what is printed by mistake must not reach the editor
        server = make_server()
        server.protocol.set_writer(StdoutWriter(output))
        # `sys.exit` at the end of the session, or the editor has ended
        with suppress(SystemExit, BrokenPipeError):
            asyncio.run(server.read(0))
