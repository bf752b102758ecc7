"""Workers of a running Dask cluster, through its futures."""

from __future__ import annotations

import logging
import socket
import sys
from concurrent.futures import Future

from distributed import Client
from distributed.comm.addressing import get_address_host_port, parse_address

from rapc.experiments.batch import WorkersLost
from rapc.experiments.run import Job, Result, run_job

_RUNS = 8
"""The highest number of runs of a job: Dask needs some milliseconds for each job."""

_LENGTH = 8
"""The number of bytes of a length on the wire."""

_MOST_TO_GREET = 1_000_000
"""The highest accepted number of bytes of a greeting."""

_PATIENCE = 10
"""The time limit for the answer of a scheduler, in seconds."""


class ClusterWorkers:
    """The workers of a scheduler; to be used with `with`.

    Args:
        address: the scheduler's address, as `tcp://host:8786`.
        runs: the number of all runs.

    Raises:
        WorkersLost: if no scheduler answers at the address.
    """

    def __init__(self, address: str, runs: int) -> None:
        for name in ("distributed", "distributed.client"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
        self._address = address
        self._runs = runs
        try:
            host, port = get_address_host_port(address)
        except ValueError as error:
            written = "is not an address of a Dask scheduler such as tcp://host:8786"
            raise WorkersLost(f"`{address}` {written}") from error
        try:
            _knock(host, port, speaks=parse_address(address)[0] == "tcp")
            self._client = Client(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise self._lost() from error
        self._executor = self._client.get_executor(retries=2, pure=False)

    def __enter__(self) -> ClusterWorkers:
        return self

    def __exit__(self, *raised: object) -> None:
        self._executor.shutdown(wait=False)
        self._client.close()

    @property
    def threads(self) -> int:
        """Return the present number of threads: workers may come and go."""
        try:
            return sum(self._client.nthreads().values())
        except OSError as error:
            raise self._lost() from error

    @property
    def room(self) -> int:
        """Return a few jobs for each thread."""
        return 4 * max(1, self.threads)

    @property
    def chunk(self) -> int:
        """Return a small number for few runs, so that all workers have runs."""
        return max(1, min(_RUNS, self._runs // self.room))

    def submit(self, job: Job) -> Future[tuple[Result, ...]]:
        """Start a job on a worker that the scheduler chooses."""
        future: Future[tuple[Result, ...]] = self._executor.submit(run_job, job)
        return future

    def _lost(self) -> WorkersLost:
        return WorkersLost(f"no Dask scheduler answers at `{self._address}`")


def _knock(host: str, port: int, *, speaks: bool) -> None:
    """Validate that a scheduler answers, which speaks first without encryption.

    The scheduler begins with the length of its message. A Dask client that cannot
    connect prints many messages; a client of a different kind of server would wait for
    ever, or read the greeting of a mail server as a length. Raises OSError.
    """
    with socket.create_connection((host, port), timeout=_PATIENCE) as line:
        if not speaks:
            return
        length = b""
        while len(length) < _LENGTH:
            more = line.recv(_LENGTH - len(length))
            if not more:
                raise ConnectionError("it closed the connection")
            length += more
        if int.from_bytes(length, sys.byteorder) > _MOST_TO_GREET:
            raise ConnectionError("it uses another protocol")
