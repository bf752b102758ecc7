"""Each table of a page names everything that there is, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterator

import msgspec
import pytest

import rapc
from rapc.experiments.definition import Experiment, Reference, Series
from rapc.experiments.measures import LABELS
from rapc.language.heads import heads, rules_by_head
from rapc.testing.coverage import COLUMNS

from .pages import first_words, page, section, ticked

TESTING, EXPERIMENTS = page("reference/tests"), page("how-to/experiments")
_KEY = r"`([a-z-]+)`"


def _keys(kind: type[msgspec.Struct]) -> set[str]:
    return {field.encode_name for field in msgspec.structs.fields(kind)}


def _of_tests() -> Iterator[tuple[str, object, object]]:
    for heading, known in (
        ("## Script", rules_by_head("_once_row_option")),
        ("## At a time", heads("_action")),
    ):
        told = first_words(section(TESTING, heading), r"`[(]?([:a-z-]+)")
        yield heading.strip("# "), {*told}, {*known}
    told = re.findall(r"`([a-z ]+)`", TESTING.partition("## Coverage\n")[2])
    yield "columns of coverage", {*COLUMNS.values()} & {*told}, {*COLUMNS.values()}


def _of_experiments() -> Iterator[tuple[str, object, object]]:
    text = section(EXPERIMENTS, "## The file", "\n## ")
    of_file, _, of_part = text.partition("A part is a series")
    told = first_words(of_file, _KEY)
    yield "keys of an experiment", sorted([*told, "name"]), sorted(_keys(Experiment))
    yield "keys of a part", sorted(first_words(of_part, _KEY)), sorted(_keys(Series))
    told = ticked(of_part.partition("A `reference` has")[2].partition("\n\n")[0])
    yield "keys of a reference", _keys(Reference) & {*told}, _keys(Reference)
    told = first_words(section(EXPERIMENTS, "## Measures", "\n## "), _KEY)
    yield "measures", told, list(LABELS)


def _of_python() -> Iterator[tuple[str, object, object]]:
    text = section(page("reference/python-api"), "## Errors")
    errors = {name for name in rapc.__all__ if name.endswith("Error")} - {"Error"}
    yield "errors", {*first_words(text, r"`(\w+Error)")}, errors


TABLES = [
    pytest.param(told, known, id=name)
    for tables in (_of_tests, _of_experiments, _of_python)
    for name, told, known in tables()
]


@pytest.mark.parametrize(("told", "known"), TABLES)
def test_a_table_names_all_there_is_and_nothing_else(
    told: object, known: object
) -> None:
    assert known
    assert told == known
