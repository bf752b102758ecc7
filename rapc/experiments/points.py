"""The points of an experiment: the runs for each value of each part.

This module looks up all names of an experiment, and refuses unknown names before the
first run.
"""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import msgspec

from rapc.base.code_digest import digest_of_code
from rapc.base.files import STANDARD
from rapc.base.names import did_you_mean
from rapc.base.values import format_atom, typed
from rapc.base.version import VERSION
from rapc.compiler.program import Program
from rapc.errors import RefusedError, SettingError, TextError, WorldError
from rapc.experiments.definition import Experiment, ExperimentError, Series
from rapc.experiments.draws import Value, drawn, extremes, names_in, with_draws
from rapc.experiments.measures import LABELS
from rapc.experiments.run import PointConfig, counted_tasks, resolved
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import read_settings
from rapc.runtime.task_request import TaskRequest, as_text, of_agenda, read_task_request
from rapc.runtime.truth import figures_of
from rapc.spec import RunSpec
from rapc.world import World
from rapc.worlds import registry


class Point(msgspec.Struct, frozen=True):
    """One value of a part, and the configuration for it."""

    part: str
    value: Value | None
    config: PointConfig
    #: The hash of the configuration.
    digest: str
    #: The settings in the form of the command line, `owner.name` and value.
    texts: Mapping[str, str]
    #: The file or folder of the library.
    library: str
    #: The agenda, and the tasks besides.
    agenda: str | None
    tasks: tuple[str, ...]


def points(
    experiment: Experiment,
    folder: Path,
    load: Callable[[str], Program],
    *,
    timed: bool = False,
) -> tuple[Point, ...]:
    """Return the points of all parts, in order.

    Args:
        experiment: the experiment.
        folder: the folder of its file.
        load: returns the checked library of a file or folder.
        timed: whether the time of each run is divided; see `PointConfig`.

    Raises:
        ExperimentError: if a world, an option, a setting, an agenda, a RAP or a task of
            the experiment is unknown.
    """
    with _blamed():
        return tuple(_points(experiment, folder, load, timed))


def _points(
    experiment: Experiment, folder: Path, load: Callable[[str], Program], timed: bool
) -> Iterator[Point]:
    world = registry.find_world(experiment.world)
    for part in experiment.part:
        path = _named(part.library or experiment.library, folder)
        library = load(path)
        agenda, more = experiment.given(part)
        given = (*_of_agenda(library, agenda), *more)
        for problem in _unknown(experiment, part, library):
            raise problem
        for value in part.values or (None,):
            texts = _texts(experiment, part, value, folder)
            config = _config(experiment, library, world, texts, given)
            config = msgspec.structs.replace(config, timed=timed)
            _try(library, config)
            digest = config.digest()
            yield Point(part.name, value, config, digest, texts, path, agenda, more)


def _named(library: str, folder: Path) -> str:
    """Return the path of a library for commands, from its name in `folder`."""
    return library if library.startswith(STANDARD) else str(folder / library)


def command(experiment: Experiment, point: Point, seed: int) -> str:
    """Return the command line that repeats one run of a point."""
    values = drawn(experiment.draw, seed)
    words = ["rapc", "run", point.library, "--world", experiment.world]
    words += ["--seed", str(seed), "--until", format_atom(experiment.until)]
    for name, text in point.texts.items():
        words += ["--set", f"{name}={with_draws(text, values)}"]
    if point.agenda is not None:
        words += ["--agenda", point.agenda]
    for task in point.tasks:
        words += ["--task", with_draws(task, values)]
    return shlex.join(words)


@contextmanager
def _blamed() -> Iterator[None]:
    """Report unknown names and refused runs as errors of the experiment."""
    try:
        yield
    except (WorldError, SettingError) as error:
        raise ExperimentError(error.message, error.help) from error
    except RefusedError as refused:
        first, *more = refused.reasons
        more += registry.meant(refused)
        raise ExperimentError(first, "; ".join(more)) from refused


def _of_agenda(library: Program, name: str | None) -> tuple[str, ...]:
    """Return the tasks of an agenda of a library, as text."""
    tasks = () if name is None else of_agenda(library.library, name)
    return tuple([as_text(task) for task in tasks])


def _tasks(texts: Iterable[str]) -> list[TaskRequest]:
    tasks = []
    for number, text in enumerate(texts, 1):
        try:
            tasks.append(read_task_request(text))
        except TextError as error:
            raise ExperimentError(f"task {number}: {error}") from error
    return tasks


