"""The other end of the wire: a Python world as a peer.

`serve` answers calls on standard input. If the world has a method `halt`, a watchdog
calls `halt` in a thread of its own when the interpreter has sent nothing for `PERIOD`
seconds after the first request, or has closed the connection. `halt` stops the body; a
world reports the halt like other events of its threads, by a message. At the end of a
connection the server calls `close`, if the world has this method and cannot resume.
"""

from __future__ import annotations

import base64
import hmac
import inspect
import os
import queue
import random
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import msgspec

from rapc.base.chance import stream_in
from rapc.base.code_places import place_of_error, said_by
from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.values import Text
from rapc.base.watchdog import PERIOD, TICK, Watchdog
from rapc.world import (
    NOT_KNOWN,
    Adjustable,
    Datum,
    Drawable,
    Finished,
    Kit,
    Measured,
    Message,
    Refused,
    Reply,
    Resumable,
    Savable,
    Signal,
    Skilled,
    Time,
    Timed,
    Truth,
    World,
)
from rapc.worlds.registry import plain_values
from rapc.worlds.remote import protocol
from rapc.worlds.remote.protocol import (
    LINE_LIMIT,
    METHODS,
    PROTOCOL,
    TOKEN,
    Call,
    Description,
)

_ALIVE = 2.0
"""The seconds of a long call between two notifications `alive`."""
_ENDING = 5.0
"""The seconds that `resume` waits for the end of the last connection."""
_GRACE = 1.0
"""The seconds that a call may take after the end of standard input."""

_OFFERS: tuple[tuple[type, tuple[Any, ...]], ...] = (
    (Skilled, ("activate", "deactivate")),
    (Timed, ("usual-time",)),
    (Drawable, ("picture",)),
    (Measured, ("figures",)),
    (Truth, ("truth",)),
    (Savable, ("save", "restore")),
    (Resumable, ("resume",)),
    (Adjustable, ("adjustable", "adjust")),
)
"""The optional methods of the protocol, by the protocols of worlds."""

_PARAMS: Mapping[str, msgspec.json.Decoder[Any]] = {
    name: msgspec.json.Decoder(types[0]) for name, types in METHODS.items()
}


class _Line(msgspec.Struct, frozen=True):
    """A call whose parameters are not read yet, or a notification."""

    method: str
    params: msgspec.Raw = msgspec.Raw(b"{}")
    id: int | None = None


_LINE = msgspec.json.Decoder(_Line)
_ALIVE_LINE = msgspec.json.encode(Call("alive", jsonrpc="2.0"))


class _Refusal(Exception):
    """A call that the peer does not carry out."""


class Served:
    """A served world: its class, and the run that goes on without a connection.

    Args:
        world: the class of the world.
        code: the name of an installed world whose handlers the interpreter uses.
        token: the token that each connection requires; empty: none.
    """

    def __init__(self, world: type[World], code: str = "", token: str = "") -> None:
        self.world = world
        self.token = token
        self.halts = hasattr(world, "halt")
        #: The world of the last connection that has ended, for `resume`, and the
        #: number of connections with a world.
        self.left: World | None = None
        self.open = 0
        self.changed = threading.Condition()
        self.description = _description(world, code)


def _description(world: type[World], code: str) -> Description:
    kit: Kit = world.kit
    offer = kit.offer

    def named(name: str, count: int) -> tuple[str, ...]:
        default = tuple(f"argument-{n}" for n in range(1, count + 1))
        return offer.arguments.get(name, default)

    def all_named(table: Mapping[str, int]) -> dict[str, tuple[str, ...]]:
        return {name: named(name, count) for name, count in table.items()}

    methods: list[Any] = ["cancel"]
    for one, names in _OFFERS:
        methods += names if issubclass(world, one) else ()
    crashes: Mapping[str, Any] = offer.after_crash
    return Description(
        protocol=PROTOCOL,
        name=world.name,
        doc=(inspect.getdoc(world) or "").partition("\n")[0],
        primitives={
            name: protocol.Primitive(
                named(name, count),
                tuple(results),
                name not in offer.not_atomic,
                name in offer.sensors,
                crashes.get(name),
            )
            for name, (count, results) in offer.primitives.items()
        },
        data=all_named(offer.data),
        skills=all_named(offer.skills),
        events=all_named(offer.events),
        options=tuple(_option(option) for option in kit.options),
        methods=tuple(methods),
        code=code,
        heartbeat=PERIOD if hasattr(world, "halt") else None,
        stream=True,
    )


