"""A batch on a Dask scheduler with two workers, one of which is killed."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread

import pytest

from rapc.experiments import cluster
from rapc.experiments.batch import WorkersLost
from rapc.experiments.cluster import ClusterWorkers
from rapc.experiments.run import Job, run_job

from .small_experiment import TRUCK, rows, session, wait_for, watched


@contextmanager
def dask(folder: Path, program: str, *args: str) -> Iterator[subprocess.Popen[str]]:
    """One of Dask's programs on loopback, killed at the end: it does not go itself."""
    module = f"distributed.cli.dask_{program}"
    with subprocess.Popen(
        [sys.executable, "-m", module, *args, "--no-dashboard"],
        cwd=folder,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def worker(folder: Path, address: str) -> list[str]:
    own = ["--no-nanny", "--nthreads", "1", "--host", "127.0.0.1"]
    return ["worker", address, *own, "--local-directory", str(folder)]


@pytest.mark.slow
def test_a_worker_killed_in_the_middle_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "truck.toml").write_text(TRUCK)
    with dask(tmp_path, "scheduler", "--host", "127.0.0.1", "--port", "0") as scheduler:
        address = wait_for(scheduler, "Scheduler at:").split()[-1]
        asked = worker(tmp_path, address)
        with dask(tmp_path, *asked) as one, dask(tmp_path, *asked) as two:
            wait_for(one, "Registered to")
            wait_for(two, "Registered to")
            args = ("experiment", "truck.toml", "--cluster", address, "--out", "out")
            with watched("-v", *args, cwd=tmp_path) as process:
                wait_for(process, "done in")
                one.kill()
                _, told = process.communicate()
                assert (process.returncode, "error" in told) == (0, False)
    undisturbed = {
        (point.digest, result.seed): result.measures
        for point in session().points
        for result in run_job(Job(point.config, tuple(range(5))))
    }
    kept = {(digest, seed): found for digest, seed, found in rows(tmp_path / "out")}
    assert len(kept) == 20
    assert kept == undisturbed


@pytest.mark.parametrize("address", ["nobody", "10.0.0.5", "http://127.0.0.1:8787", ""])
def test_invalid_address_is_reported(address: str) -> None:
    said = f"^`{re.escape(address)}` is not an address of a Dask scheduler"
    with pytest.raises(WorkersLost, match=said):
        ClusterWorkers(address, 1)


def test_a_server_of_another_kind_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "_PATIENCE", 0.1)
    with socket.create_server(("127.0.0.1", 0)) as server:
        place = f"127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(
            WorkersLost, match=f"^no Dask scheduler answers at `{place}`"
        ):
            ClusterWorkers(place, 1)


def test_unexpected_greeting_of_a_server_is_reported() -> None:
    """What it says would make a length of some exabytes."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        place = f"127.0.0.1:{server.getsockname()[1]}"

        def greet() -> None:
            line, _ = server.accept()
            line.sendall(b"220 mail.example.org ESMTP\r\n")
            line.close()

        thread = Thread(target=greet)
        thread.start()
        said = f"^no Dask scheduler answers at `{place}`"
        with pytest.raises(WorkersLost, match=said):
            ClusterWorkers(place, 1)
        thread.join()


def test_a_scheduler_without_workers_is_told(tmp_path: Path) -> None:
    (tmp_path / "truck.toml").write_text(TRUCK)
    with dask(tmp_path, "scheduler", "--host", "127.0.0.1", "--port", "0") as scheduler:
        address = wait_for(scheduler, "Scheduler at:").split()[-1]
        place = address.removeprefix("tcp://")
        args = ("experiment", "truck.toml", "--cluster", place, "--out", "out")
        with watched(*args, cwd=tmp_path) as process:
            wait_for(process, f"`{place}` has no workers; waiting")
            process.send_signal(signal.SIGINT)
            assert process.wait() == 130
