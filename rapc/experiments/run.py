"""One run, or several of one configuration: what a worker does, wherever it is.

A worker is a process of its own. It gets all it needs with the job, and nothing that a
run does outlasts the run but the compiled library.
"""

from __future__ import annotations

import threading
import time
import traceback
from collections.abc import Sequence
from functools import lru_cache

import msgspec

from rapc.base.source import SourceFile
from rapc.compiler.program import Program
from rapc.errors import Error
from rapc.experiments.config import PointConfig, digest_of_code, resolved
from rapc.experiments.draws import drawn
from rapc.experiments.measures import Measures, Tally, figures_of, tasks_told
from rapc.library.loader import load_sources
from rapc.runtime.prepare import prepare
from rapc.runtime.task_request import TaskRequest
from rapc.worlds import registry


class Job(msgspec.Struct, frozen=True):
    """Runs of one configuration under some seeds."""

    config: PointConfig
    seeds: tuple[int, ...]


class Result(msgspec.Struct, frozen=True):
    """What came of a run: its measures, or why there are none, in a line.

    `trace` is where an error came from, for a developer; `seconds` of processor time
    were spent.
    """

    seed: int
    measures: Measures | None
    fault: str = ""
    trace: str = ""
    seconds: float = 0


class OtherCode(Error):
    """A worker has another rapc than the one that gave it the job."""


def run_job(job: Job) -> tuple[Result, ...]:
    """Run a configuration under each seed of a job.

    A run that raises an error is a result with a fault: the others go on.
    """
    return tuple([_run(job.config, seed) for seed in job.seeds])


def _run(config: PointConfig, seed: int) -> Result:
    began = time.process_time()
    try:
        measures = measure(config, seed)
    except Exception as error:  # whatever it is, it is told with its seed
        what = " ".join(f"{type(error).__name__}: {error}".split())
        return Result(seed, None, what, traceback.format_exc())
    return Result(seed, measures, seconds=time.process_time() - began)


def measure(config: PointConfig, seed: int) -> Measures:
    """Run a configuration under a seed, as `rapc run` does, and measure it.

    Raises:
        OtherCode: if the configuration was made by another rapc.
    """
    config = resolved(config, drawn(config.draws, seed))
    spec = msgspec.structs.replace(config.spec, seed=seed)
    world_class = registry.find_world(spec.world)
    if digest_of_code(world_class) != config.code:
        raise OtherCode("the worker has another version of rapc or of the world")
    options = registry.check_options(world_class, spec.options)
    world = registry.build_world(world_class, seed, options)
    library = _compiled(spec.library, config.sources, threading.get_ident())
    ready = prepare(library, world, spec)
    tally = Tally(world.kit.offer, config.count)
    ready.interpreter.listen(tally, *Tally.kinds)
    interpreter = ready.begin()
    reason = interpreter.run(until=spec.until)
    raps = [str(task.goal[0]) for task in counted_tasks(ready.tasks, config.counted)]
    told = tasks_told(raps, interpreter.results())
    ends = [task.outcome for task in told]
    completed, given_up = ends.count("succeeded"), ends.count("failed")
    figures = figures_of(world) if config.figures else {}
    return Measures(
        reason=reason,
        disaster=world.ended(),
        time=interpreter.now,
        completed=completed,
        given_up=given_up,
        pending=len(raps) - completed - given_up,
        effector=tally.effector,
        sensor=tally.sensor,
        failed=tally.failed,
        counts=tally.counts(),
        missed_deadlines=tally.missed_deadlines,
        query_faults=tally.query_faults,
        figures={name: figures[name] for name in config.figures},
        tasks=told,
    )


def counted_tasks(
    tasks: Sequence[TaskRequest], raps: Sequence[str]
) -> list[TaskRequest]:
    """The tasks that are counted: those of some RAPs, or all in the foreground."""
    return [
        task
        for task in tasks
        if not task.background and (not raps or task.goal[0] in raps)
    ]


@lru_cache(maxsize=16)
def _compiled(name: str, sources: tuple[tuple[str, str], ...], thread: int) -> Program:
    """A library from its texts, which were checked where they were read.

    It compiles queries when they are first asked, so each thread has its own.
    """
    files = [SourceFile(file, text) for file, text in sources]
    return Program(load_sources(files).library, name)
