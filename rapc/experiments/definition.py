"""What an experiment is: library, world, tasks, what varies, seeds.

How it is read from a file is in `reading`; whether what it names exists is found out
by `points`, which has the library and the world.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

import msgspec
from msgspec import Meta

from rapc.base.names import did_you_mean
from rapc.errors import Error
from rapc.experiments.draws import Draw, Value

MOST_SEEDS = 100_000
"""How many runs a point may get."""

_Name = Annotated[str, Meta(pattern=r"^[a-z0-9][a-z0-9-]{0,30}\Z")]
_Time = Annotated[int, Meta(gt=0, le=10**9)] | Annotated[float, Meta(gt=0, le=10**9)]
_Settings = Mapping[str, Mapping[str, Value]]


class ExperimentError(Error):
    """An experiment that cannot be run as it is written down."""


class Reference(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Figures from elsewhere, to stand beside ours."""

    #: Says in a word whose they are.
    title: str
    #: For each measure, by its name, as many numbers as `at` has values.
    figures: Mapping[str, tuple[int | float, ...]]
    #: Values of what the part varies.
    at: tuple[Value, ...] = ()
    #: For a measure what is said in words: a value of `vary`, from how much, to what.
    bounds: Mapping[str, tuple[tuple[Value, float, float], ...]] = {}
    #: Whether nothing can go below them: a line in plots, and compared with nothing.
    least: bool = False


class PlotMark(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A value on the axis of what varies that is worth a mark, and why."""

    at: int | float
    label: str


class Series(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One series of points: one option or setting varied, or a single point."""

    name: _Name
    title: str = ""
    #: A library, an agenda or tasks in place of those of the experiment.
    library: Annotated[str, Meta(min_length=1)] | None = None
    agenda: str | None = None
    tasks: tuple[str, ...] | None = None
    #: The `world.option` or `rapc.setting` that varies, and its values.
    vary: str | None = None
    values: tuple[Value, ...] = ()
    #: What is set besides what is set for all.
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
    #: A path, seen from the file of the experiment.
    library: Annotated[str, Meta(min_length=1)]
    world: str
    #: The time at which a run is stopped.
    until: _Time
    part: Annotated[tuple[Series, ...], Meta(min_length=1)]
    title: str = ""
    #: An agenda of the library, and tasks as for `rapc run --task`, given after its.
    agenda: str | None = None
    tasks: tuple[str, ...] = ()
    #: What each seed draws, by the name that stands in braces for it.
    draw: Mapping[_Name, Draw] = {}
    seeds: Annotated[int, Meta(ge=1, le=MOST_SEEDS)] = 30
    #: The seed of the first run of each point; the others follow it.
    first_seed: Annotated[int, Meta(ge=0, le=10**9)] = msgspec.field(
        name="first-seed", default=0
    )
    #: How many seconds a run may take.
    time_limit: _Time = msgspec.field(name="time-limit", default=120)
    #: RAPs whose tasks are counted; none: all tasks that are not in the background.
    counted: tuple[str, ...] = ()
    #: RAPs and primitives whose successes are counted, by what they are called.
    count: Mapping[_Name, str] = {}
    #: Which of the world's figures about the truth are shown.
    figures: tuple[str, ...] = ()
    set: _Settings = {}

    def given(self, part: Series) -> tuple[str | None, tuple[str, ...]]:
        """Return the agenda and the tasks of `part`: its own, or the experiment's.

        A part that has either of its own has none of the experiment's.
        """
        if part.agenda is not None or part.tasks is not None:
            return part.agenda, part.tasks or ()
        return self.agenda, self.tasks

    def part_named(self, name: str) -> Series:
        """Return the part that is called `name`.

        Raises:
            ExperimentError: if there is none.
        """
        named = {part.name: part for part in self.part}
        if name not in named:
            raise ExperimentError(
                f"the experiment `{self.name}` has no part `{name}`",
                did_you_mean(name, named, f"it has {', '.join(named)}"),
            )
        return named[name]
