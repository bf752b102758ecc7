"""Batches on this machine: nothing is lost with a worker, and a result is a result."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterable
from importlib import import_module
from multiprocessing import forkserver
from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest

from rapc.base import code_digest
from rapc.experiments.batch import BatchResult, jobs, run_batch
from rapc.experiments.local import LocalWorkers
from rapc.experiments.run import Job, Result, run_job

from .small_experiment import config, session

SEEDS = range(8)


def drain(batch: Iterable[BatchResult]) -> list[Result]:
    return [result for done in batch for result in done.results]


def test_a_worker_killed_in_the_middle_changes_nothing() -> None:
    truck = config()
    with LocalWorkers(2, run_job, 60) as workers:
        batch = run_batch(workers, jobs([(truck, SEEDS)], workers.chunk))
        results = list(next(batch).results)
        killed = multiprocessing.active_children()[0].pid
        assert killed is not None
        os.kill(killed, signal.SIGKILL)
        results += drain(batch)
    results.sort(key=attrgetter("seed"))
    undisturbed = run_job(Job(truck, tuple(SEEDS)))
    assert [r.seed for r in results] == list(SEEDS)
    assert [r.measures for r in results] == [r.measures for r in undisturbed]
    assert all(result.measures is not None for result in results)


def test_failed_process_start_counts_as_a_try(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The server that makes processes is lost, as it is being asked for the first."""
    connect = forkserver.connect_to_new_process
    tries = []

    def lost_at_first(*args: Any) -> Any:
        tries.append(args)
        if len(tries) == 1:
            raise ConnectionRefusedError("nobody is there")
        return connect(*args)

    monkeypatch.setattr(forkserver, "connect_to_new_process", lost_at_first)
    with LocalWorkers(1, run_job, 60) as workers:
        results = drain(run_batch(workers, jobs([(config(), range(2))], workers.chunk)))
    assert [result.fault for result in results] == ["", ""]
    assert len(tries) > 1


def test_jobs_take_turns() -> None:
    one, two, none = (point.config for point in session().points[:3])
    work = jobs([(one, [0, 1, 2]), (two, [5]), (none, [])], 2)
    expected = [(one, (0, 1)), (two, (5,)), (one, (2,))]
    assert [(job.config, job.seeds) for job in work] == expected


def test_hash_covers_only_inputs_of_the_run() -> None:
    digests = [point.digest for point in session().points]
    assert digests[1] == digests[2]
    assert len(set(digests)) == 4
    other = session().points[0].config
    assert other.digest() == digests[0]


def test_digest_of_code_leaves_out_examples(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A wheel has the examples as files, a checkout has a link to them."""
    (tmp_path / "arm" / "examples").mkdir(parents=True)
    (tmp_path / "arm" / "__init__.py").write_text("class World: pass")
    monkeypatch.syspath_prepend(tmp_path)
    digests = []
    for text in ("1", "2"):
        (tmp_path / "arm" / "examples" / "home.py").write_text(text)
        code_digest._digest_of.cache_clear()
        digests.append(code_digest.digest_of_code(import_module("arm").World))
    code_digest._digest_of.cache_clear()
    assert len(set(digests)) == 1
