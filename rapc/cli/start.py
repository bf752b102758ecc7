"""Where the `rapc` command begins: nothing is imported yet that takes its time.

Apart from `rapc.cli.main` for that reason alone.
"""

from __future__ import annotations

import signal
from typing import TYPE_CHECKING

from rapc.base.gc_paused import gc_spared
from rapc.base.later import later

if TYPE_CHECKING:
    from rapc.cli import main as command_line
else:
    command_line = later("rapc.cli.main")


def main() -> None:
    """Run the command line; Ctrl-C before it stands ends the process without a word."""
    wanted = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if wanted:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    with gc_spared():
        run = command_line.main

    if wanted:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    run()
