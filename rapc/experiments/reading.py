"""Experiments read from TOML: those that come with rapc, and files of the user's.

Says whether a file has the right form and does not contradict itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec

from rapc.base import toml
from rapc.base.files import read_text
from rapc.base.names import did_you_mean
from rapc.errors import LoadError
from rapc.experiments.contradictions import contradictions
from rapc.experiments.definition import (
    Experiment,
    ExperimentError,
    PlotMark,
    Reference,
    Series,
)
from rapc.experiments.draws import Between

SUFFIX = ".toml"


def shipped() -> Mapping[str, Path]:
    """The experiments that come with rapc, by name."""
    files = sorted(Path(__file__).parent.glob(f"*{SUFFIX}"))
    return {file.name.removesuffix(SUFFIX): file for file in files}


def experiment_file(name: str) -> Path:
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
            f"there is no experiment `{name}`", did_you_mean(name, known, listed)
        )
    return known[name]


def read_experiment(file: Path) -> Experiment:
    """Read and decode a file.

    Raises:
        ExperimentError: for a file that cannot be read or is no experiment.
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
    """An experiment from TOML text.

    Raises:
        ExperimentError: for text that is no TOML, unknown keys, values of the wrong
            kind, and what contradicts itself.
    """
    try:
        data = toml.parsed(text)
        for where, key, known in _unknown(data):
            raise ExperimentError(
                f"there is no key `{key}`{where}", did_you_mean(key, known)
            )
        found = toml.converted({**data, "name": name}, Experiment)
    except toml.TomlError as error:
        raise ExperimentError(error.message) from error
    for problem in contradictions(found):
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
        yield from look(part, Series, f" in part {number}")
        for key, kind in (("reference", Reference), ("mark", PlotMark)):
            inner = part.get(key) if isinstance(part, Mapping) else None
            yield from look(inner, kind, f" in `{key}` of part {number}")
    draws = data.get("draw")
    for name, draw in draws.items() if isinstance(draws, Mapping) else ():
        yield from look(draw, Between, f" in `{name}` of `draw`")
