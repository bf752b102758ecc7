"""What an experiment is, read from TOML: library, world, tasks, what varies, seeds.

Says whether a file has the right form; whether what it names exists is found out by
`points`, which has the library and the world.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from rapc.base import toml
from rapc.base.files import read_text
from rapc.base.names import nearest
from rapc.errors import Error, LoadError

SUFFIX = ".toml"

MOST_SEEDS = 100_000
"""How many runs a point may get."""

Value = bool | int | float | str
"""A value of an option or setting as TOML has it."""

_Name = Annotated[str, Meta(pattern=r"^[a-z0-9][a-z0-9-]{0,30}\Z")]
_Time = Annotated[int, Meta(gt=0, le=10**9)] | Annotated[float, Meta(gt=0, le=10**9)]
_Settings = Mapping[str, Mapping[str, Value]]


class ExperimentError(Error):
    """An experiment that cannot be run as it is written down."""


class Reference(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Figures from elsewhere, to stand beside ours.

    `at` are values of what the part varies, `figures` as many numbers for each
    measure, by its name; `title` says in a word whose they are.
    """

    title: str
    figures: Mapping[str, tuple[int | float, ...]]
    at: tuple[Value, ...] = ()


class Mark(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A value on the axis of what varies that is worth a mark, and why."""

    at: int | float
    label: str


class Part(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One series of points: one option or setting varied, or a single point.

    `vary` is `world.option` or `rapc.setting`; `set` is said besides; `beside` names
    parts drawn into the same plot; `notes` are printed below the table.
    """

    name: _Name
    title: str = ""
    vary: str | None = None
    values: tuple[Value, ...] = ()
    set: _Settings = {}
    beside: tuple[str, ...] = ()
    mark: Mark | None = None
    notes: tuple[str, ...] = ()
    reference: Reference | None = None


class Experiment(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A whole experiment.

    `library` is a path, seen from the file of the experiment; `tasks` are written as
    for `rapc run --task`, `until` is the time at which a run is stopped, `counted`
    names the RAPs whose tasks are counted (all that are not in the background if it is
    empty), `count` RAPs and primitives whose successes are, by what they are called;
    `time-limit` is how many seconds a run may take.
    """

    name: str
    library: Annotated[str, Meta(min_length=1)]
    world: str
    tasks: Annotated[tuple[str, ...], Meta(min_length=1)]
    until: _Time
    part: Annotated[tuple[Part, ...], Meta(min_length=1)]
    title: str = ""
    seeds: Annotated[int, Meta(ge=1, le=MOST_SEEDS)] = 30
    #: The seed of the first run of each point; the others follow it.
    first_seed: Annotated[int, Meta(ge=0, le=10**9)] = msgspec.field(
        name="first-seed", default=0
    )
    time_limit: _Time = msgspec.field(name="time-limit", default=120)
    counted: tuple[str, ...] = ()
    count: Mapping[_Name, str] = {}
    set: _Settings = {}

    def part_named(self, name: str) -> Part:
        """The part of a name.

        Raises:
            ExperimentError: if there is none.
        """
        named = {part.name: part for part in self.part}
        if name not in named:
            raise ExperimentError(
                f"the experiment `{self.name}` has no part `{name}`",
                meant(name, named) or f"it has {', '.join(named)}",
            )
        return named[name]


def meant(name: str, names: Sequence[str] | Mapping[str, Any]) -> str:
    """Return a suggestion for a mistyped name, or an empty text."""
    near = nearest(name, names)
    return f"did you mean `{near}`?" if near else ""


def shipped() -> Mapping[str, Path]:
    """The experiments that come with rapc, by name."""
    files = sorted(Path(__file__).parent.glob(f"*{SUFFIX}"))
    return {file.name.removesuffix(SUFFIX): file for file in files}


def find(name: str) -> Path:
    """The file of an experiment: one that comes with rapc, or a path that ends so.

    Raises:
        ExperimentError: if there is no such experiment.
    """
    if name.endswith(SUFFIX):
        return Path(name)
    known = shipped()
    if name not in known:
        listed = f"name {', '.join(known)}, or a file that ends in `{SUFFIX}`"
        raise ExperimentError(
            f"there is no experiment `{name}`", meant(name, known) or listed
        )
    return known[name]


def read(file: Path) -> Experiment:
    """Read and decode a file.

    Raises:
        ExperimentError: for a file that cannot be read or is no experiment.
    """
    try:
        text = read_text(file)
    except LoadError as error:
        raise ExperimentError(str(error)) from error
    try:
        return decode(text, file.name.removesuffix(SUFFIX))
    except ExperimentError as error:
        raise ExperimentError(f"{file}: {error.message}", error.help) from error


def decode(text: str, name: str) -> Experiment:
    """An experiment from TOML text.

    Raises:
        ExperimentError: for text that is no TOML, unknown keys, values of the wrong
            kind, and what contradicts itself.
    """
    try:
        data = toml.parsed(text)
        for where, key, known in _unknown(data):
            raise ExperimentError(f"there is no key `{key}`{where}", meant(key, known))
        found = toml.converted({**data, "name": name}, Experiment)
    except toml.TomlError as error:
        raise ExperimentError(error.message) from error
    for problem in _contradictions(found):
        raise ExperimentError(problem)
    return found


def _unknown(data: Mapping[str, Any]) -> Iterator[tuple[str, str, list[str]]]:
    """Unknown keys with where they are, and the keys that are known there."""

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
        yield from look(part, Part, f" in part {number}")
        for key, kind in (("reference", Reference), ("mark", Mark)):
            inner = part.get(key) if isinstance(part, Mapping) else None
            yield from look(inner, kind, f" in `{key}` of part {number}")


def _contradictions(experiment: Experiment) -> Iterator[str]:
    if experiment.library == "-":
        yield "`library`: standard input is there only once, a file is wanted"
    names = [part.name for part in experiment.part]
    for part in experiment.part:
        told = f"part `{part.name}`"
        if names.count(part.name) > 1:
            yield f"there is more than one {told}"
        if (part.vary is None) != (not part.values):
            yield f"{told} needs both `vary` and `values`, or neither"
        if len(set(map(repr, part.values))) < len(part.values):
            yield f"{told} has a value twice"
        if part.mark is not None and part.vary is None:
            yield f"{told} has a `mark`, but varies nothing"
        others = {p.name for p in experiment.part if p.vary == part.vary and p.vary}
        yield from (
            f"{told} is to be drawn beside `{other}`, which is no part that varies "
            "the same"
            for other in part.beside
            if other not in others - {part.name}
        )
        yield from _misfits(part, told)


def _misfits(part: Part, told: str) -> Iterator[str]:
    """Figures from elsewhere that are not one for each value."""
    if part.reference is None:
        return
    many = len(part.reference.at) if part.vary is not None else 1
    if part.vary is None and part.reference.at:
        yield f"{told} varies nothing, so its reference needs no `at`"
        return
    for value in part.reference.at:
        if value not in part.values:
            what = f"reference figures at {value}, which is none of its `values`"
            yield f"{told} has {what}"
    for measure, figures in part.reference.figures.items():
        if len(figures) != many:
            yield (
                f"{told} has {len(figures)} reference figures for `{measure}`, "
                f"but {many} values they could be for"
            )
