"""A broken peer ends the run with one line that names the peer and the method."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

import rapc
import rapc.worlds.remote.peer
from rapc.errors import Error

PEER = Path(__file__).parent / "lamps.py"
LIBRARY = """
(declare-primitive press (?lamp) (okay stuck) :on (okay (on ?lamp)))
(declare-primitive warm (?lamp) (okay) :atomic false :on (okay (warm ?lamp)))
(declare-sensor-datum lit (?lamp) :on ((on ?lamp)))
(declare-sensor-datum noise ())
(declare-memory-proposition lamp (?lamp))
(declare-memory-proposition on (?lamp))
(declare-memory-proposition warm (?lamp))
(define-rap (light ?lamp)
  (method (task-net (t1 (press ?lamp) (for t2)) (t2 (heat ?lamp)))))
(define-rap (press ?lamp) (method (primitive (press ?lamp))))
(define-rap (heat ?lamp) (method (primitive (warm ?lamp))))
"""

DESCRIBE: Mapping[str, str] = {
    "ends-at-once": "ended with status 1 instead of answering `describe`; its last "
    "lines: lamps: the fuse has blown",
    "describes-nothing": "`describe`: object missing required field `protocol`",
    "other-protocol": "answered `describe` with version 7 of the protocol, not 1",
    "name-with-blanks": "`describe`: expected `str` matching regex",
    "argument-named-badly": "`describe`: expected `str` matching regex",
    "same-name-twice": "in `describe`: two parts of the offer have the same name",
    "option-of-no-kind": "`describe`: invalid enum value 'x'",
    "saves-only": "in `describe`: `methods` has only one of `save` and `restore`",
    "code-of-a-module": "in `describe`: `code` names `os:path`, not an installed world",
    "code-of-nobody": "in `describe`: unknown world `nobody`",
    "event-without-colon": "in `describe`: expected a colon",
}
RUN: Mapping[str, str] = {
    "wrong-id": "answered `perform` with id 10 instead of id 3",
    "no-id": "answered `perform` with no id instead of id 3",
    "text-id": "an invalid line instead of an answer to `perform`: expected `int",
    "half-a-line": "ended with status 0 in its answer to `perform`; its last lines:",
    "half-a-line-and-silence": "no answer to `perform` in 0.1 s (the answer has no end",
    "silence": "gave no answer to `perform` in 0.1 s",
    "no-json": "an invalid line instead of an answer to `perform`: JSON is malformed",
    "empty-line": "an invalid line instead of an answer to `perform`: input data was",
    "list": "an invalid line instead of an answer to `perform`: expected `object`",
    "null": "an invalid line instead of an answer to `perform`: expected `object`",
    "no-version": "to `perform`: object missing required field `jsonrpc`",
    "deep": "an invalid line instead of an answer to `perform`: ",
    "invalid-utf-8": "sent an invalid answer to `perform`: ",
    "nan": "an invalid line instead of an answer to `perform`: JSON is malformed",
    "infinite": "sent an invalid answer to `perform`: number out of range",
    "no-clock": "answer to `perform`: object missing required field `now`",
    "text-clock": "answer to `perform`: expected `int | float`, got `str` - at `$.now`",
    "flag-clock": "answer to `perform`: expected `int | float`, got `bool`",
    "negative-clock": "answer to `perform`: expected `int` >= 0 - at `$.now`",
    "late-clock": "answer to `perform`: expected `int` <= 1000000000000000",
    "ends": "ended with status 3 instead of answering `perform`; its last lines: lamps",
    "killed": "ended by SIGKILL instead of answering `perform`",
    "closes-output": "closed its output instead of answering `perform`",
    "closes-input": "closed its input before `perform`",
    "huge-line": "sent more than 16777216 bytes in answer to `perform`",
    "flood-of-lines": "answered `perform` with id 999 instead of id 3",
    "flood-of-notices": "sent more than 100000 notifications during `perform`",
    "flood-of-messages": "answer to `perform`: expected `array` of length <= 10000",
    "no-result": "sent an invalid answer to `perform`: input data was truncated",
    "error": "failed in `perform`: the fuse has blown",
    "no-reply": "did not answer it, and it is declared atomic; see",
    "undeclared-result": "with `burnt`, which is not a result of `press`; expected",
    "undeclared-datum": "has no handler for its datum smoke; see",
    "datum-without-handler": "has no handler for its datum noise; see",
    "too-many-arguments": "sent the datum (lit a b): ",
    "capitals": "the reply to (press hall) of the world `lamps` is",
    "empty-fact": "the reply to (press hall) of the world `lamps` is",
    "unknown-change": "the reply to (press hall) of the world `lamps` is",
    "unknown-message": "answer to `perform`: invalid value 'smoke'",
    "unknown-ticket": "ended a request that is not under way: 77; see",
    "text-ticket": "answer to `perform`: expected `int`, got `str`",
    "counts-wrongly": "counted 5 messages in the answer to `perform`, not 0",
    "long-error": "failed in `perform`: \N{REPLACEMENT CHARACTER}[31mblown blown",
    "counts-nothing": "gave no `sent` in the answer to `open`",
    "clock-back": "set its clock back in the answer to `advance`, from 2 to 1",
    "next-in-the-past": "for time 1 in the answer to `advance`, in the past",
    "no-message-announced": "announced a message for time 7, but sent none; see",
    "duplicate-ticket": "ended a request that is not under way: 2; see",
}


def peer(fault: str) -> str:
    return f"exec:{sys.executable} -ISu {PEER} {fault}"


def run(fault: str) -> rapc.RunResult:
    return rapc.run(rapc.loads(LIBRARY), peer(fault), "(light hall)")


def test_whole_peer_works() -> None:
    found = run("")
    assert found.succeeded
    assert found.run.now == 7
    facts = [("lamp", "hall"), ("lamp", "attic"), ("on", "hall"), ("warm", "hall")]
    assert list(found.run.memory) == facts


@pytest.mark.parametrize("fault", [*DESCRIBE, *RUN])
def test_broken_peer_ends_in_one_line(
    fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rapc.worlds.remote.peer, "_GRACE", 0.1)
    with pytest.raises(Error) as caught:
        run(fault)
    message = caught.value.message
    assert "\n" not in message
    assert f"peer `{peer(fault)}`" in message
    method = "describe" if fault in DESCRIBE else "perform"
    method = "advance" if "advance" in message else method
    method = "open" if fault == "counts-nothing" else method
    assert len(message) < 1000
    assert f"`{method}`" in message
    assert {**DESCRIBE, **RUN}[fault] in message


def test_undeclared_change_names_request_and_world() -> None:
    with pytest.raises(rapc.PortError, match=r"by \(press hall\) in the world `lamps`"):
        run("undeclared-change")


@pytest.mark.parametrize(
    ("address", "wanted"),
    [
        ("exec:", "the address `exec:` has no command"),
        ("exec:no-such-command-here", "cannot reach the peer `exec:no-such-command-h"),
        (
            "exec:'",
            "cannot read the command of the peer `exec:'`: no closing quotation",
        ),
        ("unix:/nowhere/at/all", "cannot reach the peer `unix:/nowhere/at/all`"),
        ("tcp:example.org:80", "is not of the form `tcp:127.0.0.1:PORT`"),
        ("tcp:127.0.0.1:0", "is not of the form `tcp:127.0.0.1:PORT`"),
        ("tcp:127.0.0.1:1", "requires a token in `RAPC_TOKEN`"),
    ],
)
def test_unusable_address_is_refused(
    address: str, wanted: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("RAPC_TOKEN", raising=False)
    with pytest.raises(rapc.WorldError) as caught:
        rapc.open_world(address)
    assert wanted in caught.value.message
