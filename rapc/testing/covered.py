"""Coverage of the runs of an experiment: the job of a worker, and the sum.

Each worker counts for its runs; the process that distributes the jobs adds the counts.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import msgspec
from msgspec.structs import replace

from rapc.experiments.run import Job, Result, run_one
from rapc.runtime.interpreter import Interpreter
from rapc.testing.coverage import Coverage, FileCoverage

_FILES = msgspec.msgpack.Decoder(tuple[FileCoverage, ...])

_NOT_COUNTS = ("row",)
"""The numbers in a record that are no counts."""


def run_covered(job: Job) -> tuple[Result, ...]:
    """Run a configuration under each seed of a job, with the coverage of each run."""
    return tuple([_run(job, seed) for seed in job.seeds])


def _run(job: Job, seed: int) -> Result:
    coverage = Coverage()

    def observe(run: Interpreter) -> None:
        coverage.begin(run.library.library)
        run.listen(coverage)
        run.watch_contexts(coverage.context)

    result = run_one(job.config, seed, observe)
    return replace(result, observed=msgspec.msgpack.encode(coverage.files()))


class CoverageSum:
    """The coverage of many runs."""

    def __init__(self) -> None:
        self._files: dict[str, FileCoverage] = {}

    def add(self, results: Iterable[Result]) -> None:
        """Add the counts of runs of `run_covered`."""
        for result in results:
            for file in _FILES.decode(result.observed) if result.observed else ():
                known = self._files.get(file.file)
                self._files[file.file] = file if known is None else _sum(known, file)

    def files(self) -> tuple[FileCoverage, ...]:
        """Return the counts of all files, by name."""
        return tuple([self._files[name] for name in sorted(self._files)])


def _sum(one: Any, other: Any) -> Any:
    """Return the sum of two records of the same thing."""
    if isinstance(one, msgspec.Struct):
        names = one.__struct_fields__
        added = {
            name: _sum(getattr(one, name), getattr(other, name))
            for name in names
            if name not in _NOT_COUNTS
        }
        return replace(one, **added)
    if isinstance(one, tuple):
        return tuple([_sum(a, b) for a, b in zip(one, other, strict=True)])
    if isinstance(one, Mapping):
        keys = sorted({*one, *other})
        return {key: one.get(key, 0) + other.get(key, 0) for key in keys}
    return one + other if isinstance(one, int) else one
