"""A peer of two lamps in plain Python, and its broken versions: `lamps.py FAULT`."""

import json
import os
import signal
import sys
import time
from collections.abc import Callable, Mapping
from typing import Any, NoReturn

Answer = dict[str, Any]
Fault = Callable[[int, Answer], object]

DESCRIPTION: Answer = {
    "protocol": 1,
    "name": "lamps",
    "doc": "Two lamps with switches.",
    "primitives": {
        "press": {"arguments": ["lamp"], "results": ["okay", "stuck"]},
        "warm": {"arguments": ["lamp"], "results": ["okay"], "atomic": False},
    },
    "data": {"lit": ["lamp"], "noise": []},
    "options": [{"name": "speed", "kind": "number", "default": 2, "doc": "speed"}],
    "methods": ["cancel", "save", "restore"],
    "a-field-of-the-future": [1, 2, 3],
}


def main(fault: str) -> None:  # noqa: PLR0912  # one loop, as a peer is
    state: Answer = {"now": 0, "due": []}
    answer: Answer
    for line in sys.stdin:
        call = json.loads(line)
        method, params = call["method"], call.get("params", {})
        if method == "describe":
            answer = dict(DESCRIPTION)
            if fault in describe_faults:
                describe_faults[fault](answer)
        elif method == "open":
            answer = {"facts": [["lamp", "hall"], ["lamp", "attic"]]}
        elif method == "perform" and params["request"][0] == "press":
            state["now"] += 2
            answer = {"reply": {"result": "okay"}}
        elif method == "perform":
            state["due"].append([state["now"] + 5, params["ticket"]])
            answer = {}
        elif method == "advance":
            state["now"] = max(state["now"], params["to"])
            answer = {}
        elif method == "save":
            answer = {"state": state}
        elif method == "restore":
            if not isinstance(params["state"], dict):
                send({"id": call["id"], "error": {"code": 1, "message": "no state"}})
                continue
            state = params["state"]
            answer = {}
        else:
            answer = {}
        if method != "describe":
            due = [ticket for at, ticket in state["due"] if at <= state["now"]]
            state["due"] = [one for one in state["due"] if one[0] > state["now"]]
            answer["now"] = state["now"]
            answer["next"] = min((at for at, _ in state["due"]), default=None)
            answer["messages"] = [
                {"type": "finished", "ticket": ticket, "result": "okay"}
                for ticket in due
            ]
        if method == "perform" and fault in perform_faults:
            perform_faults[fault](call["id"], answer)
            continue
        if method == "advance" and fault in advance_faults:
            advance_faults[fault](call["id"], answer)
            continue
        if method == "open" and fault == "half-a-line-and-silence":
            # The half line comes in one write with this answer: before the time limit
            # of the next call, however slow the machine is.
            told = {"jsonrpc": "2.0", "id": call["id"], "result": answer}
            write(json.dumps(told).encode() + b'\n{"jsonrpc":')
            continue
        send({"id": call["id"], "result": answer})


def send(answer: Answer) -> None:
    write(json.dumps({"jsonrpc": "2.0", **answer}).encode() + b"\n")


def write(line: bytes) -> None:
    sys.stdout.buffer.write(line)
    sys.stdout.flush()


def text(line: bytes) -> Fault:
    """Return a fault that sends a line in place of the answer."""
    return lambda number, answer: write(line + b"\n")


def field(**fields: Any) -> Fault:
    """Return a fault that changes fields of the answer."""
    return lambda number, answer: send({"id": number, "result": {**answer, **fields}})


def raw(result: bytes) -> Fault:
    """Return a fault that sends the text of a result."""

    def fault(number: int, answer: Answer) -> None:
        write(b'{"jsonrpc":"2.0","id":%d,"result":%s}\n' % (number, result))

    return fault


def message(*messages: Answer) -> Fault:
    return field(messages=list(messages))


def leave(status: int) -> NoReturn:
    sys.stderr.write("lamps: the fuse has blown\n")
    sys.stderr.flush()
    os._exit(status)


def closed_input(number: int, answer: Answer) -> None:
    os.close(0)
    send({"id": number, "result": answer})
    time.sleep(60)


def closed_output(number: int, answer: Answer) -> None:
    os.close(1)
    sys.stdin.read()


def half_a_line(number: int, answer: Answer) -> None:
    write(b'{"jsonrpc":"2.0","id":')
    leave(0)


def flood(line: bytes) -> Fault:
    def fault(number: int, answer: Answer) -> None:
        try:
            while True:
                sys.stdout.buffer.write(line * 1000)
        except BrokenPipeError:
            os._exit(0)

    return fault


