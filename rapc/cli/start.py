"""The start and the end of the `rapc` command, and its handling of Ctrl-C.

Separate from `rapc.cli.main`, which takes time to import. Before Ctrl-C is handled,
this module imports no slow module, not even `signal`, `typing` or `contextlib`.
"""

from __future__ import annotations

import _signal as signal  # type: ignore[import-not-found]  # without its enumerations
import sys


def main() -> None:
    """Run the command line; Ctrl-C never causes a traceback.

    Before the command starts, and after its end, Ctrl-C ends the process by the
    system's default. In between, Ctrl-C raises `KeyboardInterrupt`.
    """
    wanted = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if wanted:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from rapc.base.gc_paused import gc_spared
    from rapc.base.interrupts import INTERRUPTED, resend_lost_interrupts

    with gc_spared():
        from rapc.cli.main import main as run

    if not wanted:
        run()
        return
    resend_lost_interrupts()
    try:
        try:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            run()
        finally:  # the exit of Python would print interrupts
            signal.signal(signal.SIGINT, signal.SIG_DFL)
    except KeyboardInterrupt:  # outside the handling of `run`
        sys.exit(INTERRUPTED)
