"""Workers of a Dask cluster that runs already, through its futures."""

from __future__ import annotations

from concurrent.futures import Future
from types import TracebackType

from distributed import Client

from rapc.experiments.run import Job, Result, run_job

_RUNS = 8
"""How many runs make a job, at most: giving one out takes Dask some milliseconds."""


class ClusterError(Exception):
    """A cluster that cannot be reached; one line."""


class ClusterWorkers:
    """The workers of a scheduler; to be used with `with`.

    Args:
        address: the scheduler's, as `tcp://host:8786`.
        runs: how many are to be done in all.

    Raises:
        ClusterError: if nobody answers there.
    """

    def __init__(self, address: str, runs: int) -> None:
        try:
            self._client = Client(address, timeout=10, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise ClusterError(f"no Dask scheduler answers at `{address}`") from error
        self._executor = self._client.get_executor(retries=2, pure=False)
        self._runs = runs

    def __enter__(self) -> ClusterWorkers:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._executor.shutdown(wait=False)
        self._client.close()

    @property
    def room(self) -> int:
        """A few jobs for each thread that the workers have now; they may come and go."""
        return 4 * max(1, sum(self._client.nthreads().values()))

    @property
    def chunk(self) -> int:
        """Few runs if there are few, so that all workers have some."""
        return max(1, min(_RUNS, self._runs // self.room))

    def submit(self, job: Job) -> Future[tuple[Result, ...]]:
        """Have a job done by a worker that the scheduler chooses."""
        future: Future[tuple[Result, ...]] = self._executor.submit(run_job, job)
        return future
