"""The connection to a peer: a process or a socket that carries JSON lines.

A peer is not trusted. Whatever it sends or leaves out, a call returns a result or
raises `PortError`, with one line that names the peer and the method.
"""

from __future__ import annotations

import os
import select
import shlex
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

import msgspec

from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.visible import visible
from rapc.errors import PortError, reason
from rapc.worlds.remote.protocol import LINE_LIMIT, METHODS, TOKEN, Call, Response

TIMEOUT = 10.0
"""The default limit in seconds for an answer."""

_LOCAL = ("127.0.0.1", "localhost", "[::1]")
_GRACE = 2.0
"""The seconds that a process gets to end, and an interrupted call to be answered."""
_MOST_NOTICES = 100_000
"""The highest number of notifications of a peer during a call."""
_CHUNK = 2**18
_STDERR_KEPT = 4096
_STDERR_LINES = 3
_MOST_SHOWN = 400

_BEAT = msgspec.json.encode(Call("heartbeat", jsonrpc="2.0")) + b"\n"
_RESPONSE = msgspec.json.Decoder(Response)
_RESULTS: Mapping[str, msgspec.json.Decoder[Any]] = {
    name: msgspec.json.Decoder(types[1]) for name, types in METHODS.items()
}
_ENCODER = msgspec.json.Encoder()


class RefusedCall(PortError):
    """A call that the peer has answered with an error; `said` is its message."""

    def __init__(self, message: str, said: str) -> None:
        super().__init__(message)
        self.said = said


