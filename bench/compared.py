"""Comparison of libraries with changes that are known: harmless ones and faults.

    python -m bench.compared [--seeds 30] [--setting courier]

compares each library of `compared.toml` with its changed versions over seeds, as `rapc
compare --seeds` does. For a harmless change the verdict must be `no difference`. A
fault counts if its time or its number of successes differs by 5 per cent or more; then
the comparison must name the family and the file. A family is named if it is among the
first two rows of the section `family`, or in the first row of `in family` or of
`failures`. A file is named by a
changed definition, and also by the RAP of the first different decision.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

import rapc
from rapc.compiler.program import Program
from rapc.debug import costs
from rapc.debug.questions.differences import (
    Side,
    changed_definitions,
    finished,
    first_difference,
)
from rapc.experiments.batch import jobs, run_batch
from rapc.experiments.local import LocalWorkers, cores
from rapc.experiments.measures import Measures
from rapc.experiments.paired import timed_config
from rapc.experiments.run import run_job
from rapc.experiments.session import pairs_of
from rapc.runtime.interpreter import Interpreter
from rapc.spec import RunSpec
from rapc.worlds.registry import world_of

CHANGES = Path(__file__).with_suffix(".toml")

_LEAST = 0.05
"""The least part by which time or successes must differ for a fault to count."""


class Setting(msgspec.Struct, frozen=True):
    """A library with the start of its runs."""

    library: str
    world: str
    until: int
    agenda: str | None = None
    tasks: tuple[str, ...] = ()

    @property
    def spec(self) -> RunSpec:
        """The start of the runs."""
        return RunSpec(
            world=self.world.rpartition(":")[2],
            world_class=self.world if ":" in self.world else "",
            agenda=self.agenda,
            tasks=self.tasks,
            until=self.until,
        )


class Change(msgspec.Struct, frozen=True):
    """A change of a library; without families it is harmless."""

    name: str
    setting: str
    file: str
    old: str
    new: str
    families: tuple[str, ...] = ()


class Changes(msgspec.Struct, frozen=True):
    """The file of changes."""

    setting: Mapping[str, Setting]
    harmless: tuple[Change, ...]
    fault: tuple[Change, ...]


class Outcome(msgspec.Struct, frozen=True):
    """What the comparison said of a change."""

    change: Change
    verdict: costs.Verdict
    #: The relative difference of the time, and of the successes.
    slower: float
    fewer: float
    #: The families in the order of the table.
    families: tuple[str, ...]
    definitions: tuple[str, ...]
    #: The file of the RAP of the first different decision; empty without one.
    decided_in: str

    @property
    def counts(self) -> bool:
        """Whether a fault changes time or successes enough to be named."""
        return max(abs(self.slower), abs(self.fewer)) >= _LEAST

    @property
    def names_family(self) -> bool:
        """Whether a family at fault is among the first."""
        return any(one in self.change.families for one in self.families)

    @property
    def names_file(self) -> bool:
        """Whether a changed definition is in the changed file."""
        return any(f"{self.change.file}:" in line for line in self.definitions)


def read_changes() -> Changes:
    """Return the changes of the file."""
    return msgspec.convert(tomllib.loads(CHANGES.read_text()), Changes)


def changed_library(change: Change, library: str, folder: Path) -> Path:
    """Write the library with a change into a new folder, and return it."""
    made = folder / library.rpartition("/")[2]
    shutil.copytree(library, made)
    file = made / change.file
    text = file.read_text()
    if text.count(change.old) != 1:
        raise ValueError(f"{change.name}: `{change.old}` is not once in {change.file}")
    file.write_text(text.replace(change.old, change.new))
    return made


def outcomes(changes: Sequence[Change], setting: Setting, seeds: int) -> list[Outcome]:
    """Return the outcomes of the changes of one library."""
    with tempfile.TemporaryDirectory() as folder:
        base = _load(Path(setting.library))
        made = []
        for number, change in enumerate(changes):
            into = Path(folder) / str(number)
            made.append(_load(changed_library(change, setting.library, into)))
        found = _measured([base, *made], setting.spec, range(seeds))
        return [
            _outcome(change, (base, one), (found[0], measures), setting.spec)
            for change, one, measures in zip(changes, made, found[1:], strict=True)
        ]


def _load(path: Path) -> Program:
    return rapc.load(path, check=False).program


def _measured(
    libraries: Sequence[Program], spec: RunSpec, seeds: range
) -> list[dict[int, Measures]]:
    configs = [timed_config(one, spec) for one in libraries]
    found: list[dict[int, Measures]] = [{} for _ in configs]
    with LocalWorkers(cores(), run_job, 300) as workers:
        work = jobs([(config, seeds) for config in configs], workers.chunk)
        for done in run_batch(workers, work):
            at = next(n for n, one in enumerate(configs) if one is done.config)
            for result in done.results:
                if result.measures is None:
                    raise RuntimeError(result.fault + result.trace)
                found[at][result.seed] = result.measures
    return [dict(sorted(one.items())) for one in found]


def _outcome(
    change: Change,
    libraries: tuple[Program, Program],
    measured: tuple[Mapping[int, Measures], Mapping[int, Measures]],
    spec: RunSpec,
) -> Outcome:
    pairs = pairs_of(*measured)
    differ = (seed for seed, (one, other) in pairs.items() if one != other)
    seed = next(differ, 0)
    before, after = (_run(one, spec, seed) for one in libraries)
    listed = [*pairs.values()]
    found = costs.changes(listed)
    time = costs.change("", "", [(a.time, b.time) for a, b in listed])
    done = costs.change("", "", [(a.succeeded, b.succeeded) for a, b in listed])
    return Outcome(
        change=change,
        verdict=costs.verdict(listed, ("before", "after"), 100 * _LEAST),
        slower=time.difference / time.before if time.is_significant else 0,
        fewer=done.difference / done.before
        if done.is_significant and done.before
        else 0,
        families=tuple(
            _rap(one.what)
            for one in (
                *found["family"][:2],
                *found["in family"][:1],
                *found["failures"][:1],
            )
        ),
        definitions=tuple(changed_definitions(before, after)),
        decided_in=_decided_in(before, after),
    )


def _run(library: Program, spec: RunSpec, seed: int) -> Side:
    spec = msgspec.structs.replace(spec, seed=seed)
    run = Interpreter.prepared(library, world_of(spec), spec)
    return finished(run, spec.until, "")


def _rap(what: str) -> str:
    return what[1:].partition(")")[0].partition(" ")[0]


def _decided_in(before: Side, after: Side) -> str:
    """Return the file of the RAP of the first different decision."""
    found = first_difference(before, after)
    told = found and (found.there or found.here)
    if not told or after.program is None:
        return ""
    goal = told.keys.get("goal")
    rap = after.program.library.raps[told.keys["rap"] if goal is None else goal.name]
    return Path(rap.span.file).name


def _lines(found: Sequence[Outcome], *, harmless: bool) -> Iterator[str]:
    for one in found:
        said = f"{one.change.setting:<11}{one.change.name:<42}"
        said += f"{100 * one.slower:+6.1f} %{100 * one.fewer:+6.1f} %  "
        if harmless:
            yield said + one.verdict.lines[0]
        else:
            family = "family" if one.names_family else "FAMILY NOT NAMED"
            file = "file" if one.names_file else "FILE NOT NAMED"
            decided = f"decision in {one.decided_in or 'none'}"
            first = " ".join(one.families)
            counts = f"{family} ({first}), {file}, {decided}"
            yield said + (counts if one.counts else f"below 5 per cent; {counts}")


def main() -> None:
    """Compare all changes and print what was said."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=30)
    parser.add_argument("--setting")
    given = parser.parse_args()
    changes = read_changes()
    harmless: list[Outcome] = []
    faults: list[Outcome] = []
    for name, setting in changes.setting.items():
        if given.setting in (None, name):
            every = (*changes.harmless, *changes.fault)
            listed = [one for one in every if one.setting == name]
            for one in outcomes(listed, setting, given.seeds):
                (faults if one.change.families else harmless).append(one)
            for line in _lines(harmless, harmless=True):
                print(line, flush=True)
            for line in _lines(faults, harmless=False):
                print(line, flush=True)
    quiet = sum(one.verdict.lines[0].startswith("no difference") for one in harmless)
    print(f"harmless: {quiet} of {len(harmless)} without a difference")
    named = [one for one in faults if one.counts]
    print(
        f"faults: {len(named)} of {len(faults)} change time or successes by 5 per "
        f"cent; of these family named {sum(one.names_family for one in named)}, "
        f"file named {sum(one.names_file for one in named)}, first decision in it "
        f"{sum(one.decided_in == one.change.file for one in named)}"
    )


if __name__ == "__main__":
    main()
