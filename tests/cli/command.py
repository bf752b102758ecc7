"""Runs the real command in a process of its own."""

from __future__ import annotations

import atexit
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryFile

from . import forks

COMMAND = Path(sys.executable).with_name("rapc")

HOME = {k: v for k, v in os.environ.items() if k == "PYTHONPATH"}
"""Has the command import the same package as the tests."""

BARE = {"PATH": "", "LANG": "C.UTF-8", **HOME}
"""An environment with nothing in it but where rapc is."""

PATIENCE = 300.0
"""How many seconds a command may take."""


def rapc(
    *args: str, cwd: Path | None = None, stdin: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run `rapc` with some arguments, and of the environment only where rapc is.

    The process is a fork of one that has imported what commands need, except where the
    environment tells Python itself something: then it begins as it does in a shell.
    No run may show a traceback, whatever it is given.
    """
    to_python = any(name.startswith(("PYTHON", "LANG", "LC_")) for name in environment)
    run = from_the_beginning if to_python else _forked
    done = run([str(COMMAND), *args], cwd or Path.cwd(), {**BARE, **environment}, stdin)
    assert "Traceback" not in done.stderr
    assert "rapc itself is at fault" not in done.stderr
    return done


def from_the_beginning(
    command: list[str], cwd: Path, environment: dict[str, str], stdin: str
) -> subprocess.CompletedProcess[str]:
    """Run a command as a shell does."""
    return subprocess.run(
        command,
        cwd=cwd,
        input=stdin,
        env=environment,
        capture_output=True,
        encoding="utf-8",
        timeout=PATIENCE,
        check=False,
    )


def _forked(
    command: list[str], cwd: Path, environment: dict[str, str], stdin: str
) -> subprocess.CompletedProcess[str]:
    """Run a command as a fork of the process that waits for such requests."""
    request = forks.Request(command=command, cwd=str(cwd), environment=environment)
    theirs, ours = zip(*(os.pipe(), os.pipe()[::-1], os.pipe()[::-1]), strict=True)
    with (
        open(ours[0], "w", encoding="utf-8") as given,
        open(ours[1], encoding="utf-8") as out,
        open(ours[2], encoding="utf-8") as err,
        ThreadPoolExecutor(2) as pool,
    ):
        number = _fork(request, theirs)
        said = [pool.submit(file.read) for file in (out, err)]
        with suppress(BrokenPipeError):
            given.write(stdin)
            given.close()
        status = _status(number, command)
    return subprocess.CompletedProcess(command, status, *(one.result() for one in said))


def _fork(request: forks.Request, streams: Sequence[int]) -> int:
    """Ask for a fork with some standard streams, and close them here.

    Returns:
        The number of the process.
    """
    with TemporaryFile() as file:
        file.write(json.dumps(request).encode())
        file.seek(0)
        socket.send_fds(_waiting(), [b"."], [file.fileno(), *streams])
    for stream in streams:
        os.close(stream)
    return int(_line())


def _status(number: int, command: list[str]) -> int:
    """Wait for the end of a fork; returns its exit status.

    Raises:
        subprocess.TimeoutExpired: if it takes too long; it is ended then.
    """
    try:
        return int(_line())
    except TimeoutError:
        os.kill(number, signal.SIGKILL)
        _line()
        raise subprocess.TimeoutExpired(command, PATIENCE) from None


def _line() -> bytes:
    """The next line from the process that forks."""
    line = b""
    while not line.endswith(b"\n"):
        byte = _waiting().recv(1)
        assert byte, "the process that commands are forked of has ended"
        line += byte
    return line


@cache
def _waiting() -> socket.socket:
    """The way to the process that commands are forked of; it ends with this one.

    Its standard streams are pipes, as those of the forks are: Python looks once.
    """
    asked, here = socket.socketpair()
    process = subprocess.Popen(
        [sys.executable, forks.__file__, str(here.fileno())],
        env=BARE,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        pass_fds=[here.fileno()],
        start_new_session=True,
    )
    here.close()
    asked.settimeout(PATIENCE)

    def end() -> None:
        asked.close()
        process.communicate()

    atexit.register(end)
    return asked
