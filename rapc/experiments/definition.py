"""Definition of an experiment: library, world, tasks, varied setting, seeds.

An experiment is read from TOML: a file that comes with rapc, or a file of the user.
This module validates the form and the consistency of the file. `points`, which has the
library and the world, validates the names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from rapc.base import toml
from rapc.base.files import read_text
from rapc.base.names import did_you_mean
from rapc.errors import Error, LoadError
from rapc.experiments.draws import Between, Draw, Value, names_in

MOST_SEEDS = 100_000
"""The highest number of runs of a point."""

SUFFIX = ".toml"
"""The suffix of the files of experiments."""

_Name = Annotated[str, Meta(pattern=r"^[a-z0-9][a-z0-9-]{0,30}\Z")]
_Time = Annotated[int, Meta(gt=0, le=10**9)] | Annotated[float, Meta(gt=0, le=10**9)]
_Settings = Mapping[str, Mapping[str, Value]]


class ExperimentError(Error):
    """An experiment with an invalid definition."""


class Reference(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Figures from elsewhere, for comparison with the measured figures."""

    #: The source of the figures, in a word.
    title: str
    #: For each measure, by its name, as many numbers as `at` has values.
    figures: Mapping[str, tuple[int | float, ...]]
    #: Values of the varied setting.
    at: tuple[Value, ...] = ()
    #: Verbal ranges of a measure: a value of `vary`, the low and the high end.
    bounds: Mapping[str, tuple[tuple[Value, float, float], ...]] = {}
    #: Whether the figures are a lower bound: a line in plots, without comparison.
    least: bool = False


