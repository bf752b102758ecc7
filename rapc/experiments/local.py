"""Workers on this machine: processes, each of which may be lost.

Ctrl-C goes to all processes of a terminal. Only the process that waits for results must
receive it. Calls of Pebble hold interrupts back, so that no pool is half started or
half stopped, and processes that start meanwhile receive no interrupt.

If the waiting process is killed, no process is left to end the others: each worker
watches its parent and ends itself.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import Future
from multiprocessing import resource_tracker
from threading import Thread
from typing import Generic, TypeVar

from pebble import ProcessExpired, ProcessPool

from rapc.base.interrupts import interrupts_held

J = TypeVar("J")
R = TypeVar("R")

LOST = ProcessExpired
"""The error of a future whose process was lost with the job, or did not start."""


def cores() -> int:
    """Return the number of processes that this machine can run for rapc at a time."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _Slot(Generic[J, R]):
    """One process, in a separate pool, and its latest job.

    The processes of one pool share a pipe and its locks: a process that is killed while
    it takes a job from the pipe blocks the other processes. So each process has a
    separate pool, and gets a new pool after any error.
    """

    def __init__(self, work: Callable[[J], R], time_limit: float | None) -> None:
        self._work, self._limit = work, time_limit
        self._pool = _pool(work)
        self._last: Future[R] | None = None

    @property
    def free(self) -> bool:
        return self._last is None or self._last.done()

    def submit(self, job: J) -> Future[R]:
        if self._last is not None and self._last.exception() is not None:
            self._renew()
        try:
            self._last = self._pool.schedule(
                self._work, args=[job], timeout=self._limit
            )
        except (RuntimeError, OSError, EOFError) as error:
            self._last = Future()  # as if the process was lost with the job
            what = f"{type(error).__name__}: {error}"
            self._last.set_exception(ProcessExpired(what))
        return self._last

    def _renew(self) -> None:
        self._pool.stop()
        Thread(target=self._pool.join, daemon=True).start()
        self._pool = _pool(self._work)

    def stop(self) -> None:
        self._pool.stop()

    def join(self) -> None:
        """Wait for the threads of the pool, at most `_LAST_WAIT` seconds.

        An interrupt between two instructions of the pool may leave a lock held for
        ever. The processes are dead by then, and the threads end with this process.
        """
        joining = Thread(target=self._pool.join, daemon=True)
        joining.start()
        joining.join(_LAST_WAIT)


_LAST_WAIT = 5.0
"""Seconds to wait for the threads of a stopped pool."""


def _pool(work: Callable[[J], R]) -> ProcessPool:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([work.__module__])
    return ProcessPool(max_workers=1, context=context, initializer=_end_with_parent)


def _end_with_parent() -> None:
    """Start a thread that ends this process when its parent ends in any way.

    Otherwise the process would continue its run, which may be endless, and keep the
    server of processes waiting.
    """
    Thread(target=_wait_and_end, daemon=True).start()


def _wait_and_end() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


class LocalWorkers(Generic[J, R]):
    """Processes of this machine; to be used with `with`, which ends the processes.

    Args:
        jobs: the number of processes.
        work: the function of a module that carries out a job.
        time_limit: seconds that a job may take; a process that takes longer is killed
            and replaced by a new process. None: no limit.
    """

    chunk = 1

    def __init__(
        self, jobs: int, work: Callable[[J], R], time_limit: float | None = None
    ) -> None:
        self._slots = [_Slot(work, time_limit) for _ in range(jobs)]
        self.room = jobs

    def __enter__(self) -> LocalWorkers[J, R]:
        resource_tracker.ensure_running()  # its start permits interrupts
        return self

    def __exit__(self, *raised: object) -> None:
        with interrupts_held():
            for slot in self._slots:
                slot.stop()
            for process in multiprocessing.active_children():
                process.kill()  # a starting process would print errors
            for slot in self._slots:
                slot.join()

    def submit(self, job: J) -> Future[R]:
        """Run `job` on a free process; at least one process must be free.

        A process that cannot be started counts as lost: the future has the error.
        """
        with interrupts_held():
            return next(slot for slot in self._slots if slot.free).submit(job)
