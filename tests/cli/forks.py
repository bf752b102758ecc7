"""The process of which commands are forked: it has imported what they need, and waits.

`python forks.py SOCKET` imports the command line and waits for requests. Each becomes a
process of its own that is as `rapc` is after its imports: it has its own folder,
environment, modules and exit status. The process that waits runs no command itself:
nothing gets from one command into the next.

A request comes over the socket as four files: one that holds a `Request`, and standard
input, output and error. Back come two lines, the number of the process and, when it has
ended, its exit status.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import pkgutil
import socket
import sys
import threading
from importlib import import_module
from pathlib import Path
from typing import TypedDict

HEAVY = {"rapc.console.experiments.plots": "experiment"}
"""Modules that take their time, each with the one command that wants it."""

LEFT_OUT = ("rapc.cli.start", "rapc.experiments.cluster")
"""Modules that are not imported ahead: the beginning itself, and an extra."""

NOT_FORKED = ("rapc.lsp", "pytest")
"""Parts of the names of modules that no forked command wants."""


class Request(TypedDict):
    """What to run: the command with its arguments, in a folder and an environment."""

    command: list[str]
    cwd: str
    environment: dict[str, str]


def _import_all() -> None:
    """Import what the commands want, but for the heavy modules and those for pytest."""
    import rapc  # noqa: PLC0415  # by whom this module is imported has it already

    for _, name, _ in pkgutil.walk_packages(rapc.__path__, "rapc."):
        wanted = not any(part in name for part in NOT_FORKED)
        if wanted and name not in HEAVY and name not in LEFT_OUT:
            import_module(name)


def _forked(asked: socket.socket) -> bool:
    """Fork for one request after the other; say in a fork that it is one."""
    while True:
        _, files, _, _ = socket.recv_fds(asked, 1, 4)
        if not files:
            return False
        with open(files[0], encoding="utf-8") as file:
            request: Request = json.load(file)
        for name, command in HEAVY.items():
            if command in request["command"]:
                import_module(name)
        child = os.fork()
        if not child:
            asked.close()
            _become(request, files[1:])
            return True
        for stream in files[1:]:
            os.close(stream)
        asked.sendall(b"%d\n" % child)
        _, status = os.waitpid(child, 0)
        asked.sendall(b"%d\n" % os.waitstatus_to_exitcode(status))


def _become(request: Request, streams: list[int]) -> None:
    """Take over the standard streams, the arguments, the folder and the environment."""
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    os.chdir(request["cwd"])
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.argv = request["command"]
    sys.path[0] = str(Path(sys.argv[0]).parent)
    sys.modules["__main__"].__file__ = sys.argv[0]


def _run() -> int:
    """Run the command and all that Python does at an end; returns the exit status.

    Only what this process has in memory is left as it is: that would take longer than
    many a command.
    """
    from rapc.cli.start import main  # noqa: PLC0415  # is the beginning

    status: object = None
    try:
        main()
    except SystemExit as end:
        status = end.code
    assert isinstance(status, int)
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    return status


if __name__ == "__main__":
    _import_all()
    gc.collect()
    gc.freeze()
    if _forked(socket.socket(fileno=int(sys.argv[1]))):
        os._exit(_run())
