"""Run tests in several processes, with the outcomes in the order of the tests.

Each process reads the tests itself: a library with its compiled program is no message
between processes.
"""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from typing import Any

from rapc.experiments.local import end_with_parent
from rapc.testing import discover
from rapc.testing.run import Case, Outcome
from rapc.testing.session import TestSession


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
        concurrent.futures.process.BrokenProcessPool: if a process was lost.
    """
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["rapc.testing.parallel"])
    pool = ProcessPoolExecutor(min(jobs, len(cases)), context, _begin)
    run = partial(_run, session, tuple(paths))
    try:
        for case, parts in zip(cases, pool.map(run, range(len(cases))), strict=True):
            yield Outcome(case, *parts)
    except BaseException:  # after Ctrl-C no process may finish its tests first
        for process in multiprocessing.active_children():
            process.kill()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _begin() -> None:
    """Prepare a process; Ctrl-C concerns only its parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()


def _run(session: TestSession, paths: tuple[str, ...], index: int) -> tuple[Any, ...]:
    """Run a test; return the fields of its outcome after the test itself."""
    outcome = session.run_one(_cases(paths)[index])
    return tuple([getattr(outcome, name) for name in Outcome.__struct_fields__[1:]])


@cache
def _cases(paths: tuple[str, ...]) -> Sequence[Case]:
    """Read the tests, once in each process."""
    return discover.find(paths).cases