def _option(option: Any) -> protocol.WireOption:
    default = (
        option.default.value if isinstance(option.default, Text) else option.default
    )
    return protocol.WireOption(
        option.name, option.kind, default, option.unit, option.doc
    )


class Connection:
    """A connection of the interpreter to a served world.

    Args:
        served: the world.
        reader: the calls, line by line.
        writer: the answers.
        orphan: called if a call goes on after the end of the connection.
    """

    def __init__(
        self,
        served: Served,
        reader: BinaryIO,
        writer: BinaryIO,
        orphan: Callable[[], None] = lambda: None,
    ) -> None:
        self._served = served
        self._reader, self._writer = reader, writer
        self._orphan = orphan
        self._writing = threading.Lock()
        self._over = threading.Event()
        self._world: Any = None
        self._trusted = not served.token
        #: The number of messages since `open` or `restore`.
        self._sent = 0
        #: The start of the present call; None: no call is under way.
        self._busy: float | None = None
        self._watchdog = Watchdog(self._halt)

    def run(self) -> None:
        """Answer all calls until the connection ends."""
        threading.Thread(target=self._watch, daemon=True).start()
        try:
            for line in self._queued() if self._served.halts else self._lines():
                if (answer := self._answer(line)) is not None:
                    self._write(answer)
        except (BrokenPipeError, ConnectionResetError):
            pass  # the interpreter has ended
        finally:
            self._over.set()
            self._watchdog.halt()
            self._leave()

    def _leave(self) -> None:
        """Keep the world for `resume`; close a driver that cannot resume."""
        served = self._served
        close = getattr(self._world, "close", None)
        if close is not None and not isinstance(self._world, Resumable):
            close()
        if self._world is not None:
            with served.changed:
                served.left = self._world
                served.open -= 1
                served.changed.notify_all()

    def _left(self, params: protocol.ResumeParams) -> World:
        """Return the world of the last connection, which may end just now.

        A driver that can reconnect to its machine may also be a new one.
        """
        served = self._served
        with served.changed:
            served.changed.wait_for(lambda: served.left or not served.open, _ENDING)
            world, served.left = served.left, None
        if world is None and params.opening and hasattr(served.world, "reconnect"):
            world = self._made(params.opening)
        if world is None:
            raise _Refusal("no run goes on")
        return world

    def _write(self, line: bytes) -> None:
        with self._writing:
            self._writer.write(line + b"\n")
            self._writer.flush()

    # --- threads ----------------------------------------------------------------------

    def _queued(self) -> Iterator[bytes]:
        """Yield the lines, which a thread reads to notice heartbeats at once."""
        lines: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        threading.Thread(target=self._read, args=[lines.put], daemon=True).start()
        while (line := lines.get()) is not None:
            yield line

    def _lines(self) -> Iterator[bytes]:
        """Yield the lines of the interpreter, up to one that is too long."""
        while (line := self._reader.readline(LINE_LIMIT + 1)).endswith(b"\n"):
            yield line

    def _read(self, put: Callable[[bytes | None], None]) -> None:
        try:
            for line in self._lines():
                self._watchdog.beat()
                if self._busy is not None and b'"heartbeat"' not in line:
                    self._watchdog.halt()  # Ctrl-C has interrupted the call under way
                put(line)
        except OSError:
            pass  # the connection has ended
        put(None)
        self._watchdog.halt()
        if not self._over.wait(_GRACE):
            self._orphan()

    def _watch(self) -> None:
        """Halt the body without heartbeats; report that a long call goes on."""
        while not self._over.wait(TICK if self._served.halts else _ALIVE):
            now = time.monotonic()
            self._watchdog.look()
            busy = self._busy
            if busy is not None and now - busy >= _ALIVE:
                self._busy = now
                try:
                    self._write(_ALIVE_LINE)
                except OSError:
                    return  # the connection has ended

    def _halt(self) -> None:
        self._world.halt()

    # --- calls ------------------------------------------------------------------------

    def _answer(self, line: bytes) -> bytes | None:
        """Return the answer to a line; None for a notification."""
        number: int | None = None
        error: dict[str, Any]
        try:
            call = _LINE.decode(line)
            number = call.id
            if number is None:
                return None
            self._busy = time.monotonic()
            decoder = _PARAMS.get(call.method)
            if decoder is None:
                raise _Refusal(f"unknown method `{call.method}`")
            params = decoder.decode(call.params)
            if call.method == "describe":
                result: Any = self._describe(params)
            else:
                result = self._in_run(call.method, params)
            return msgspec.json.encode(
                {"jsonrpc": "2.0", "id": number, "result": result}
            )
        except UNREADABLE as invalid:
            error = {"code": -32600, "message": f"invalid call: {flaw(invalid)}"}
        except (_Refusal, ValueError) as refused:
            said = str(refused) or type(refused).__name__
            error = {"code": -32000, "message": said + place_of_error(refused)}
        except Exception as broken:  # any exception of the world's code is reported
            traceback.print_exc()
            error = {
                "code": -32000,
                "message": said_by(broken) + place_of_error(broken),
            }
        finally:
            self._busy = None
        return msgspec.json.encode({"jsonrpc": "2.0", "id": number, "error": error})

    def _describe(self, params: protocol.DescribeParams) -> Description:
        token = (params.token or "").encode()
        if not hmac.compare_digest(token, self._served.token.encode()):
            raise _Refusal("the token is wrong")
        self._trusted = True
        return self._served.description

    def _in_run(self, method: str, params: Any) -> Any:
        """Carry out a call; return the result with the messages of the world."""
        if not self._trusted:
            raise _Refusal("`describe` with the token must come first")
        if method in ("open", "resume"):
            if self._world is not None:
                raise _Refusal("the connection has a run already")
            self._world = self._made(params) if method == "open" else self._left(params)
            with self._served.changed:
                self._served.open += 1
        world = self._world
        if world is None:
            raise _Refusal("`open` must come first")
        if params.ack is not None and isinstance(world, Resumable):
            world.acknowledge(params.ack)
        if method in ("perform", "activate"):
            self._watchdog.beat()
            self._watchdog.armed = self._served.halts
        make, fields = getattr(self, f"_{method.replace('-', '_')}")(world, params)
        messages = tuple(map(_message, world.messages()))
        self._sent += len(messages)
        due: Time | None = world.next_time()
        return make(
            now=world.now(),
            next="unknown" if due == NOT_KNOWN else due,
            messages=messages,
            sent=self._sent,
            ended=world.ended(),
            **fields,
        )

    def _made(self, params: protocol.OpenParams) -> World:
        rng = random.Random(params.seed)
        if params.stream is not None:
            rng = stream_in(params.stream)
        make: Callable[..., World] = self._served.world
        world = make(rng, dict(params.options))
        world.made_with = dict(params.options)
        return world

    def _open(self, world: Any, params: Any) -> Any:
        return protocol.Opened, {"facts": tuple(world.facts())}

    def _perform(self, world: Any, params: protocol.PerformParams) -> Any:
        found = world.perform(params.ticket, params.request)
        return protocol.Performed, _outcome(found)

    def _advance(self, world: Any, params: protocol.AdvanceParams) -> Any:
        world.advance(params.to)
        return protocol.Answer, {}

    def _cancel(self, world: Any, params: protocol.TicketParams) -> Any:
        world.cancel(params.ticket)
        return protocol.Answer, {}

    def _activate(self, world: Any, params: protocol.ActivateParams) -> Any:
        found = world.activate(params.ticket, params.skills, params.events)
        return protocol.Activated, _outcome(found)

    def _deactivate(self, world: Any, params: protocol.TicketParams) -> Any:
        world.deactivate(params.ticket)
        return protocol.Answer, {}

    def _usual_time(self, world: Any, params: protocol.UsualTimeParams) -> Any:
        return protocol.UsualTime, {"time": world.usual_time(params.request)}

    def _picture(self, world: Any, params: Any) -> Any:
        picture = world.picture()
        if picture.plan is not None:  # the reckoning is for drawings in the process
            plan = msgspec.structs.replace(picture.plan, reckoning=None)
            picture = msgspec.structs.replace(picture, plan=plan)
        return protocol.Pictured, {"picture": picture}

    def _figures(self, world: Any, params: Any) -> Any:
        return protocol.Measured, {"figures": msgspec.to_builtins(world.figures())}

    def _truth(self, world: Any, params: Any) -> Any:
        told = {name: tuple(facts) for name, facts in world.truth().items()}
        return protocol.ToldTruth, {"facts": told}

    def _save(self, world: Any, params: Any) -> Any:
        state = base64.b64encode(world.save()).decode()
        return protocol.Saved, {"state": msgspec.Raw(msgspec.json.encode(state))}

    def _restore(self, world: Any, params: protocol.RestoreParams) -> Any:
        self._sent = 0
        world.restore(base64.b64decode(msgspec.json.decode(params.state, type=str)))
        return protocol.Answer, {}

    def _resume(self, world: Any, params: protocol.ResumeParams) -> Any:
        self._sent = params.received
        known = world.resume(params.tickets, params.received)
        requests = tuple(
            protocol.Known(ticket, **_outcome(told)) for ticket, told in known.items()
        )
        return protocol.Resumed, {"requests": requests, "facts": tuple(world.facts())}

    def _adjustable(self, world: Any, params: Any) -> Any:
        return protocol.Adjusted, {"options": plain_values(world.adjustable())}

    def _adjust(self, world: Any, params: protocol.AdjustParams) -> Any:
        world.adjust(params.name, params.value)
        return protocol.Answer, {}