class Peer:
    """A connection to a peer.

    Args:
        address: `exec:COMMAND`, `unix:/path` or `tcp:127.0.0.1:PORT`.

    Raises:
        PortError: for an invalid address, or if the connection fails.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        #: The limit in seconds for an answer, by method.
        self.timeouts: Mapping[str, float] = {}
        #: The seconds between two heartbeats during a wait; None: no heartbeats.
        self.beat: float | None = None
        #: Takes the result of a call that Ctrl-C has interrupted: method and result.
        self.late: Callable[[str, Any], None] = lambda method, result: None
        #: Whether an error has ended the connection.
        self.broken = False
        self._owner = os.getpid()
        self._calls = 0
        self._interrupted: dict[int, str] = {}
        self._unsent = bytearray()
        self._written = 0.0
        self._read = bytearray()
        self._seen = 0
        self._stderr, self._stderr_open = b"", True
        self._process: subprocess.Popen[bytes] | None = None
        self._socket: socket.socket | None = None
        kind, _, rest = address.partition(":")
        try:
            if kind == "exec":
                self._start()
            elif kind == "unix":
                self._connect(socket.AF_UNIX, rest)
            else:
                self._connect(*_loopback(address))
        except OSError as error:
            raise PortError(
                f"cannot reach the peer `{address}`: {reason(error)}"
            ) from error
        for fd in (self._in, self._out):
            os.set_blocking(fd, False)
        self._poll = select.poll()
        self._poll.register(self._in, select.POLLIN)
        if self._process is not None and self._process.stderr is not None:
            self._poll.register(self._process.stderr.fileno(), select.POLLIN)

    def _start(self) -> None:
        """Start the process of the command; Ctrl-C does not reach it."""
        words = words_of(self.address)
        if not words:
            raise PortError(f"the address `{self.address}` has no command")
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(  # noqa: S603  # the user's own command
            words, stdin=pipe, stdout=pipe, stderr=pipe, process_group=0, bufsize=0
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._in = self._process.stdout.fileno()
        self._out = self._process.stdin.fileno()

    def _connect(self, family: int, place: Any) -> None:
        self._socket = made = socket.socket(family, socket.SOCK_STREAM)
        try:
            made.settimeout(TIMEOUT)
            made.connect(place)
        except OSError:
            made.close()
            raise
        if family != socket.AF_UNIX:
            made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._in = self._out = made.fileno()

    # --- calls ------------------------------------------------------------------------

    def call(self, method: str, params: msgspec.Struct) -> Any:
        """Call a method; return the result, of its type in `METHODS`.

        Raises:
            PortError: for everything that the peer does wrong.
            RefusedCall: if the peer answers with an error.
        """
        if self.broken:
            raise PortError(f"the peer `{self.address}` has ended before `{method}`")
        self._calls += 1
        number = self._calls
        call = Call(method, params, number, "2.0")
        limit = self.timeouts.get(method, TIMEOUT)
        if self._interrupted:
            limit = min(limit, _GRACE)
        notices = 0
        try:
            self._write(_ENCODER.encode(call) + b"\n", method, limit)
            ends = time.monotonic() + limit
            while True:
                line = self._line(method, limit, ends)
                invalid = f"sent an invalid line instead of an answer to `{method}`"
                response = self._decoded(_RESPONSE, line, invalid)
                if response.method is not None:
                    notices += 1
                    if notices > _MOST_NOTICES:
                        said = f"more than {_MOST_NOTICES} notifications"
                        self._fail(f"sent {said} during `{method}`")
                    ends = time.monotonic() + limit
                elif response.id == number:
                    break
                elif response.id in self._interrupted:
                    self._take_late(self._interrupted.pop(response.id), response)
                else:
                    found = "no id" if response.id is None else f"id {response.id}"
                    said = f"answered `{method}` with {found} instead of id {number}"
                    self._fail(said)
        except KeyboardInterrupt:
            self._interrupted[number] = method
            raise
        if response.error is not None:
            said = _short(response.error.message)
            raise RefusedCall(
                f"the peer `{self.address}` failed in `{method}`: {said}", said
            )
        return self._result(method, response)

    def _result(self, method: str, response: Response) -> Any:
        invalid = f"sent an invalid answer to `{method}`"
        return self._decoded(_RESULTS[method], response.result, invalid)

    def _take_late(self, method: str, response: Response) -> None:
        """Pass on the result of an interrupted call."""
        if response.error is None:
            self.late(method, self._result(method, response))

    def _decoded(
        self, decoder: msgspec.json.Decoder[Any], text: Any, invalid: str
    ) -> Any:
        """Return decoded JSON; else fail, as `invalid` says."""
        try:
            return decoder.decode(text)
        except UNREADABLE as error:
            self._fail(f"{invalid}: {_short(flaw(error))}")

    def _write(self, line: bytes, method: str, limit: float) -> None:
        """Write a line; read meanwhile, so that the peer can write, too."""
        self._written = time.monotonic()
        ends = self._written + limit
        unsent = self._unsent  # with the rest of a line that Ctrl-C has interrupted
        unsent += line
        while unsent:
            try:
                del unsent[: os.write(self._out, unsent)]
                continue
            except BlockingIOError:
                pass
            except OSError:
                self._closed(
                    f"closed its input before `{method}`", f"before `{method}`"
                )
            if time.monotonic() > ends:
                self._fail(f"does not read: cannot send `{method}` in {limit:g} s")
            writing = select.poll()
            if self._in == self._out:
                writing.register(self._out, select.POLLOUT | select.POLLIN)
            else:
                writing.register(self._out, select.POLLOUT)
                writing.register(self._in, select.POLLIN)
            for fd, events in writing.poll(_milliseconds(ends)):
                if fd == self._in and events & select.POLLIN:
                    self._receive(method)

    def _line(self, method: str, limit: float, ends: float) -> bytes:
        """Return the next line of the peer; send heartbeats during the wait."""
        while (end := self._read.find(b"\n", self._seen)) < 0:
            self._seen = len(self._read)
            now = time.monotonic()
            if now >= ends:
                half = " (the answer has no end of line)" if self._read else ""
                self._fail(f"gave no answer to `{method}` in {limit:g} s{half}")
            until = ends
            if self.beat is not None:
                if now >= self._written + self.beat:
                    self._write(_BEAT, method, limit)
                until = min(ends, self._written + self.beat)
            for fd, _ in self._poll.poll(_milliseconds(until)):
                if fd == self._in:
                    self._receive(method)
                else:
                    self._read_stderr(fd)
        line = bytes(self._read[:end])
        del self._read[: end + 1]
        self._seen = 0
        return line

    def _receive(self, method: str) -> None:
        """Read what the peer has sent. Raises PortError at the end of the stream."""
        try:
            found = os.read(self._in, _CHUNK)
        except BlockingIOError:
            return
        except OSError:
            found = b""
        if found:
            self._read += found
            if len(self._read) > LINE_LIMIT + _CHUNK:
                self._fail(f"sent more than {LINE_LIMIT} bytes in answer to `{method}`")
            return
        whole = "instead of answering" if not self._read else "in its answer to"
        self._closed(f"closed its output {whole} `{method}`", f"{whole} `{method}`")

    # --- the end ------------------------------------------------------------------

    def _closed(self, still: str, ended: str) -> NoReturn:
        """Fail, with the status of the process if it has ended."""
        status = None
        if self._process is not None:
            try:
                status = self._process.wait(1)
            except subprocess.TimeoutExpired:
                self._fail(still)
        if status is None:
            self._fail(f"closed the connection {ended}")
        what = f"with status {status}" if status >= 0 else f"by {_signal(-status)}"
        self._fail(f"ended {what} {ended}")

    def _fail(self, said: str) -> NoReturn:
        """End the connection. Raises PortError with the last lines of stderr."""
        process = self._process
        if process is not None and process.stderr is not None:
            os.set_blocking(process.stderr.fileno(), False)
            while self._read_stderr(process.stderr.fileno()):
                pass
        lines = self._stderr.decode(errors="replace").strip().splitlines()
        last = " | ".join(visible(line.strip()) for line in lines[-_STDERR_LINES:])
        more = f"; its last lines: {last[-_MOST_SHOWN:]}" if last else ""
        self.close()
        raise PortError(f"the peer `{self.address}` {said}{more}")

    def _read_stderr(self, fd: int) -> bool:
        """Keep the end of what the process wrote; return whether it may write more."""
        try:
            found = os.read(fd, _CHUNK)
        except BlockingIOError:
            return False
        if not found and self._stderr_open:
            self._poll.unregister(fd)
            self._stderr_open = False
        self._stderr = (self._stderr + found)[-_STDERR_KEPT:]
        return bool(found)

    def close(self) -> None:
        """End the connection; a process gets some time to end by itself."""
        if self.broken or os.getpid() != self._owner:
            return
        self.broken = True
        if self._socket is not None:
            self._socket.close()
        process = self._process
        if process is None:
            return
        for pipe in (process.stdin, process.stdout, process.stderr):
            if pipe is not None:
                pipe.close()
        try:
            process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def words_of(address: str) -> list[str]:
    """Return the words of the command in an address; empty for a socket.

    Raises:
        PortError: for a command with an unclosed quotation.
    """
    kind, _, command = address.partition(":")
    try:
        return shlex.split(command) if kind == "exec" else []
    except ValueError as error:
        said = f"{error}".lower()
        raise PortError(
            f"cannot read the command of the peer `{address}`: {said}"
        ) from error


def _loopback(address: str) -> tuple[int, tuple[str, int]]:
    """Return the family and the place of a TCP address of this computer."""
    host, _, port = address.removeprefix("tcp:").rpartition(":")
    if host not in _LOCAL or not port.isdecimal() or not 0 < int(port) < 2**16:
        wanted = "tcp:127.0.0.1:PORT"
        raise PortError(f"the address `{address}` is not of the form `{wanted}`")
    if not os.environ.get(TOKEN):
        raise PortError(f"the peer `{address}` requires a token in `{TOKEN}`")
    family = socket.AF_INET6 if host == "[::1]" else socket.AF_INET
    return family, (host.strip("[]"), int(port))


def _short(text: str) -> str:
    """Return a text of a peer as one line of at most 400 characters."""
    line = visible(" ".join(text.split()))
    return line if len(line) <= _MOST_SHOWN else f"{line[:_MOST_SHOWN]}..."


def _signal(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _milliseconds(until: float) -> int:
    return max(0, int((until - time.monotonic()) * 1000) + 1)
