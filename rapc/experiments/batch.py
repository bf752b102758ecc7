"""Dispatch jobs to workers and yield their results.

Workers take a job and return a future: processes of this machine (`local`) or a
cluster (`cluster`). A job that is lost with its worker is tried again, run by run, a
bounded number of times.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from typing import Protocol

import msgspec

from rapc.errors import Error
from rapc.experiments.run import Job, PointConfig, Result

ATTEMPTS = 3
"""The number of attempts at a run before it is reported as lost."""


class WorkersLost(Error):
    """All workers that do the runs are gone."""


class Workers(Protocol):
    """Processes that execute runs. Any method may raise WorkersLost."""

    @property
    def room(self) -> int:
        """Return the useful number of concurrent jobs."""

    @property
    def chunk(self) -> int:
        """Return the highest useful number of runs of a job."""

    def submit(self, job: Job) -> Future[tuple[Result, ...]]:
        """Start `job`. The future's `TimeoutError` means an exceeded time limit."""


class BatchResult(msgspec.Struct, frozen=True):
    """Results of runs of one configuration."""

    config: PointConfig
    results: tuple[Result, ...]


class _Dispatch(msgspec.Struct, frozen=True):
    job: Job
    attempt: int


def jobs(
    missing: Iterable[tuple[PointConfig, Sequence[int]]], chunk: int
) -> Iterator[Job]:
    """Yield jobs of at most `chunk` seeds, one configuration after another in turn.

    `missing` has configurations with the seeds that they lack results for.
    """
    queues = deque((config, deque(seeds)) for config, seeds in missing if seeds)
    while queues:
        config, seeds = queues.popleft()
        taken = tuple(seeds.popleft() for _ in range(min(chunk, len(seeds))))
        yield Job(config, taken)
        if seeds:
            queues.append((config, seeds))


def run_batch(workers: Workers, work: Iterable[Job]) -> Iterator[BatchResult]:
    """Run jobs and yield their results in the order of arrival.

    Each run of each job is in exactly one result, with its measures or a fault.

    Raises:
        WorkersLost: if no workers are left.
    """
    waiting = iter(work)
    again: deque[_Dispatch] = deque()
    under_way: dict[Future[tuple[Result, ...]], _Dispatch] = {}
    try:
        while True:
            _fill(workers, waiting, again, under_way)
            if not under_way:
                break
            finished, _ = wait(under_way, return_when=FIRST_COMPLETED)
            for future in finished:
                given = under_way.pop(future)
                yield from _take(given, future, again)
    finally:
        for future in under_way:
            future.cancel()


def _fill(
    workers: Workers,
    waiting: Iterator[Job],
    again: deque[_Dispatch],
    under_way: dict[Future[tuple[Result, ...]], _Dispatch],
) -> None:
    while len(under_way) < workers.room:
        given = again.popleft() if again else None
        if given is None:
            job = next(waiting, None)
            if job is None:
                return
            given = _Dispatch(job, 1)
        under_way[workers.submit(given.job)] = given


def _take(
    given: _Dispatch, future: Future[tuple[Result, ...]], again: deque[_Dispatch]
) -> Iterator[BatchResult]:
    """Yield the results of `future`; put runs that were lost back into `again`.

    Runs that were lost too often, or took too long, get a fault as their result.
    """
    config, seeds = given.job.config, given.job.seeds
    error = CancelledError() if future.cancelled() else future.exception()
    if error is None:
        yield BatchResult(config, future.result())
    elif isinstance(error, TimeoutError):
        yield BatchResult(
            config,
            tuple(Result(s, None, "it took longer than the time limit") for s in seeds),
        )
    elif given.attempt < ATTEMPTS:
        again.extend(_Dispatch(Job(config, (s,)), given.attempt + 1) for s in seeds)
    else:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        lost = f"its worker was lost {ATTEMPTS} times, at last with {what}"
        yield BatchResult(config, tuple(Result(s, None, lost) for s in seeds))