def _outcome(told: Reply | Refused | None) -> dict[str, Any]:
    """Return the fields of an answer to a request."""
    if isinstance(told, Reply):
        return {"reply": protocol.WireReply(told.result, told.data, told.memory)}
    if isinstance(told, Refused):
        return {"refused": protocol.Refusal(told.conflicts, told.reason)}
    return {}


def _message(message: Message) -> protocol.WireMessage:
    if isinstance(message, Datum):
        return protocol.WireDatum(message.content, message.memory, message.number)
    if isinstance(message, Signal):
        return protocol.WireSignal(message.content, message.tickets, message.number)
    if isinstance(message, Finished):
        reply = message.reply
        return protocol.WireFinished(
            message.ticket, reply.result, reply.data, reply.memory
        )
    return protocol.WireLost(message.ticket, message.reason)


# --- servers --------------------------------------------------------------------------


def serve(world: type[World], code: str = "") -> None:
    """Serve a world on standard input and output, until standard input ends.

    Output of the world, by `print` for example, goes to standard error.

    Args:
        world: the class of the world.
        code: the name of an installed world whose handlers the interpreter uses.
    """
    reader, writer = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with open(os.devnull, "rb") as nothing:
        os.dup2(nothing.fileno(), 0)
    Connection(Served(world, code), reader, writer, lambda: os._exit(0)).run()