def _uncounted(config: PointConfig, tasks: Sequence[TaskRequest]) -> None:
    """Validate that there are tasks to count."""
    given = [str(task.goal[0]) for task in tasks if not task.background]
    if not given:
        message = "all tasks are in the background; at least one must be counted"
        raise ExperimentError(message)
    if not counted_tasks(tasks, config.counted):
        said = " and ".join(f"`{name}`" for name in config.counted)
        message = f"`counted`: no foreground task of the RAP {said}"
        raise ExperimentError(message, did_you_mean(config.counted[0], given))


def _unknown(
    experiment: Experiment, part: Series, library: Program
) -> Iterator[ExperimentError]:
    """Yield the unknown names in counts and in reference figures."""
    known = [*library.library.raps, *library.library.primitives]
    for name, what in experiment.count.items():
        if name in LABELS:
            yield ExperimentError(f"`count`: `{name}` is the name of a measure")
        if what not in known:
            message = f"`count`, {name}: no RAP or primitive is named `{what}`"
            yield ExperimentError(message, did_you_mean(what, known))
    measures = [*LABELS, *experiment.count, *experiment.figures]
    reference = part.reference
    named = {**reference.figures, **reference.bounds} if reference else {}
    for name in named:
        if name not in measures:
            message = f"part `{part.name}`: unknown measure `{name}`"
            yield ExperimentError(message, did_you_mean(name, measures))


def _texts(
    experiment: Experiment, part: Series, value: Value | None, folder: Path
) -> dict[str, str]:
    """Return all settings of a point by `owner.name`, as text for commands."""
    values: dict[str, Value] = {}
    for table in (experiment.set, part.set):
        for owner, settings in table.items():
            values |= {f"{owner}.{name}": value for name, value in settings.items()}
    if part.vary is not None and value is not None:
        values[part.vary] = value
    return {name: _text(given, folder) for name, given in values.items()}


def _text(value: Value, folder: Path) -> str:
    if isinstance(value, str) and value.startswith("@"):
        return f"@{folder / value[1:]}"
    return typed(value)


def _config(
    experiment: Experiment,
    library: Program,
    world: type[World],
    texts: Mapping[str, str],
    tasks: tuple[str, ...],
) -> PointConfig:
    names = experiment.draw
    open_ = {
        key: text
        for key, text in texts.items()
        if any(name in names for name in names_in(text))
    }
    settled = {key: text for key, text in texts.items() if key not in open_}
    options, own = registry.read_values(world, settled)
    defaults = {option.name: option.default for option in world.kit.options}
    spec = RunSpec(
        library=library.name,
        world=experiment.world,
        options={**registry.plain_values(defaults), **options},
        settings=read_settings(own).named(),
        tasks=tasks,
        until=experiment.until,
    )
    return PointConfig(
        rapc=VERSION,
        code=digest_of_code(world),
        spec=spec,
        sources=tuple((f.name, f.text) for f in library.library.files.values()),
        counted=experiment.counted,
        count=experiment.count,
        figures=experiment.figures,
        draws=experiment.draw,
        texts=open_,
    )


def _try(library: Program, config: PointConfig) -> None:
    """Validate that the world can be made, and that the tasks can be run in it.

    Drawn values are tested with each value, ranges with both ends.
    """
    for values in extremes(config.draws):
        settled = resolved(config, values)
        _uncounted(settled, _tasks(settled.spec.tasks))
        made = registry.world_of(settled.spec)
        Interpreter.prepared(library, made, settled.spec)
        _figures(made, config.figures)


def _figures(world: World, wanted: Sequence[str]) -> None:
    """Validate that a world has the requested figures."""
    told = figures_of(world)
    for name in wanted:
        if name in LABELS:
            raise ExperimentError(f"`figures`: `{name}` is the name of a measure")
        if name not in told:
            listed = f"it has {', '.join(told)}" if told else "it has none"
            message = f"`figures`: the world `{world.name}` has no figure `{name}`"
            raise ExperimentError(message, did_you_mean(name, told, listed))


def unit(world: type[World], vary: str) -> str:
    """Return the unit of the varied setting; empty if it has none."""
    owner, _, name = vary.partition(".")
    units = {option.name: option.unit for option in world.kit.options}
    return units.get(name, "") if owner == world.name else ""
