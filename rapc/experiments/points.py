"""The points of an experiment: what is run for each value of each part.

Here everything that an experiment names is looked up, and refused if it is not there,
before the first run.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

from rapc.base.values import format_atom
from rapc.base.version import VERSION
from rapc.compiler.program import Program
from rapc.errors import RefusedError, SettingError, TextError, WorldError
from rapc.experiments.config import Config, code_of, plain_options, world_options
from rapc.experiments.definition import Experiment, ExperimentError, Part, Value, meant
from rapc.experiments.measures import LABELS
from rapc.experiments.run import counted
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import read_settings
from rapc.runtime.task_request import TaskRequest, read_task_request
from rapc.world import World
from rapc.worlds import registry

OWN = "rapc"
"""The owner of the interpreter's settings, beside that of a world's options."""


class Point(msgspec.Struct, frozen=True):
    """One value of a part, and what is run for it.

    `digest` is the configuration's hash; `texts` are the settings as the command line
    takes them, `owner.name` and value.
    """

    part: str
    value: Value | None
    config: Config
    digest: str
    texts: Mapping[str, str]


def points(
    experiment: Experiment,
    library: Program,
    folder: Path,
    parts: Iterable[Part],
) -> tuple[Point, ...]:
    """The points of some parts, in order.

    `library` has been checked; `folder` is where the experiment's file lies.

    Raises:
        ExperimentError: if the experiment names a world, an option, a setting, a RAP
            or a task that is not there.
    """
    world = _world(experiment)
    tasks = _tasks(experiment)
    for problem in _unknown(experiment, library, tasks):
        raise problem
    found = []
    for part in parts:
        for value in part.values or (None,):
            texts = _texts(experiment, part, value, folder)
            config = _config(experiment, library, world, texts)
            _try(library, world, config, tasks)
            found.append(Point(part.name, value, config, config.digest(), texts))
    return tuple(found)


def command(experiment: Experiment, point: Point, library: Path, seed: int) -> str:
    """The command line that repeats one run of a point."""
    words = ["rapc", "run", str(library), "--world", experiment.world]
    words += ["--seed", str(seed), "--until", format_atom(experiment.until)]
    for name, text in point.texts.items():
        words += ["--set", f"{name}={text}"]
    for task in experiment.tasks:
        words += ["--task", task]
    return shlex.join(words)


def _world(experiment: Experiment) -> type[World]:
    try:
        return registry.find_world(experiment.world)
    except WorldError as error:
        raise ExperimentError(error.message, error.help) from error


def _tasks(experiment: Experiment) -> list[TaskRequest]:
    tasks = []
    for number, text in enumerate(experiment.tasks, 1):
        try:
            tasks.append(read_task_request(text))
        except TextError as error:
            raise ExperimentError(f"task {number}: {error}") from error
    return tasks


def _unknown(
    experiment: Experiment, library: Program, tasks: Sequence[TaskRequest]
) -> Iterator[ExperimentError]:
    """What is to be counted, or has figures, and is not there."""
    given = [str(task.goal[0]) for task in tasks if not task.background]
    for name in experiment.counted:
        if name not in given:
            message = f"`counted`: no task in the foreground is one of `{name}`"
            yield ExperimentError(message, meant(name, given))
    if not counted(tasks, experiment.counted):
        message = "all tasks are in the background: there is none to count"
        yield ExperimentError(message)
    known = [*library.library.raps, *library.library.primitives]
    for name, what in experiment.count.items():
        if name in LABELS:
            yield ExperimentError(f"`count`, {name}: a measure is called so already")
        if what not in known:
            message = f"`count`, {name}: no RAP or primitive is named `{what}`"
            yield ExperimentError(message, meant(what, known))
    measures = [*LABELS, *experiment.count]
    for part in experiment.part:
        for name in part.reference.figures if part.reference else ():
            if name not in measures:
                message = f"part `{part.name}`: there is no measure `{name}`"
                yield ExperimentError(message, meant(name, measures))


def _texts(
    experiment: Experiment, part: Part, value: Value | None, folder: Path
) -> dict[str, str]:
    """All settings of a point by `owner.name`, as text for the command line."""
    values: dict[str, Value] = {}
    for table in (experiment.set, part.set):
        for owner, settings in table.items():
            values |= {f"{owner}.{name}": value for name, value in settings.items()}
    if part.vary is not None and value is not None:
        values[part.vary] = value
    return {name: _text(given, folder) for name, given in values.items()}


def _text(value: Value, folder: Path) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f"@{folder / value[1:]}" if value.startswith("@") else value
    return format_atom(value)


def _config(
    experiment: Experiment,
    library: Program,
    world: type[World],
    texts: Mapping[str, str],
) -> Config:
    own, theirs = _by_owner(world, texts)
    try:
        options = registry.read_options(world, theirs)
        settings = read_settings(own)
    except WorldError as error:
        raise ExperimentError(error.message, error.help) from error
    except SettingError as error:
        raise ExperimentError(str(error)) from error
    return Config(
        rapc=VERSION,
        code=code_of(world),
        library=library.name,
        sources=tuple((f.name, f.text) for f in library.library.files.values()),
        world=experiment.world,
        options=plain_options(world, options),
        settings=msgspec.structs.asdict(settings),
        tasks=experiment.tasks,
        until=experiment.until,
        counted=experiment.counted,
        count=experiment.count,
    )


def _by_owner(
    world: type[World], texts: Mapping[str, str]
) -> tuple[dict[str, str], dict[str, str]]:
    own: dict[str, str] = {}
    theirs: dict[str, str] = {}
    for key, text in texts.items():
        owner, _, name = key.partition(".")
        if owner not in (OWN, world.name):
            raise ExperimentError(
                f"`{key}`: `{owner}` is neither `{OWN}` nor `{world.name}`",
                meant(owner, [OWN, world.name]),
            )
        (own if owner == OWN else theirs)[name] = text
    return own, theirs


def _try(
    library: Program,
    world: type[World],
    config: Config,
    tasks: Sequence[TaskRequest],
) -> None:
    """See that a world can be made so, and that the tasks can be run in it."""
    options = world_options(world, config.options)
    try:
        made = registry.build_world(world, 0, options)
        Interpreter(library, made).check(tasks)
    except WorldError as error:
        raise ExperimentError(error.message, error.help) from error
    except RefusedError as refused:
        first, *more = refused.reasons
        raise ExperimentError(first, "; ".join(more)) from refused


def unit(world: type[World], vary: str) -> str:
    """The unit of what is varied; empty if it has none."""
    owner, _, name = vary.partition(".")
    units = {option.name: option.unit for option in world.kit.options}
    return units.get(name, "") if owner == world.name else ""
