"""Delay of Ctrl-C during operations that must not be interrupted."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager

INTERRUPTED = 130
"""The exit status of a command after Ctrl-C."""


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Block Ctrl-C while the block runs, and raise it at the end of the block.

    Processes and threads started in the block inherit the blocked signal, and never
    receive Ctrl-C. On systems without signal masks Ctrl-C is not blocked.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
