"""Where the `rapc` command begins and ends, and what Ctrl-C does there.

Apart from `rapc.cli.main`, which takes its time to import: nothing that is imported
before Ctrl-C is seen to may take any, `typing` and `contextlib` among it.
"""

from __future__ import annotations

import signal
import sys


def main() -> None:
    """Run the command line; no Ctrl-C, whenever it comes, makes a traceback.

    While nothing is there yet that could be lost, and again when all is done, Ctrl-C
    ends the process as the system does it. In between it is a `KeyboardInterrupt`.
    """
    wanted = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if wanted:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from rapc.base.gc_paused import gc_spared
    from rapc.base.interrupts import INTERRUPTED

    with gc_spared():
        from rapc.cli.main import main as run

    if not wanted:
        run()
        return
    try:
        try:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            run()
        finally:  # Python takes itself down now, and would tell of interrupts
            signal.signal(signal.SIGINT, signal.SIG_DFL)
    except KeyboardInterrupt:  # outside what `run` looks after
        sys.exit(INTERRUPTED)
