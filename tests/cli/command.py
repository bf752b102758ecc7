"""Runs the real command in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

COMMAND = Path(sys.executable).with_name("rapc")

HOME = {k: v for k, v in os.environ.items() if k == "PYTHONPATH"}
"""Has the command import the same package as the tests."""

NOWHERE = {"RAPC_CACHE_DIR": os.devnull}
"""Keeps the command from keeping anything for the next test."""


def rapc(
    *args: str, cwd: Path | None = None, stdin: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run `rapc` with some arguments, and of the environment only where rapc is.

    No run may show a traceback, whatever it is given.
    """
    done = subprocess.run(
        [COMMAND, *args],
        cwd=cwd,
        input=stdin,
        env={"PATH": "", "LANG": "C.UTF-8", **HOME, **NOWHERE, **environment},
        capture_output=True,
        encoding="utf-8",
        timeout=120,
        check=False,
    )
    assert "Traceback" not in done.stderr
    assert "rapc itself is at fault" not in done.stderr
    return done
