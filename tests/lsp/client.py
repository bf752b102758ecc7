"""A client of the language server, whose calls wait for the answer.

The client and the server's process live in an event loop of their own thread.
"""

from __future__ import annotations

import asyncio
import sys
import threading
from collections.abc import Coroutine, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("pytest_lsp", reason="pytest-lsp is not installed")

from lsprotocol import types
from pytest_lsp import client_capabilities, make_test_lsp_client

PATIENCE = 60.0
"""How many seconds an answer may take."""

NOW = {"errorDelay": 0, "delay": 0}
"""The options of a server that checks at once."""


class Editor:
    """An editor with some folders; the client of pytest-lsp without `await`."""

    def __init__(
        self,
        *folders: Path,
        like: str = "emacs",
        options: Mapping[str, Any] | None = None,
        encodings: list[types.PositionEncodingKind] | None = None,
    ) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        #: `LanguageClient` has no types for all of its methods.
        self.client: Any = make_test_lsp_client()
        self.folders = folders
        self.capabilities = client_capabilities(like)
        self.client.capabilities = self.capabilities
        if encodings is not None:
            general = self.capabilities.general or types.GeneralClientCapabilities()
            general.position_encodings = encodings
            self.capabilities.general = general
        self._published = threading.Condition()
        #: The version of each file whose findings were published last.
        self._told: dict[str, int | None] = {}
        #: The edits that the server has asked for.
        self.applied: list[types.WorkspaceEdit] = []
        self._versions: dict[str, int] = {}
        self.texts: dict[str, str] = {}
        self._listen()
        command = [sys.executable, "-m", "rapc", "lsp"]
        self.wait(self.client.start_io(*command))
        self.server = self.ask(
            types.INITIALIZE,
            types.InitializeParams(
                capabilities=self.capabilities,
                workspace_folders=[
                    types.WorkspaceFolder(one.as_uri(), one.name) for one in folders
                ],
                initialization_options=NOW if options is None else options,
            ),
        )
        self.tell(types.INITIALIZED, types.InitializedParams())

    def _listen(self) -> None:
        published = self.client.protocol.fm.features.pop(
            types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS, None
        )
        assert published is not None

        def publish(params: types.PublishDiagnosticsParams) -> None:
            with self._published:
                self.client.diagnostics[params.uri] = params.diagnostics
                self._told[params.uri] = params.version
                self._published.notify_all()

        self.client.feature(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)(publish)

        def apply(
            params: types.ApplyWorkspaceEditParams,
        ) -> types.ApplyWorkspaceEditResult:
            self.applied.append(params.edit)
            return types.ApplyWorkspaceEditResult(applied=True)

        self.client.feature(types.WORKSPACE_APPLY_EDIT)(apply)
        self.client.feature(types.CLIENT_REGISTER_CAPABILITY)(lambda params: None)

    def wait(self, work: Coroutine[Any, Any, Any]) -> Any:
        """Run a coroutine to its end."""
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(PATIENCE)

    def ask(self, method: str, params: Any) -> Any:
        """Send a request and return the answer."""
        return self.wait(self.client.protocol.send_request_async(method, params))

    def tell(self, method: str, params: Any) -> None:
        """Send a notification."""

        async def send() -> None:
            self.client.protocol.notify(method, params)

        self.wait(send())

    def close(self) -> int | None:
        """End the session; return the exit status of the server."""
        self.ask(types.SHUTDOWN, None)
        self.tell(types.EXIT, None)
        server = self.client._server
        assert server is not None
        status = self.wait(server.wait())
        self.wait(self.client.stop())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(PATIENCE)
        self._loop.close()
        return int(status)

    # --- files ----------------------------------------------------------------------

    def open(self, file: Path, text: str | None = None) -> str:
        """Open a file and return its address."""
        uri = file.as_uri()
        self.texts[uri] = file.read_text() if text is None else text
        self._versions[uri] = self._versions.get(uri, 0) + 1
        version = self._versions[uri]
        item = types.TextDocumentItem(uri, "rap", version, self.texts[uri])
        self.tell(types.TEXT_DOCUMENT_DID_OPEN, types.DidOpenTextDocumentParams(item))
        return uri

    def shut(self, uri: str) -> None:
        """Close a file."""
        document = types.TextDocumentIdentifier(uri)
        self.tell(
            types.TEXT_DOCUMENT_DID_CLOSE, types.DidCloseTextDocumentParams(document)
        )
        del self.texts[uri]

    def edit(self, uri: str, old: str, new: str) -> None:
        """Replace the first occurrence of a text in an open file."""
        start = self.texts[uri].index(old)
        self.change(uri, start, start + len(old), new)

    def change(self, uri: str, start: int, end: int, new: str) -> None:
        """Replace the text between two offsets of an open file."""
        place = types.Range(self.at(uri, start), self.at(uri, end))
        text = self.texts[uri]
        self.texts[uri] = f"{text[:start]}{new}{text[end:]}"
        self._change(uri, types.TextDocumentContentChangePartial(place, new))

    def replace(self, uri: str, text: str) -> None:
        """Replace the whole text of an open file."""
        self.texts[uri] = text
        self._change(uri, types.TextDocumentContentChangeWholeDocument(text))

    def _change(self, uri: str, change: types.TextDocumentContentChangeEvent) -> None:
        self._versions[uri] += 1
        document = types.VersionedTextDocumentIdentifier(self._versions[uri], uri)
        self.tell(
            types.TEXT_DOCUMENT_DID_CHANGE,
            types.DidChangeTextDocumentParams(document, [change]),
        )

    # --- places ---------------------------------------------------------------------

    def at(self, uri: str, offset: int) -> types.Position:
        """Return the position of an offset of an open file."""
        before = self.texts[uri][:offset]
        line = before.rpartition("\n")[2]
        units = len(line.encode("utf-16-le")) // 2
        encoding = self.server.capabilities.position_encoding
        wide = encoding == types.PositionEncodingKind.Utf16
        return types.Position(before.count("\n"), units if wide else len(line))

    def of(self, uri: str, text: str, occurrence: int = 0) -> dict[str, Any]:
        """Return the document and the position of a text, as arguments of requests."""
        at = -1
        for _ in range(occurrence + 1):
            at = self.texts[uri].index(text, at + 1)
        return {
            "text_document": types.TextDocumentIdentifier(uri),
            "position": self.at(uri, at),
        }

    # --- findings -------------------------------------------------------------------

    def findings(self, uri: str) -> list[str]:
        """Return the rules of the findings of the present text of an open file."""

        with self._published:
            if not self._published.wait_for(partial(self.is_checked, uri), PATIENCE):
                raise TimeoutError(f"the findings are {self.rules(uri)}")
            return self.rules(uri)

    def is_checked(self, uri: str) -> bool:
        """Return whether the findings of the present text of an open file are there."""
        return self._told.get(uri) == self._versions[uri]

    def until(self, uri: str, rule: str | None) -> None:
        """Wait for published findings of a file with a rule; without, for none."""

        def ready() -> bool:
            rules = self.rules(uri)
            return rule in rules if rule else uri in self._told and not rules

        with self._published:
            if not self._published.wait_for(ready, PATIENCE):
                raise TimeoutError(f"the findings are {self.rules(uri)}")

    def expect(self, uri: str, expected: Sequence[tuple[str, str]]) -> None:
        """Wait for published findings of a file: sorted rules with messages.

        Edits of other files may change the findings of a file whose text is the same.
        """

        def found() -> list[tuple[str, str]]:
            there = self.client.diagnostics.get(uri, ())
            return sorted((str(o.code), o.message.partition("\n")[0]) for o in there)

        with self._published:
            if not self._published.wait_for(lambda: found() == expected, PATIENCE):
                raise TimeoutError(f"the findings are {found()}, not {expected}")

    def messages(self, uri: str) -> list[str]:
        """Return the messages about a file that is not open, once there are some."""
        with self._published:
            if not self._published.wait_for(lambda: uri in self._told, PATIENCE):
                raise TimeoutError(f"no findings of {uri}")
            return [one.message for one in self.client.diagnostics[uri]]

    def rules(self, uri: str) -> list[str]:
        """Return the rules of the last findings of a file."""
        return [str(one.code) for one in self.client.diagnostics.get(uri, ())]
