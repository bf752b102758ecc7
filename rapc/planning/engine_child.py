"""Run a command in a process group that ends with the process that asked for it.

`python -IS engine_child.py COMMAND...` is run by `rapc.planning.engines` in a session
of its own. Standard input is a socket: the status of the command is sent to it, and the
whole group is killed when the other end is closed. The module imports nothing of rapc.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading


def main() -> None:
    """Run the command of the arguments, and send its status."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        status = subprocess.call(sys.argv[1:], stdin=subprocess.DEVNULL)  # noqa: S603
    except OSError as error:
        print(f"{sys.argv[1]}: {error.strerror}", flush=True)
        status = 127
    os.write(0, f"{status}\n".encode())


def _end_with_parent() -> None:
    """Kill the group when the socket is closed."""
    while os.read(0, 1):
        pass
    os.killpg(0, signal.SIGKILL)


if __name__ == "__main__":
    main()
