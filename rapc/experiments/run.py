"""One run, or several of one configuration: the job of a worker on any machine.

A worker is a separate process. Its job has all data of the run: a configuration
contains the text of the library. Only the compiled library is kept after a run.
"""

from __future__ import annotations

import hashlib
import threading
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache

import msgspec

from rapc.base.code_digest import digest_of_code
from rapc.base.source import SourceFile
from rapc.compiler.program import Program
from rapc.debug.account import Account
from rapc.debug.costs import times_of
from rapc.errors import Error
from rapc.events import DeadlineMissed, QueryFaulted, TaskSucceeded
from rapc.experiments.draws import Draws, drawn, with_draws
from rapc.experiments.measures import Measures, tasks_told
from rapc.host import find_plan
from rapc.library.loader import load_sources
from rapc.runtime.events.report import RunReport
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import read_settings
from rapc.runtime.task_request import TaskRequest
from rapc.spec import RunSpec
from rapc.worlds import registry


class PointConfig(msgspec.Struct, frozen=True):
    """The configuration of a run, and the requested measures."""

    rapc: str
    #: A digest of rapc and of the package of the world.
    code: str
    #: The start of a run without its seed; all options and settings are included.
    spec: RunSpec
    #: The files of the library, name and text, in the order of linking.
    sources: tuple[tuple[str, str], ...]
    counted: tuple[str, ...]
    count: Mapping[str, str]
    #: The requested ground-truth figures of the world.
    figures: tuple[str, ...] = ()
    #: Whether the time of a run is divided by kind, family and request.
    timed: bool = False
    #: The values that each seed draws; their names are in braces in the spec and in
    #: `texts`.
    draws: Draws = {}
    #: Options and settings with a drawn value, by `owner.name`.
    texts: Mapping[str, str] = {}

    def as_json(self) -> bytes:
        """Return the configuration as JSON, with a digest of the library's text.

        The JSON has no paths of files: an equal library in a different folder has an
        equal configuration.
        """
        texts = "\0".join(text for _, text in self.sources)
        digest = hashlib.sha256(texts.encode(errors="replace")).hexdigest()
        spec = msgspec.structs.replace(self.spec, library="", digest=digest)
        plain = {**msgspec.structs.asdict(self), "spec": spec}
        del plain["sources"]
        return msgspec.json.encode(plain, order="deterministic")

    def digest(self) -> str:
        """Return the hash under which results are stored."""
        return hashlib.sha256(self.as_json()).hexdigest()[:16]


def resolved(config: PointConfig, values: Mapping[str, str]) -> PointConfig:
    """Return `config` with the drawn values inserted, without draws.

    Raises:
        WorldError, SettingError: for an invalid option or setting.
    """
    if not config.draws:
        return config
    spec = config.spec
    texts = {name: with_draws(text, values) for name, text in config.texts.items()}
    options, own = registry.read_values(registry.find_world(spec.world), texts)
    settings = read_settings(own).named(own)
    spec = msgspec.structs.replace(
        spec,
        tasks=tuple([with_draws(task, values) for task in spec.tasks]),
        options={**spec.options, **options},
        settings={**spec.settings, **settings},
    )
    return msgspec.structs.replace(config, spec=spec, draws={}, texts={})


class Job(msgspec.Struct, frozen=True):
    """Runs of one configuration under some seeds."""

    config: PointConfig
    seeds: tuple[int, ...]


class Result(msgspec.Struct, frozen=True):
    """The result of a run: its measures, or the reason why they are missing.

    `trace` is the traceback of an error, for a developer; `seconds` is the processor
    time of the run.
    """

    seed: int
    measures: Measures | None
    fault: str = ""
    trace: str = ""
    seconds: float = 0
    #: The data of an observer of the run; empty without an observer.
    observed: bytes = b""


class OtherCode(Error):
    """A worker has a different version of rapc than the process that sent the job."""


Observe = Callable[[Interpreter], object]
"""A function that is called with a run before the run starts."""


def run_job(job: Job) -> tuple[Result, ...]:
    """Run a configuration under each seed of a job.

    A run that raises an error has a fault as its result; the other runs continue.
    """
    return tuple([run_one(job.config, seed) for seed in job.seeds])


def run_one(config: PointConfig, seed: int, observe: Observe | None = None) -> Result:
    """Run a configuration under a seed; an error is a fault of the result."""
    began = time.process_time()
    try:
        measures = measure(config, seed, observe)
    except Exception as error:  # any error is reported with its seed
        what = " ".join(f"{type(error).__name__}: {error}".split())
        return Result(seed, None, what, traceback.format_exc())
    return Result(seed, measures, seconds=time.process_time() - began)


def measure(config: PointConfig, seed: int, observe: Observe | None = None) -> Measures:
    """Run a configuration under a seed, as `rapc run` does, and measure the run.

    Raises:
        OtherCode: if a different version of rapc made the configuration.
    """
    config = resolved(config, drawn(config.draws, seed))
    spec = msgspec.structs.replace(config.spec, seed=seed)
    world_class = registry.find_world(spec.world_class or spec.world)
    if digest_of_code(world_class) != config.code:
        raise OtherCode("the worker has another version of rapc or of the world")
    world = registry.world_of(spec)
    library = _compiled(spec.library, config.sources, threading.get_ident())
    interpreter = Interpreter.prepared(library, world, spec, planner=find_plan)
    report = RunReport()
    interpreter.listen(report, *RunReport.kinds, TaskSucceeded)
    account = Account(world.kit.offer.sensors)
    if config.timed:
        interpreter.listen(account, *Account.kinds)
    if observe is not None:
        observe(interpreter)
    interpreter.start()
    reason = interpreter.run(until=spec.until)
    account.close(interpreter.now)
    raps = [
        str(task.goal[0])
        for task in counted_tasks(interpreter.first_tasks, config.counted)
    ]
    told = tasks_told(raps, interpreter.results())
    ends = [task.outcome for task in told]
    completed, given_up = ends.count("succeeded"), ends.count("failed")
    figures = interpreter.figures() if config.figures else {}
    looked = sum(report.primitives[name] for name in set(world.kit.offer.sensors))
    return Measures(
        reason=reason,
        disaster=world.ended(),
        time=interpreter.now,
        completed=completed,
        given_up=given_up,
        pending=len(raps) - completed - given_up,
        effector=report.primitives.total() - looked,
        sensor=looked,
        failed=report.failures.total(),
        counts={name: report.well(what) for name, what in config.count.items()},
        missed_deadlines=report.others[DeadlineMissed],
        query_faults=report.others[QueryFaulted],
        figures={name: figures[name] for name in config.figures},
        tasks=told,
        times=times_of(account) if config.timed else None,
    )


def counted_tasks(
    tasks: Sequence[TaskRequest], raps: Sequence[str]
) -> list[TaskRequest]:
    """Return the counted tasks: of some RAPs, or all in the foreground."""
    return [
        task
        for task in tasks
        if not task.background and (not raps or task.goal[0] in raps)
    ]


@lru_cache(maxsize=16)
def _compiled(name: str, sources: tuple[tuple[str, str], ...], thread: int) -> Program:
    """Return a compiled library from its texts, which are already checked.

    The library compiles queries at their first use, so each thread has a separate
    library.
    """
    files = [SourceFile(file, text) for file, text in sources]
    return Program(load_sources(files).library, name)
