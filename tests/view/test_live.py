"""The server of the page of a run that goes on, over a real socket."""

from __future__ import annotations

import http.client
import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from io import StringIO
from pathlib import Path
from threading import Thread

import pytest

from rapc import load, open_world
from rapc.durable import journal
from rapc.durable.runs import Resumption
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.interpreter import Interpreter
from rapc.spec import RunSpec
from rapc.view.control import Control
from rapc.view.live import HOST, Feed, Live
from tests.durable.helpers import Run

LINES = [f'{{"n":{n}}}\n' for n in range(12_000)]


@pytest.fixture
def live() -> Iterator[Live]:
    found = Live("<p>page</p>")
    yield found
    found.close()


def get(live: Live, path: str, **headers: str) -> tuple[int, str]:
    """Return the status and the body of an answer; with the token for `TOKEN`."""
    link = http.client.HTTPConnection(HOST, live.server_port, timeout=60)
    link.request("GET", path.replace("TOKEN", live.token), headers=headers)
    answer = link.getresponse()
    body = answer.read().decode()
    link.close()
    return answer.status, body


def post(live: Live, path: str, body: bytes) -> tuple[int, str]:
    """Return the status and the body of the answer to a request."""
    link = http.client.HTTPConnection(HOST, live.server_port, timeout=60)
    link.request("POST", path.replace("TOKEN", live.token), body=body)
    answer = link.getresponse()
    found = answer.status, answer.read().decode()
    link.close()
    return found


def data(body: str) -> str:
    """Return the lines of the events in a body."""
    messages = [one for one in body.split("\n\n") if one.startswith("id: ")]
    rows = [row for one in messages for row in one.split("\n")[1:]]
    return "".join(row.removeprefix("data: ") + "\n" for row in rows)


def test_page_has_the_token_in_its_address(live: Live) -> None:
    path = live.address.removeprefix(f"http://{HOST}:{live.server_port}")
    assert get(live, path) == (200, "<p>page</p>")


@pytest.mark.parametrize(
    "path", ["/", "/events", "/x/", "/x/events", "/TOKENx/", "/TOKEN/other", "/%ff/"]
)
def test_other_addresses_are_not_found(live: Live, path: str) -> None:
    live.feed.write(LINES[0])
    status, body = get(live, path)
    assert status == 404
    for text in ('"n"', "page", live.token):
        assert text not in body


def test_other_hosts_are_not_found(live: Live) -> None:
    host = f"evil.example:{live.server_port}"
    assert get(live, "/TOKEN/", Host=host)[0] == 404
    host = f"localhost:{live.server_port}"
    assert get(live, "/TOKEN/", Host=host)[0] == 200


def test_late_readers_get_the_whole_trace(live: Live) -> None:
    for line in LINES:
        live.feed.write(line)
    live.feed.end()
    for _ in range(2):
        status, body = get(live, "/TOKEN/events")
        assert status == 200
        assert data(body) == "".join(LINES)
        assert body.endswith("event: end\ndata:\n\n")


def test_reader_gets_lines_while_the_run_goes_on(live: Live) -> None:
    live.feed.write(LINES[0])
    link = http.client.HTTPConnection(HOST, live.server_port, timeout=60)
    link.request("GET", f"/{live.token}/events")
    answer = link.getresponse()
    assert [answer.readline() for _ in range(3)] == [
        b"id: 1\n",
        f"data: {LINES[0]}".encode(),
        b"\n",
    ]
    live.feed.write(LINES[1])
    assert answer.readline() == b"id: 2\n"
    link.close()


def test_reader_that_comes_back_gets_the_rest(live: Live) -> None:
    for line in LINES:
        live.feed.write(line)
    live.feed.end()
    _, body = get(live, "/TOKEN/events", **{"Last-Event-ID": "11990"})
    assert data(body) == "".join(LINES[11_990:])


