"""What a command takes: processor time, time on the clock, and peak memory.

A process of its own that imports nothing of rapc: the peak that the system tells of a
child counts what its parent had in memory when it was made.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from typing import TypedDict


class Taken(TypedDict):
    """Seconds of the processor and of the clock, and the peak of memory in MB."""

    cpu: float
    wall: float
    peak: float


def take(command: Sequence[str], environment: Mapping[str, str]) -> Taken:
    """Run a command to its end, its output thrown away, and tell what it took.

    Raises:
        CalledProcessError: if it ends with another status than 0.
    """
    launched = [sys.executable, __file__, *command]
    done = subprocess.run(
        launched, env=environment, capture_output=True, text=True, check=True
    )
    taken: Taken = json.loads(done.stdout)
    return taken


def main() -> None:
    """Run the command that the arguments are, and print what it took as JSON."""
    nothing = (os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)
    start = time.perf_counter()
    command = sys.argv[1:]
    process = os.posix_spawnp(command[0], command, os.environ, file_actions=[nothing])
    _, status, usage = os.wait4(process, 0)
    wall = time.perf_counter() - start
    if status:
        sys.exit(os.waitstatus_to_exitcode(status))
    cpu = usage.ru_utime + usage.ru_stime
    print(json.dumps({"cpu": cpu, "wall": wall, "peak": usage.ru_maxrss / 1024}))


if __name__ == "__main__":
    main()
