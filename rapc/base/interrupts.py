"""Delay of Ctrl-C during operations that must not be interrupted, and lost Ctrl-C."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

INTERRUPTED = 130
"""The exit status of a command after Ctrl-C."""

_SOON = 0.001
"""The seconds after which a lost Ctrl-C is sent again."""


def resend_lost_interrupts() -> None:
    """Send Ctrl-C again whenever Python drops its exception.

    Python only prints an exception in the callback of a weak reference or in `__del__`;
    each import ends with such a callback. On systems without signals for threads
    nothing changes.
    """
    if not hasattr(signal, "pthread_kill"):
        return
    main, usual = threading.get_ident(), sys.unraisablehook

    def send() -> None:
        time.sleep(_SOON)
        signal.pthread_kill(main, signal.SIGINT)

    def dropped(told: Any) -> None:
        if told.exc_type is KeyboardInterrupt:
            _thread.start_new_thread(send, ())  # takes no lock of `threading`
        else:
            usual(told)

    sys.unraisablehook = dropped


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


@contextmanager
def terminations_as_interrupts(
    delay: Callable[[], bool] = lambda: False,
) -> Iterator[None]:
    """Let SIGTERM raise `KeyboardInterrupt` in the block, as Ctrl-C does.

    A thread other than the main thread cannot handle signals: there, nothing changes.
    A process that ignores Ctrl-C still ignores it.

    Args:
        delay: called for each signal; if it returns True, nothing is raised now.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        if not delay():
            signal.default_int_handler(number, frame)

    signals = [signal.SIGTERM]
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signals.append(signal.SIGINT)
    before = {one: signal.signal(one, interrupt) for one in signals}
    try:
        yield
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