def changed(**fields: Any) -> Callable[[Answer], object]:
    return lambda told: told.update(fields)


describe_faults: dict[str, Callable[[Answer], object]] = {
    "ends-at-once": lambda told: leave(1),
    "describes-nothing": lambda told: told.clear(),
    "other-protocol": changed(protocol=7),
    "name-with-blanks": changed(name="two lamps"),
    "argument-named-badly": changed(data={"lit": ["The Lamp"]}),
    "same-name-twice": changed(data={"press": []}),
    "option-of-no-kind": changed(options=[{"name": "a", "kind": "x", "default": 1}]),
    "saves-only": changed(methods=["save"]),
    "code-of-a-module": changed(code="os:path"),
    "code-of-nobody": changed(code="nobody"),
    "event-without-colon": changed(events={"bump": []}),
}

quick: Answer = {"timeouts": {"perform": 0.1, "advance": 0.1}}
for name in ("silence", "half-a-line-and-silence"):
    describe_faults[name] = changed(**quick)
describe_faults["counts-nothing"] = changed(methods=["resume", "cancel"])

perform_faults: Mapping[str, Fault] = {
    "wrong-id": lambda number, answer: send({"id": number + 7, "result": answer}),
    "no-id": lambda number, answer: send({"result": answer}),
    "text-id": lambda number, answer: send({"id": str(number), "result": answer}),
    "half-a-line": half_a_line,
    "half-a-line-and-silence": lambda number, answer: None,
    "silence": lambda number, answer: None,
    "no-json": text(b"lamp pressed"),
    "empty-line": text(b""),
    "list": text(b"[]"),
    "null": text(b"null"),
    "no-version": text(b'{"id":3,"result":{"now":1}}'),
    "deep": text(b"[" * 100_000 + b"]" * 100_000),
    "invalid-utf-8": raw(b'{"now":1,"ended":"\xff\xfe"}'),
    "nan": raw(b'{"now":NaN}'),
    "infinite": raw(b'{"now":1e999}'),
    "no-clock": raw(b"{}"),
    "text-clock": field(now="noon"),
    "flag-clock": field(now=True),
    "negative-clock": field(now=-1),
    "late-clock": field(now=10**16),
    "ends": lambda number, answer: leave(3),
    "killed": lambda number, answer: os.kill(os.getpid(), signal.SIGKILL),
    "closes-output": closed_output,
    "closes-input": closed_input,
    "huge-line": flood(b"x" * 1000),
    "flood-of-lines": flood(b'{"jsonrpc":"2.0","id":999,"result":{}}\n'),
    "flood-of-notices": flood(b'{"jsonrpc":"2.0","method":"alive"}\n'),
    "flood-of-messages": field(
        messages=[{"type": "datum", "content": ["noise"]}] * 10_001
    ),
    "no-result": lambda number, answer: send({"id": number}),
    "error": lambda number, answer: send(
        {"id": number, "error": {"code": 5, "message": "the fuse\nhas blown"}}
    ),
    "no-reply": field(reply=None),
    "undeclared-result": field(reply={"result": "burnt"}),
    "undeclared-datum": field(reply={"result": "okay", "data": [["smoke"]]}),
    "datum-without-handler": field(reply={"result": "okay", "data": [["noise"]]}),
    "too-many-arguments": field(reply={"result": "okay", "data": [["lit", "a", "b"]]}),
    "capitals": field(reply={"result": "okay", "data": [["lit", "Hall"]]}),
    "empty-fact": field(reply={"result": "okay", "data": [[]]}),
    "unknown-change": field(reply={"result": "okay", "memory": [["forget", "lit"]]}),
    "undeclared-change": field(reply={"result": "okay", "memory": [["assert", "x"]]}),
    "unknown-message": message({"type": "smoke"}),
    "unknown-ticket": message({"type": "finished", "ticket": 77, "result": "okay"}),
    "text-ticket": message({"type": "finished", "ticket": "1", "result": "okay"}),
    "counts-wrongly": field(sent=5),
    "long-error": lambda number, answer: send(
        {"id": number, "error": {"message": "\x1b[31m" + "blown " * 1000}}
    ),
}

advance_faults: Mapping[str, Fault] = {
    "stuck": lambda number, answer: time.sleep(60),
    "clock-back": field(now=1),
    "next-in-the-past": field(next=1),
    "no-message-announced": field(messages=[], next=7),
    "duplicate-ticket": lambda number, answer: send(
        {"id": number, "result": {**answer, "messages": answer["messages"] * 2}}
    ),
}

if __name__ == "__main__":
    main(*sys.argv[1:] or [""])