def listen(world: type[World], address: str, code: str = "") -> None:
    """Serve a world at `unix:/path` or `tcp:127.0.0.1:PORT`, each connection at once.

    TCP requires the token in the environment variable `RAPC_TOKEN`.

    Raises:
        ValueError: for another address, or without the token.
        OSError: if the address cannot be used.
    """
    kind, _, rest = address.partition(":")
    token = ""
    if kind == "unix":
        path = Path(rest)
        if path.is_socket():
            path.unlink()
        listening = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        mask = os.umask(0o177)
        listening.bind(rest)
        os.umask(mask)
    elif kind == "tcp" and rest.startswith("127.0.0.1:"):
        token = os.environ.get(TOKEN, "")
        if not token:
            raise ValueError(f"TCP requires a token in `{TOKEN}`")
        listening = socket.create_server(("127.0.0.1", int(rest.rpartition(":")[2])))
    else:
        raise ValueError(f"`{address}` is not `unix:/path` or `tcp:127.0.0.1:PORT`")
    served = Served(world, code, token)
    with listening:
        listening.listen()
        print(f"serving {world.name} at {address}", file=sys.stderr, flush=True)
        while True:
            made, _ = listening.accept()
            threading.Thread(target=_serve_socket, args=[served, made]).start()


def _serve_socket(served: Served, made: socket.socket) -> None:
    with (
        suppress(BrokenPipeError),  # an answer that the interpreter does not read
        made,
        made.makefile("rb") as reader,
        made.makefile("wb") as writer,
    ):
        Connection(served, reader, writer).run()
