"""Workers on this machine: a pool of processes that survives the loss of any of them."""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import Future
from types import TracebackType

from pebble import ProcessPool

from rapc.experiments.run import Job, Result, run_job


def cores() -> int:
    """How many processes this machine runs at a time for us."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (
        os.cpu_count() or 1
    )


class LocalWorkers:
    """Processes of this machine; to be used with `with`, which ends them.

    Args:
        jobs: how many.
        time_limit: seconds that a run may take; the process that takes longer is
            killed, and a new one takes its place.
    """

    chunk = 1

    def __init__(self, jobs: int, time_limit: float) -> None:
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(["rapc.experiments.run"])
        self.room = 2 * jobs
        self._limit = time_limit
        self._pool = ProcessPool(max_workers=jobs, context=context)

    def __enter__(self) -> LocalWorkers:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._pool.stop()
        self._pool.join()

    def submit(self, job: Job) -> Future[tuple[Result, ...]]:
        """Have a job done by the next process that is free."""
        return self._pool.schedule(run_job, args=[job], timeout=self._limit)
