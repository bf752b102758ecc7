"""Coverage as a table for a person, and as JSON for programs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.testing.coverage import FileCoverage, RapCoverage

FORMAT = 1
"""The version of the JSON form."""

COLUMNS = {
    "methods_chosen": "methods",
    "contexts_true": "true",
    "contexts_false": "false",
    "methods_ended_badly": "bad end",
    "monitors_woken": "woken",
    "raps_failed": "failed",
}
"""What is summed up, by its name in JSON, with its name in the table."""

_NAME = 24


class Share(msgspec.Struct, frozen=True):
    """How many of how many things were exercised."""

    covered: int
    of: int


def shares(raps: Iterable[RapCoverage]) -> dict[str, Share]:
    """What was exercised of some RAPs, by column.

    Methods chosen and methods that ended badly; contexts seen true and seen false;
    RAPs with a monitor that has woken a task; RAPs of which a task has failed.
    """
    of: Counter[str] = Counter()
    covered: Counter[str] = Counter()

    def add(column: str, count: int | None) -> None:
        if count is not None:
            of[column] += 1
            covered[column] += count > 0

    for rap in raps:
        add("raps_failed", sum(rap.failed.values()))
        add("monitors_woken", rap.monitor.woken if rap.monitor is not None else None)
        for method in rap.methods:
            add("methods_chosen", method.chosen)
            add("contexts_true", method.context_true)
            add("contexts_false", method.context_false)
            add("methods_ended_badly", method.ended_badly)
    return {column: Share(covered[column], of[column]) for column in COLUMNS}


def as_json(files: Sequence[FileCoverage]) -> bytes:
    """Everything that was counted, with what it comes to for each file and in all."""
    listed = [
        {"file": one.file, "covered": shares(one.raps), "raps": one.raps}
        for one in files
    ]
    whole = shares(rap for one in files for rap in one.raps)
    told = {"format": FORMAT, "covered": whole, "files": listed}
    return msgspec.json.format(msgspec.json.encode(told), indent=2) + b"\n"


def table(files: Sequence[FileCoverage]) -> Iterator[str]:
    """A line for each file, one for all, and what each RAP still lacks."""
    if not files:
        yield "coverage: the tests run no library outside of test files"
        return
    yield _line("coverage", COLUMNS.values())
    for one in files:
        yield _line(one.file, _told(shares(one.raps)))
    if len(files) > 1:
        whole = shares(rap for one in files for rap in one.raps)
        yield _line("all", _told(whole))
    reasons: Counter[str] = Counter()
    for one in files:
        for rap in one.raps:
            reasons.update(rap.failed)
    if reasons:
        listed = ", ".join(f"{reason} {reasons[reason]}" for reason in sorted(reasons))
        yield f"tasks failed: {listed}"
    for one in files:
        for rap in one.raps:
            lacking = "; ".join(_lacking(rap))
            if lacking:
                yield f"{one.file}:{rap.row} {rap.name}: {lacking}"


def _line(name: str, cells: Iterable[str]) -> str:
    """A name, cut at its front, and numbers below one another: 79 columns."""
    name = name if len(name) <= _NAME else "…" + name[1 - _NAME :]
    return f"{name:<{_NAME}}" + "".join(f"{cell:>9}" for cell in cells)


def _told(found: Mapping[str, Share]) -> list[str]:
    return [f"{s.covered}/{s.of}" if s.of else "-" for s in found.values()]


def _lacking(rap: RapCoverage) -> Iterator[str]:
    """What no test has shown of a RAP; that nothing failed is no lack to be listed."""
    lacks = (
        ("never chosen", [m.name for m in rap.methods if not m.chosen]),
        ("context never true", [m.name for m in rap.methods if m.context_true == 0]),
        ("context never false", [m.name for m in rap.methods if m.context_false == 0]),
    )
    for what, names in lacks:
        if names:
            yield f"{what} {' '.join(names)}"
    if rap.monitor is not None and not rap.monitor.woken:
        yield "monitor never woken"