def test_reader_gets_a_line_once_while_it_is_written() -> None:
    """The last line of a block is there before the block is."""
    feed = Feed()
    for line in LINES[:63]:
        feed.write(line)
    feed._lines.append(LINES[63])
    at, before = feed.after(0)
    _, after = feed.after(at)
    assert "".join(LINES[:64]).startswith(before + after)


def test_requests_need_the_token_and_a_control(live: Live) -> None:
    for path in ("/control", "/x/control", "/TOKEN/control", "/TOKEN/events"):
        status, body = post(live, path, b'{"name":"pause"}')
        assert status == 404
        assert live.token not in body


@pytest.fixture
def controlled() -> Iterator[Live]:
    control = Control(paused=True)
    found = Live("", control=control)
    run = load("examples/courier").start("courier", agenda="shift")
    Thread(target=control.go, args=(run,), daemon=True).start()
    yield found
    control.ask("continue")
    found.close()


def test_requests_are_carried_out(controlled: Live) -> None:
    status, body = post(controlled, "/TOKEN/control", b'{"name":"pause"}')
    assert (status, json.loads(body)) == (
        200,
        {"failed": False, "said": "cycle 0, time 0"},
    )
    request = {"name": "submit", "text": "(deliver"}
    status, body = post(controlled, "/TOKEN/control", json.dumps(request).encode())
    assert (status, json.loads(body)["failed"]) == (200, True)
    assert post(controlled, "/x/control", b'{"name":"pause"}')[0] == 404
    host = {"Host": "evil.example"}
    link = http.client.HTTPConnection(HOST, controlled.server_port, timeout=60)
    link.request("POST", f"/{controlled.token}/control", b'{"name":"step"}', host)
    assert link.getresponse().status == 404
    link.close()


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"[]",
        b'{"name":3}',
        b'{"name":"\xff"}',
        b"[" * 10_000,
        b'{"name":"submit","text":"' + b"x" * 30_000 + b'"}',
    ],
)
def test_invalid_requests_are_refused(controlled: Live, body: bytes) -> None:
    assert post(controlled, "/TOKEN/control", body)[0] == 400


def test_readers_get_the_state_of_the_run(controlled: Live) -> None:
    link = http.client.HTTPConnection(HOST, controlled.server_port, timeout=60)
    link.request("GET", f"/{controlled.token}/events")
    answer = link.getresponse()
    control = controlled.control
    assert control is not None
    control.ask("step")
    seen: list[dict[str, str]] = []
    while not seen or seen[-1]["moment"] != "cycle 1, time 0":
        if answer.readline() == b"event: status\n":
            seen.append(json.loads(answer.readline().removeprefix(b"data: ")))
    assert seen[-1]["state"] == "paused"
    link.close()


