"""Workers on this machine: processes, any of which may be lost.

Ctrl-C goes to all processes of a terminal. Here it reaches the one that waits for
results and no other: Pebble is asked for things with interrupts held back, so that no
pool is left half started or half stopped, and what is started meanwhile sees none.

If that process is killed nobody is left to end the others: each sees to it itself.
"""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import Future
from multiprocessing import resource_tracker
from threading import Thread

from pebble import ProcessPool

from rapc.base.interrupts import interrupts_held
from rapc.experiments.run import Job, Result, run_job

_Results = tuple[Result, ...]


def cores() -> int:
    """Return how many processes this machine can run at a time for us."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


class _Slot:
    """One process, in a pool of its own, and the job it was given last.

    The processes of one pool share a pipe and its locks: one that is killed while it
    takes a job from the pipe leaves the others without. So each has its own, and gets
    a new one when anything went wrong.
    """

    def __init__(self, time_limit: float) -> None:
        self._limit = time_limit
        self._pool = _pool()
        self._last: Future[_Results] | None = None

    @property
    def free(self) -> bool:
        return self._last is None or self._last.done()

    def submit(self, job: Job) -> Future[_Results]:
        if self._last is not None and self._last.exception() is not None:
            self._renew()
        try:
            self._last = self._pool.schedule(run_job, args=[job], timeout=self._limit)
        except (RuntimeError, OSError, EOFError) as error:
            self._last = Future()  # as if the process had been lost with the job
            self._last.set_exception(error)
        return self._last

    def _renew(self) -> None:
        self._pool.stop()
        Thread(target=self._pool.join, daemon=True).start()
        self._pool = _pool()

    def stop(self) -> None:
        self._pool.stop()

    def join(self) -> None:
        self._pool.join()


def _pool() -> ProcessPool:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["rapc.experiments.run"])
    return ProcessPool(max_workers=1, context=context, initializer=end_with_parent)


def end_with_parent() -> None:
    """Have this process end as soon as the one that started it does, however it does.

    It would go on with its run otherwise, which may be one without an end, and keep the
    server of processes waiting.
    """
    Thread(target=_wait_and_end, daemon=True).start()


def _wait_and_end() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


class LocalWorkers:
    """Processes of this machine; to be used with `with`, which ends them.

    Args:
        jobs: how many.
        time_limit: seconds that a run may take; the process that takes longer is
            killed, and a new one takes its place.
    """

    chunk = 1

    def __init__(self, jobs: int, time_limit: float) -> None:
        self._slots = [_Slot(time_limit) for _ in range(jobs)]
        self.room = jobs

    def __enter__(self) -> LocalWorkers:
        resource_tracker.ensure_running()  # its start lets interrupts in
        return self

    def __exit__(self, *raised: object) -> None:
        with interrupts_held():
            for slot in self._slots:
                slot.stop()
            for process in multiprocessing.active_children():
                process.kill()  # one that still starts would lament what is taken down
            for slot in self._slots:
                slot.join()

    def submit(self, job: Job) -> Future[_Results]:
        """Have `job` done by a process that is free, of which there must be one.

        A process that cannot be started is one that was lost: the future says so.
        """
        with interrupts_held():
            return next(slot for slot in self._slots if slot.free).submit(job)
