"""Runs from a journal go on with a peer that outlives the interpreter."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from pathlib import Path

import pytest

LIBRARY = """
(declare-primitive carry (?parcel) (okay)
  :atomic false
  :on (okay (carried ?parcel)))
(declare-memory-proposition carried (?parcel))
(declare-memory-proposition parcel (?parcel))
(define-rap (carry-all)
  (succeed (not (and (parcel ?parcel) (not (carried ?parcel)))))
  (repeat-while (and (parcel ?parcel) (not (carried ?parcel))))
  (method (context (and (parcel ?parcel) (not (carried ?parcel))))
          (primitive (carry ?parcel))))
"""


@pytest.mark.slow
def test_each_request_is_done_once_through_8_kills(tmp_path: Path) -> None:
    carry(tmp_path, parcels=40, kills=8, seed=1)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(20))
def test_each_request_is_done_once_through_10_kills(seed: int, tmp_path: Path) -> None:
    carry(tmp_path, parcels=150, kills=10, seed=seed)


def permit(requests: int, limit: Path) -> None:
    """Write the number of requests that the porter may end."""
    limit.with_suffix(".new").write_text(str(requests))
    limit.with_suffix(".new").replace(limit)


def carry(tmp_path: Path, *, parcels: int, kills: int, seed: int) -> None:
    """Kill a run at random moments, resume it, and check the requests of the peer."""
    library, log, limit = (tmp_path / name for name in ("go.rap", "log", "limit"))
    library.write_text(LIBRARY)
    log.touch()
    permit(parcels, limit)
    environment = {**os.environ, "PORTER_LOG": str(log), "PORTER_LIMIT": str(limit)}
    address = f"unix:{tmp_path}/porter"
    served = [sys.executable, "-m", "rapc.worlds.remote"]
    served += ["tests.worlds.remote.porter:Porter", address]
    server = subprocess.Popen(
        served, stderr=subprocess.PIPE, text=True, env=environment
    )
    assert server.stderr is not None
    server.stderr.readline()
    rapc = [sys.executable, "-m", "rapc", "-q", "run"]
    begin = [*rapc, str(library), "--world", address, "--task", "(carry-all)"]
    begin += ["--journal", str(tmp_path / "journal")]
    for n in range(parcels):
        begin += ["--fact", f"(parcel p{n})"]
    resume = [*rapc, "--resume", str(tmp_path / "journal")]
    rng, command, done = random.Random(seed), begin, 0
    try:
        while True:
            lines = len(log.read_text().splitlines())
            few = rng.randint(1, parcels // (kills + 2))
            # the run is not over before the last kill, however late that is
            permit(parcels if done == kills else lines + few, limit)
            run = subprocess.Popen(command, stdout=subprocess.PIPE)
            while (
                run.poll() is None and len(log.read_text().splitlines()) < lines + few
            ):
                time.sleep(0.005)
            time.sleep(rng.random() * 0.03)
            if run.poll() is None and done < kills:
                run.kill()
                done += 1
                run.communicate()
                command = resume
                continue
            told, _ = run.communicate(timeout=60)
            break
    finally:
        server.kill()
        server.communicate()
    assert done == kills
    assert run.returncode == 0, told
    requests = [line.split() for line in log.read_text().splitlines()]
    assert [parcel for _, parcel in requests] == [f"p{n}" for n in range(parcels)]
