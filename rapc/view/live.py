"""The page of a run that goes on, served on loopback.

The thread of the run only appends lines to a list. Each reader has a thread that sends
the lines from the start of the run, so neither many nor slow readers slow the run.
"""

from __future__ import annotations

import secrets
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Event, Thread
from typing import Any

HOST = "127.0.0.1"
_PAUSE = 0.1
"""The seconds after which a reader looks for new lines."""

_MOST = 5_000
"""The number of lines in a message to a reader."""


class Feed:
    """A stream that keeps the lines of a trace for readers."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.ended = Event()
        #: As an attribute: the run calls it for each event.
        self.write = self.lines.append


class Live(ThreadingHTTPServer):
    """A server of the page of one run, and of its events.

    Args:
        page: the page; see `rapc.view.page.live_page`.
        port: the port; 0 for any free port.

    Raises:
        OSError: if the port cannot be used.
    """

    def __init__(self, page: str, port: int = 0) -> None:
        super().__init__((HOST, port), _Handler)
        self.page, self.feed = page.encode(), Feed()
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
        _, _, rest = self.path.partition("/")
        token, _, name = rest.partition("/")
        known = secrets.compare_digest(token.encode(), self.server.token.encode())
        host = self.headers.get("Host", "")
        if not known or host not in self.server.hosts or name not in {"", "events"}:
            self.send_error(HTTPStatus.NOT_FOUND)
            return
        try:
            if name:
                self._send_events()
            else:
                self._begin("text/html; charset=utf-8")
                self.wfile.write(self.server.page)
        except ConnectionError:
            self.close_connection = True  # the reader has gone

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
        feed = self.server.feed
        self._begin("text/event-stream; charset=utf-8")
        while True:
            ended = feed.ended.is_set()
            lines = feed.lines[at : at + _MOST]
            at += len(lines)
            if lines:
                text = "".join(f"data: {line}" for line in lines)
                self.wfile.write(f"id: {at}\n{text}\n".encode())
            elif ended:
                self.wfile.write(b"event: end\ndata:\n\n")
                return
            else:
                feed.ended.wait(_PAUSE)

    def log_message(self, *_: Any) -> None:
        """Write no log: requests are text of strangers."""
