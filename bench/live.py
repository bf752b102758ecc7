"""A run with `--view` and a reader beside the same run with `--trace FILE` alone.

    python -m bench.live [--pairs N]

The runs are nine orders of the truck, and ten times that (`bench.viewer`). The cost is
the difference of the processor times of the two: the start of the command does not
count. The two commands of a pair take turns in being first.
"""

from __future__ import annotations

import argparse
import http.client
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import msgspec

from bench.viewer import orders

LIMIT = 1.05


class Taken(msgspec.Struct, frozen=True):
    """What a command took: seconds of the processor, and events each second."""

    cpu: float
    #: The events that the reader has received; 0 without a reader.
    events: int
    rate: float


def taken(times: int, file: Path, *, viewed: bool) -> Taken:
    """Run the orders with a trace, and a reader of the page if `viewed`."""
    run = (sys.executable, "-m", "rapc", "run", *orders(times), "--quiet")
    more = ("--view",) if viewed else ()
    with subprocess.Popen(
        (*run, "--trace", str(file), *more),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stderr is not None
        events, rate = 0, 0.0
        if viewed:
            address = process.stderr.readline().removeprefix("view: ").strip()
            events, rate = read(address)
            while "Ctrl-C" not in process.stderr.readline():
                pass
            process.send_signal(signal.SIGINT)
        process.stderr.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return Taken(usage.ru_utime + usage.ru_stime, events, rate)


def read(address: str) -> tuple[int, float]:
    """Read all events of a page; return their number, and the number each second."""
    _, _, host, token, _ = address.split("/")
    link = http.client.HTTPConnection(host, timeout=600)
    link.request("GET", f"/{token}/events")
    answer = link.getresponse()
    begun = time.perf_counter()
    events = sum(line.startswith(b'data: {"event"') for line in answer)
    link.close()
    return events, events / (time.perf_counter() - begun)


def pair(folder: Path, *, first: bool) -> tuple[float, float, Taken]:
    """Return the processor times of the run without and with a reader.

    Args:
        folder: a folder for traces.
        first: whether the run with a reader is the first.
    """
    found: dict[bool, list[Taken]] = {}
    for viewed in (first, not first):
        file = folder / f"{viewed}.jsonl"
        found[viewed] = [taken(times, file, viewed=viewed) for times in (1, 10)]
    assert (folder / "True.jsonl").read_bytes() == (folder / "False.jsonl").read_bytes()
    alone, both = (found[one][1].cpu - found[one][0].cpu for one in (False, True))
    return alone, both, found[True][1]


def pairs(count: int) -> list[tuple[float, float, Taken]]:
    """Return the figures of some pairs of runs."""
    with tempfile.TemporaryDirectory() as folder:
        return [pair(Path(folder), first=at % 2 == 1) for at in range(count)]


def ratio(figures: Sequence[tuple[float, float, Taken]]) -> float:
    """Return the least time with a reader over the least time without."""
    return min(both for _, both, _ in figures) / min(alone for alone, *_ in figures)


def main() -> None:
    """Measure, and print a line for each pair and the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pairs", type=int, default=5)
    figures = pairs(parser.parse_args().pairs)
    for alone, both, reader in figures:
        print(
            f"{alone:.2f} s with --trace, {both:.2f} s with --view: "
            f"{both / alone:.3f}; {reader.events} events, {reader.rate:.0f} each second"
        )
    median = statistics.median(both / alone for alone, both, _ in figures)
    print(f"least times {ratio(figures):.3f}, median {median:.3f}; limit {LIMIT}")


if __name__ == "__main__":
    main()