def test_journal_is_followed_from_another_process(tmp_path: Path) -> None:
    program = load("examples/courier").program
    spec = RunSpec(agenda="shift", seed=3, until=1500)
    run = Run(tmp_path, program, spec, lambda: open_world("courier", seed=3))
    durable = run.begin()
    durable.reach(40)
    view = (sys.executable, "-m", "rapc", "view", "--attach", str(run.journal))
    with subprocess.Popen(view, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        address = process.stderr.readline().removeprefix("view: ").strip()
        _, _, host, token, _ = address.split("/")
        link = http.client.HTTPConnection(host, timeout=60)
        link.request("GET", f"/{token}/events")
        answer = link.getresponse()
        head = answer.readline() + answer.readline()
        assert b"run-started" in head
        link.close()
        durable.go()
        durable.close()
        link.request("GET", f"/{token}/events")
        body = link.getresponse().read().decode()
        link.close()
        while "the run has ended; Ctrl-C" not in process.stderr.readline():
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
    assert process.returncode == 0
    assert data(body) == run.trace.read_text()


@contextmanager
def served(*args: str) -> Iterator[tuple[subprocess.Popen[str], str, str]]:
    """Run a command with a page; give its process, and host and token of the page."""
    command = (sys.executable, "-m", "rapc", *args)
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        address = process.stderr.readline().removeprefix("view: ").strip()
        _, _, host, token, _ = address.split("/")
        yield process, host, token
        process.stderr.read()


def test_controlled_run_with_a_journal_is_killed_and_resumed(tmp_path: Path) -> None:
    library, trace, folder = "examples/courier", tmp_path / "trace", tmp_path / "day"
    begin = ("run", library, "--world", "courier", "--agenda", "shift", "-q")
    files = ("--trace", str(trace), "--journal", str(folder))
    with served(*begin, *files, "--view", "--paused") as (process, host, token):
        link = http.client.HTTPConnection(host, timeout=60)
        for name, text in (
            *[("step", "")] * 30,
            ("submit", "(deliver linen"),
            ("submit", "(deliver linen ward-1) :priority 2"),
            ("assert", "(x)"),
            ("assert", "(ward-1 is-no-predicate)"),
            *[("step", "")] * 20,
        ):
            body = json.dumps({"name": name, "text": text})
            link.request("POST", f"/{token}/control", body)
            assert link.getresponse().read().startswith(b'{"failed":')
        link.close()
        process.kill()
    with served("run", "--resume", str(folder), "-q", "--view") as page:
        process, host, token = page
        link = http.client.HTTPConnection(host, timeout=60)
        link.request("GET", f"/{token}/events")
        body = link.getresponse().read().decode()
        link.close()
        assert process.stderr is not None
        while "Ctrl-C" not in process.stderr.readline():
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
    assert process.returncode == 0
    expected = StringIO()
    heard = [JsonTrace(expected)]
    run = load(library).start("courier", agenda="shift", listeners=heard)
    for _ in range(30):
        run.step()
    run.submit("(deliver linen ward-1) :priority 2")
    run.run()
    assert data(body).splitlines()[1:] == expected.getvalue().splitlines()[1:]
    assert data(body) == trace.read_text()


def test_resumed_run_has_a_past_for_readers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal, "CYCLES", 20)
    monkeypatch.setattr(journal, "PAUSE", 0)
    program = load("examples/courier").program
    spec = RunSpec(agenda="shift", seed=3, until=1500)
    run = Run(tmp_path, program, spec, lambda: open_world("courier", seed=3))
    durable = run.begin()
    durable.reach(50)
    durable.close()
    resumption = Resumption(run.journal, program)
    again = Interpreter.prepared(program, open_world("courier", seed=3), spec)
    text = StringIO()
    trace = JsonTrace(text)
    again.listen(trace)
    durable = resumption.resume(again, run.options, run.decide, hear_past=trace)
    durable.go()
    durable.close()
    found = [json.loads(line) for line in text.getvalue().splitlines()]
    assert found[0]["event"] == "run-started"
    assert [one["n"] - found[0]["n"] for one in found] == [*range(len(found))]
    whole = [json.loads(line) for line in run.whole().splitlines()]
    known = sum(one["cycle"] > 40 for one in whole)
    assert 0 < known < len(found) < len(whole)
    assert found[-known:] == whole[-known:]


def test_events_of_a_run_equal_its_trace(tmp_path: Path) -> None:
    file, plain = tmp_path / "run.jsonl", tmp_path / "plain.jsonl"
    command = "-m rapc run examples/courier --world courier --agenda shift -q --trace"
    run = (sys.executable, *command.split())
    with subprocess.Popen(
        (*run, str(file), "--view"), stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        address = process.stderr.readline().removeprefix("view: ").strip()
        _, _, host, token, _ = address.split("/")
        link = http.client.HTTPConnection(host, timeout=60)
        link.request("GET", f"/{token}/events")
        body = link.getresponse().read().decode()
        link.close()
        while "Ctrl-C" not in process.stderr.readline():
            assert process.poll() is None
        process.send_signal(signal.SIGINT)
        process.stderr.read()
    done = subprocess.run((*run, str(plain)), capture_output=True, check=False)
    assert process.returncode == done.returncode
    assert data(body) == file.read_text() == plain.read_text()