class PlotMark(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A marked value on the axis of the varied setting, with its reason."""

    at: int | float
    label: str


class Series(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One series of points: one varied option or setting, or a single point."""

    name: _Name
    title: str = ""
    #: A library, an agenda or tasks that replace those of the experiment.
    library: Annotated[str, Meta(min_length=1)] | None = None
    agenda: str | None = None
    tasks: tuple[str, ...] | None = None
    #: The varied `world.option` or `rapc.setting`, and its values.
    vary: str | None = None
    values: tuple[Value, ...] = ()
    #: Options and settings of this part, in addition to those of the experiment.
    set: _Settings = {}
    #: Names of parts that are drawn into the same plot.
    beside: tuple[str, ...] = ()
    mark: PlotMark | None = None
    #: Sentences printed below the table.
    notes: tuple[str, ...] = ()
    reference: Reference | None = None


class Experiment(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A whole experiment."""

    name: str
    #: A path, relative to the file of the experiment.
    library: Annotated[str, Meta(min_length=1)]
    world: str
    #: The time at which a run is stopped.
    until: _Time
    part: Annotated[tuple[Series, ...], Meta(min_length=1)]
    title: str = ""
    #: An agenda of the library, and tasks as for `rapc run --task`, added after its
    #: tasks.
    agenda: str | None = None
    tasks: tuple[str, ...] = ()
    #: The values that each seed draws, by their name in braces.
    draw: Mapping[_Name, Draw] = {}
    seeds: Annotated[int, Meta(ge=1, le=MOST_SEEDS)] = 30
    #: The seed of the first run of each point; the other seeds follow.
    first_seed: Annotated[int, Meta(ge=0, le=10**9)] = msgspec.field(
        name="first-seed", default=0
    )
    #: The time limit of a run, in seconds.
    time_limit: _Time = msgspec.field(name="time-limit", default=120)
    #: RAPs whose tasks are counted; none: all tasks that are not in the background.
    counted: tuple[str, ...] = ()
    #: RAPs and primitives whose successes are counted, by the name of the measure.
    count: Mapping[_Name, str] = {}
    #: The ground-truth figures of the world in the tables.
    figures: tuple[str, ...] = ()
    set: _Settings = {}

    def given(self, part: Series) -> tuple[str | None, tuple[str, ...]]:
        """Return the agenda and the tasks of `part`: its own, or the experiment's.

        A part with its own agenda or tasks has neither from the experiment.
        """
        if part.agenda is not None or part.tasks is not None:
            return part.agenda, part.tasks or ()
        return self.agenda, self.tasks

    def part_named(self, name: str) -> Series:
        """Return the part with the name `name`.

        Raises:
            ExperimentError: if the part is unknown.
        """
        named = {part.name: part for part in self.part}
        if name not in named:
            raise ExperimentError(
                f"the experiment `{self.name}` has no part `{name}`",
                did_you_mean(name, named, f"it has {', '.join(named)}"),
            )
        return named[name]


# --- read from TOML -------------------------------------------------------------------


def shipped() -> Mapping[str, Path]:
    """Return the experiments that come with rapc, by name."""
    files = sorted(Path(__file__).parent.glob(f"*{SUFFIX}"))
    return {file.name.removesuffix(SUFFIX): file for file in files}


def experiment_file(name: str) -> Path:
    """Return the file of an experiment: shipped with rapc, or a path to a TOML file.

    Raises:
        ExperimentError: if the experiment does not exist.
    """
    if name.endswith(SUFFIX):
        return Path(name)
    known = shipped()
    if name not in known:
        listed = f"name {', '.join(known)}, or a file that ends in `{SUFFIX}`"
        raise ExperimentError(
            f"unknown experiment `{name}`", did_you_mean(name, known, listed)
        )
    return known[name]


def read_experiment(file: Path) -> Experiment:
    """Read and decode a file.

    Raises:
        ExperimentError: for a file that cannot be read or is not an experiment.
    """
    try:
        text = read_text(file)
    except LoadError as error:
        raise ExperimentError(str(error)) from error
    try:
        return decode_experiment(text, file.name.removesuffix(SUFFIX))
    except ExperimentError as error:
        raise ExperimentError(f"{file}: {error.message}", error.help) from error


def decode_experiment(text: str, name: str) -> Experiment:
    """Return an experiment from TOML text.

    Raises:
        ExperimentError: for invalid TOML, unknown keys, values of the wrong kind, and
            contradictions.
    """
    try:
        data = toml.parsed(text)
        for where, key, known in _unknown(data):
            raise ExperimentError(
                f"unknown key `{key}`{where}", did_you_mean(key, known)
            )
        found = toml.converted({**data, "name": name}, Experiment)
    except toml.TomlError as error:
        raise ExperimentError(error.message) from error
    for problem in _contradictions(found):
        raise ExperimentError(problem)
    return found


def _unknown(data: Mapping[str, Any]) -> Iterator[tuple[str, str, list[str]]]:
    """Yield unknown keys with their position, and the known keys there."""

    def look(
        table: object, kind: type[msgspec.Struct], where: str
    ) -> Iterator[tuple[str, str, list[str]]]:
        known = [field.encode_name for field in msgspec.structs.fields(kind)]
        if kind is Experiment:
            known.remove("name")
        if isinstance(table, Mapping):
            yield from ((where, key, known) for key in table if key not in known)

    yield from look(data, Experiment, "")
    parts = data.get("part")
    for number, part in enumerate(parts if isinstance(parts, list) else (), 1):
        yield from look(part, Series, f" in part {number}")
        for key, kind in (("reference", Reference), ("mark", PlotMark)):
            inner = part.get(key) if isinstance(part, Mapping) else None
            yield from look(inner, kind, f" in `{key}` of part {number}")
    draws = data.get("draw")
    for name, draw in draws.items() if isinstance(draws, Mapping) else ():
        yield from look(draw, Between, f" in `{name}` of `draw`")


# --- contradictions -------------------------------------------------------------------


def _contradictions(experiment: Experiment) -> Iterator[str]:
    """Yield the contradictions of an experiment, as text."""
    if experiment.library == "-":
        yield "`library`: expected a file, not standard input"
    yield from _about_tasks(experiment)
    names = [part.name for part in experiment.part]
    for part in experiment.part:
        told = f"part `{part.name}`"
        if names.count(part.name) > 1:
            yield f"duplicate {told}"
        if (part.vary is None) != (not part.values):
            yield f"{told} requires both `vary` and `values`, or neither"
        if len(set(map(repr, part.values))) < len(part.values):
            yield f"{told} has a duplicate value"
        if part.mark is not None and part.vary is None:
            yield f"`mark` of {told} requires `vary`"
        others = {p.name for p in experiment.part if p.vary == part.vary and p.vary}
        yield from (
            f"{told} has `beside` `{other}`, which is not a part with the same `vary`"
            for other in part.beside
            if other not in others - {part.name}
        )
        yield from _misfits(part, told)


def _misfits(part: Series, told: str) -> Iterator[str]:
    """Yield errors of reference figures: each value needs exactly one figure."""
    if part.reference is None:
        return
    many = len(part.reference.at) if part.vary is not None else 1
    if part.vary is None and part.reference.at:
        yield f"`at` in the reference of {told} requires `vary`"
        return
    for value in part.reference.at:
        if value not in part.values:
            what = f"reference figures at {value}, which is not in its `values`"
            yield f"{told} has {what}"
    for measure, bounds in part.reference.bounds.items():
        for value, low, high in bounds:
            if value not in part.values:
                what = (
                    f"a bound of `{measure}` at {value}, which is not in its `values`"
                )
                yield f"{told} has {what}"
            if low > high:
                yield f"{told} has a bound of `{measure}` with `to` less than `from`"
    for measure, figures in part.reference.figures.items():
        if len(figures) != many:
            yield (
                f"{told} has {len(figures)} reference figures for `{measure}`, "
                f"expected {many}"
            )


def _about_tasks(experiment: Experiment) -> Iterator[str]:
    """Yield parts without a task, unused draws and undefined draws."""
    for part in experiment.part:
        agenda, tasks = experiment.given(part)
        if agenda is None and not tasks:
            yield f"part `{part.name}` requires `agenda` or `tasks`"
    used = dict.fromkeys(name for text in _texts(experiment) for name in names_in(text))
    for name, draw in experiment.draw.items():
        if name not in used:
            yield f"`draw`, {name}: no task and no option has `{{{name}}}`"
        if isinstance(draw, Between) and draw.low > draw.high:
            yield f"`draw`, {name}: `from` is greater than `to`"
        elif not isinstance(draw, Between) and not draw:
            yield f"`draw`, {name}: the list is empty"
    for part in experiment.part:
        for task in experiment.given(part)[1]:
            for name in names_in(task):
                if name not in experiment.draw:
                    yield f"a task has `{{{name}}}`, which `draw` does not have"


def _texts(experiment: Experiment) -> Iterator[str]:
    """Yield the texts that may contain a drawn value."""
    for part in experiment.part:
        yield from experiment.given(part)[1]
        yield from (value for value in part.values if isinstance(value, str))
    for table in (experiment.set, *[part.set for part in experiment.part]):
        for settings in table.values():
            yield from (text for text in settings.values() if isinstance(text, str))
