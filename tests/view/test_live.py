"""The server of the page of a run that goes on, over a real socket."""

from __future__ import annotations

import http.client
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from rapc.view.live import HOST, Live

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


def data(body: str) -> str:
    """Return the lines of the messages of a body."""
    rows = body.splitlines(keepends=True)
    return "".join(r.removeprefix("data: ") for r in rows if r.startswith("data: "))


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
    live.feed.ended.set()
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
    live.feed.ended.set()
    _, body = get(live, "/TOKEN/events", **{"Last-Event-ID": "11990"})
    assert data(body) == "".join(LINES[11_990:])


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
