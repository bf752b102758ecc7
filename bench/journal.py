"""Runs with a journal beside runs without one: the processor time, in pairs.

    python -m bench.journal [--pairs N]

The journal does not wait for the disk. Each run is a process of its own, forked from
one that has read the library. The two runs of a pair follow each other, and take turns
to be the first. A ratio is the median over the pairs.
"""

from __future__ import annotations

import argparse
import os
import statistics
import struct
import sys
import tempfile
import time
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import rapc
from bench.common import inputs
from rapc.compiler.program import Program
from rapc.durable.folder import Options
from rapc.durable.runs import begin
from rapc.runtime.interpreter import Interpreter
from rapc.spec import RunSpec

RUNS: Mapping[str, tuple[str, RunSpec]] = {
    "nine orders": (
        "stdlib/truck",
        RunSpec(world="truck", agenda="nine-orders", options={"shuffle_interval": 15}),
    ),
    "hallway": ("stdlib/hallway", RunSpec(world="hallway", agenda="errand")),
}

LIMITS = {"silent": 1.15, "--trace": 1.10}
"""The highest ratio, by what both runs of a pair do."""


class Row(NamedTuple):
    """The processor time of a run in seconds, and the ratio with a journal."""

    run: str
    both: str
    without: float
    ratio: float


def taken(
    program: Program, spec: RunSpec, folder: Path, *, trace: bool, journal: bool
) -> float:
    """Return the processor time of a run in seconds, in a process of its own."""
    told, tell = os.pipe()
    process = os.fork()
    if not process:
        os.close(told)
        try:
            world = rapc.open_world(spec.world, seed=spec.seed, **spec.options)
            run = Interpreter.prepared(program, world, spec)
            file = folder / "trace.jsonl" if trace else None
            start = time.process_time()
            if journal:
                durable = begin(folder / "j", run, Options(sync="off"), trace=file)
                durable.go()
                durable.close()
            elif file is None:
                run.run()
            else:
                with file.open("w") as stream:
                    run.listen(rapc.JsonTrace(stream))
                    run.run()
            os.write(tell, struct.pack("d", time.process_time() - start))
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            os._exit(1)
    os.close(tell)
    with os.fdopen(told, "rb") as stream:
        data = stream.read()
    os.waitpid(process, 0)
    (seconds,) = struct.unpack("d", data)  # fails if the run has failed
    return float(seconds)


def row(name: str, both: str, pairs: int) -> Row:
    """Measure a run with and without a journal."""
    library, spec = RUNS[name]
    program = rapc.load(inputs() / library).program
    found: dict[bool, list[float]] = {False: [], True: []}
    for pair in range(pairs):
        for journal in (False, True) if pair % 2 else (True, False):
            with tempfile.TemporaryDirectory() as folder:
                seconds = taken(
                    program,
                    spec,
                    Path(folder),
                    trace=both == "--trace",
                    journal=journal,
                )
            found[journal].append(seconds)
    ratios = [b / a for a, b in zip(found[False], found[True], strict=True)]
    return Row(name, both, statistics.median(found[False]), statistics.median(ratios))


def main() -> None:
    """Print the ratios; exit with status 1 if one is above its limit."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--pairs", type=int, default=9, help="9 if not given")
    pairs = parser.parse_args().pairs
    above = False
    print("| run | both | processor time in s | with a journal | limit |")
    print("|---|---|---:|---:|---:|")
    for name in RUNS:
        for both, limit in LIMITS.items():
            found = row(name, both, pairs)
            above |= found.ratio > limit
            shown = f"{found.without:.2f} | {found.ratio:.3f} | {limit}"
            print(f"| {name} | {both} | {shown} |", flush=True)
    sys.exit(above)


if __name__ == "__main__":
    main()
