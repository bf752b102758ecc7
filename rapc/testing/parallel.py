"""Run tests in several processes, with the outcomes in the order of the tests.

Each process reads the tests itself: a library with its compiled program is no message
between processes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from functools import cache
from typing import Any

from rapc.experiments.batch import WorkersLost
from rapc.experiments.local import LOST, LocalWorkers
from rapc.testing import discover
from rapc.testing.run import Case, Outcome
from rapc.testing.session import TestSession

_Job = tuple[TestSession, tuple[str, ...], int]
"""The options, the files and folders of the tests, and the position of a test."""


def run_parallel(
    session: TestSession, paths: Sequence[str], cases: Sequence[Case], jobs: int
) -> Iterator[Outcome]:
    """Yield the outcome of each test, in order, from `jobs` processes.

    Args:
        session: the options, without coverage.
        paths: the files and folders of the tests, without standard input.
        cases: the tests in these paths.
        jobs: the number of processes.

    Raises:
        WorkersLost: if a process was lost.
    """
    waiting = deque(range(len(cases)))
    under_way: dict[Future[tuple[Any, ...]], int] = {}
    done: dict[int, tuple[Any, ...]] = {}
    with LocalWorkers(min(jobs, len(cases)), _run) as workers:
        for number, case in enumerate(cases):
            while number not in done:
                while waiting and len(under_way) < workers.room:
                    future = workers.submit((session, tuple(paths), waiting[0]))
                    under_way[future] = waiting.popleft()
                for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                    done[under_way.pop(future)] = _result(future)
            yield Outcome(case, *done.pop(number))


def _result(future: Future[tuple[Any, ...]]) -> tuple[Any, ...]:
    try:
        return future.result()
    except LOST as error:
        raise WorkersLost("a process ended before its test") from error


def _run(job: _Job) -> tuple[Any, ...]:
    """Run a test; return the fields of its outcome after the test itself."""
    session, paths, number = job
    outcome = session.run_one(_cases(paths)[number])
    return tuple([getattr(outcome, name) for name in Outcome.__struct_fields__[1:]])


@cache
def _cases(paths: tuple[str, ...]) -> Sequence[Case]:
    """Read the tests, once in each process."""
    return discover.find(paths).cases
