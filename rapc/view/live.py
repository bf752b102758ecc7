"""The page of a run that goes on, served on loopback.

The thread of the run only keeps lines. Each reader has a thread that sends
the lines from the start of the run, so neither many nor slow readers slow the run.
Requests of readers go to the control of the run (`rapc.view.control`).
"""

from __future__ import annotations

import secrets
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Event, Thread
from typing import Any

import msgspec

from rapc.base.decoding import UNREADABLE
from rapc.runtime.events.trace import Writable
from rapc.view.control import Control

HOST = "127.0.0.1"
_PAUSE = 0.1
"""The seconds after which a reader looks for new lines."""

_BLOCK = 64
"""The number of lines in a block."""

_MOST = 8
"""The highest number of blocks in a message to a reader."""

_LONGEST = 20_000
"""The highest number of bytes of a request."""


class Feed:
    """A stream that keeps the lines of a trace for readers.

    The lines are joined to blocks: a block costs the thread of the run, and those of
    readers, hardly more than a line.

    Args:
        trace: another stream that gets the blocks.
    """

    def __init__(self, trace: Writable | None = None) -> None:
        self._trace = trace
        #: The blocks of `_BLOCK` lines, and the lines of the next block.
        self._blocks: list[str] = []
        self._lines: list[str] = []
        self.ended = Event()

    def write(self, line: str) -> None:
        """Keep the next line."""
        lines = self._lines
        lines.append(line)
        if len(lines) == _BLOCK:
            self._lines = []
            block = "".join(lines)
            self._blocks.append(block)
            if self._trace is not None:
                self._trace.write(block)

    def end(self) -> None:
        """Write the last lines to the trace; no further lines follow."""
        if self._trace is not None:
            self._trace.write("".join(self._lines))
        self.ended.set()

    def after(self, at: int) -> tuple[int, str]:
        """Return some lines after the first `at` lines, and the number of all these."""
        block, skipped = divmod(at, _BLOCK)
        blocks = self._blocks[block : block + _MOST]
        if blocks:
            if skipped:
                blocks[0] = "".join(blocks[0].splitlines(keepends=True)[skipped:])
            return (block + len(blocks)) * _BLOCK, "".join(blocks)
        # The last line of a block comes with the block: until then, a reader that had
        # the line would get the same lines again, as those of the next block.
        lines = self._lines[skipped : _BLOCK - 1]
        if len(self._blocks) > block:  # the lines may be those of a later block
            return self.after(at)
        return at + len(lines), "".join(lines)


_json = msgspec.json.encode


class Request(msgspec.Struct, frozen=True):
    """A request of a reader; see `Control.ask`."""

    name: str
    text: str = ""


class Live(ThreadingHTTPServer):
    """A server of the page of one run, and of its events.

    Args:
        page: the page; see `rapc.view.page.live_page`.
        port: the port; 0 for any free port.
        control: the control of the run; without it, readers only watch.
        trace: a stream that gets the trace of the run, too.

    Raises:
        OSError: if the port cannot be used.
    """

    def __init__(
        self,
        page: str,
        port: int = 0,
        control: Control | None = None,
        trace: Writable | None = None,
    ) -> None:
        super().__init__((HOST, port), _Handler)
        self.page, self.feed, self.control = page.encode(), Feed(trace), control
        self.token = secrets.token_urlsafe(24)
        self.hosts = {f"{name}:{self.server_port}" for name in (HOST, "localhost")}
        Thread(target=self.serve_forever, daemon=True).start()

    @property
    def address(self) -> str:
        """Return the address of the page, with its token."""
        return f"http://{HOST}:{self.server_port}/{self.token}/"

    def close(self) -> None:
        """Stop the server."""
        self.feed.ended.set()
        self.shutdown()
        self.server_close()


class _Handler(BaseHTTPRequestHandler):
    """The answers to one reader."""

    server: Live

    def do_GET(self) -> None:
        """Send the page or the events; without the token and the host, nothing."""
        name = self._name()
        try:
            if name == "events":
                self._send_events()
            elif name == "":
                self._begin("text/html; charset=utf-8")
                self.wfile.write(self.server.page)
            else:
                self.send_error(HTTPStatus.NOT_FOUND)
        except ConnectionError:
            self.close_connection = True  # the reader has gone

    def do_POST(self) -> None:
        """Carry out a request; without the token and the host, nothing."""
        size = self.headers.get("Content-Length", "")
        length = int(size) if size.isascii() and size.isdigit() else 0
        data = self.rfile.read(min(length, _LONGEST))
        control = self.server.control
        if self._name() != "control" or control is None:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        try:
            asked = msgspec.json.decode(data, type=Request)
        except UNREADABLE:
            self.send_error(HTTPStatus.BAD_REQUEST)
            return
        answer = control.ask(asked.name, asked.text)
        told = {"failed": answer.failed, "said": "; ".join(answer.lines)}
        try:
            self._begin("application/json")
            self.wfile.write(_json(told))
        except ConnectionError:
            self.close_connection = True

    def _name(self) -> str | None:
        """Return the path after the token; None without the token and the host."""
        _, _, rest = self.path.partition("/")
        token, _, name = rest.partition("/")
        known = secrets.compare_digest(token.encode(), self.server.token.encode())
        host = self.headers.get("Host", "")
        return name if known and host in self.server.hosts else None

    def _begin(self, kind: str) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Cache-Control", "no-store")
        self.send_header("Referrer-Policy", "no-referrer")
        self.end_headers()

    def _send_events(self) -> None:
        """Send the events after the last one that the reader has, until the end."""
        last = self.headers.get("Last-Event-ID", "")
        at = int(last) if last.isascii() and last.isdigit() else 0
        feed, control = self.server.feed, self.server.control
        told = None
        self._begin("text/event-stream; charset=utf-8")
        while True:
            ended, status = feed.ended.is_set(), control and control.status
            at, lines = feed.after(at)
            if status is not told:
                told = status
                self.wfile.write(b"event: status\ndata: %b\n\n" % _json(status))
            if lines:
                data = lines[:-1].encode().replace(b"\n", b"\ndata: ")
                self.wfile.write(b"id: %d\ndata: %b\n\n" % (at, data))
            elif ended:
                self.wfile.write(b"event: end\ndata:\n\n")
                return
            else:
                feed.ended.wait(_PAUSE)

    def log_message(self, *_: Any) -> None:
        """Write no log: requests are text of strangers."""
