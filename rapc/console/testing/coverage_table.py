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

OTHERS = {
    "queries_asked": "queries asked",
    "agenda_tasks_given": "tasks of agendas given",
    "constraints_broken": "constraints of methods broken",
    "waits_heard": "awaited signals heard",
    "rules_run": "rules run",
}
"""What is summed up besides, by its name in JSON, with its name below the table."""

_COUNTED = (
    "methods_chosen",
    "contexts_true",
    "contexts_false",
    "monitors_woken",
    "queries_asked",
    "agenda_tasks_given",
    "waits_heard",
    "rules_run",
)
"""What a test should show, and `--coverage-min` counts; nothing has to fail."""

_NAME = 24

_NOTHING = "the tests run no library outside of test files"


class Share(msgspec.Struct, frozen=True):
    """How many of how many things were exercised."""

    covered: int
    of: int


def shares(files: Iterable[FileCoverage]) -> dict[str, Share]:
    """Return what was exercised of some files, by column.

    Methods chosen and methods that ended badly; contexts seen true and seen false;
    RAPs with a monitor that has woken a task; RAPs of which a task has failed; queries,
    tasks of agendas, constraints of methods.
    """
    of: Counter[str] = Counter()
    covered: Counter[str] = Counter()
    for file in files:
        for column, count in _counts(file):
            if count is not None:
                of[column] += 1
                covered[column] += count > 0
    return {c: Share(covered[c], of[c]) for c in (*COLUMNS, *OTHERS)}


def _counts(file: FileCoverage) -> Iterator[tuple[str, int | None]]:
    """Yield how often each thing in a file was exercised, with its column."""
    for rap in file.raps:
        yield "raps_failed", sum(rap.failed.values())
        yield "monitors_woken", rap.monitor.woken if rap.monitor is not None else None
        for method in rap.methods:
            yield "methods_chosen", method.chosen
            yield "contexts_true", method.context_true
            yield "contexts_false", method.context_false
            yield "methods_ended_badly", method.ended_badly
            yield "constraints_broken", method.constraints_broken
            for wait in method.waits:
                yield "waits_heard", wait.heard
    for rule in file.rules:
        yield "rules_run", rule.ran
    for query in file.queries:
        yield "queries_asked", query.asked
    for agenda in file.agendas:
        for task in agenda.tasks:
            yield "agenda_tasks_given", task.given


def share_in_all(files: Iterable[FileCoverage]) -> Share:
    """Return how much was exercised of all that a test should show."""
    found = shares(files)
    parts = [found[column] for column in _COUNTED]
    return Share(sum(p.covered for p in parts), sum(p.of for p in parts))


def per_cent(share: Share) -> str:
    """Return a share in words: `87.5 % (35 of 40)`, rounded down."""
    tenths = 1000 * share.covered // share.of if share.of else 1000
    return f"{tenths / 10:g} % ({share.covered} of {share.of})"


def verdict(files: Sequence[FileCoverage], least: float) -> tuple[bool, str]:
    """Return whether less is covered than `least` per cent, and a line that says so.

    Where the tests run no library, nothing meets a minimum.
    """
    share = share_in_all(files)
    short = share.covered * 100 < least * share.of or (least > 0 and not files)
    more = f", less than the {least:g} % that are asked for" if short else ""
    return short, f"coverage: {per_cent(share) if files else _NOTHING}{more}"


def as_json(files: Sequence[FileCoverage]) -> bytes:
    """Everything that was counted, with what it comes to for each file and in all."""
    listed = [
        {
            "file": one.file,
            "covered": shares([one]),
            "raps": one.raps,
            "queries": one.queries,
            "agendas": one.agendas,
            "rules": one.rules,
        }
        for one in files
    ]
    whole = shares(files)
    told = {"format": FORMAT, "covered": whole, "files": listed}
    return msgspec.json.format(msgspec.json.encode(told), indent=2) + b"\n"


def table(files: Sequence[FileCoverage]) -> Iterator[str]:
    """A line for each file, one for all, and what each RAP still lacks."""
    if not files:
        yield f"coverage: {_NOTHING}"
        return
    yield _line("coverage", COLUMNS.values())
    for one in files:
        yield _line(one.file, _told(shares([one])))
    whole = shares(files)
    if len(files) > 1:
        yield _line("all", _told(whole))
    others = [
        f"{words}: {whole[column].covered}/{whole[column].of}"
        for column, words in OTHERS.items()
        if whole[column].of
    ]
    if others:
        yield "; ".join(others)
    reasons: Counter[str] = Counter()
    for rap in (rap for one in files for rap in one.raps):
        reasons.update(rap.failed)
    if reasons:
        listed = ", ".join(f"{reason} {reasons[reason]}" for reason in sorted(reasons))
        yield f"tasks failed: {listed}"
    for one in files:
        yield from _lacking_in(one)


def _lacking_in(file: FileCoverage) -> Iterator[str]:
    """Yield what no test has shown of what a file defines."""
    for rap in file.raps:
        lacking = "; ".join(_lacking(rap))
        if lacking:
            yield f"{file.file}:{rap.row} {rap.name}: {lacking}"
    for query in file.queries:
        if not query.asked:
            yield f"{file.file}:{query.row} {query.name}: never asked"
    for rule in file.rules:
        if not rule.ran:
            yield f"{file.file}:{rule.row} rule for {rule.name}: never run"
    for agenda in file.agendas:
        for task in agenda.tasks:
            if not task.given:
                place = f"{file.file}:{task.row}"
                yield f"{place} {agenda.name}: never given {task.goal}"


def _line(name: str, cells: Iterable[str]) -> str:
    """A name, cut at its front, and numbers below one another: 79 columns."""
    name = name if len(name) <= _NAME else "…" + name[1 - _NAME :]
    return f"{name:<{_NAME}}" + "".join(f"{cell:>9}" for cell in cells)


def _told(found: Mapping[str, Share]) -> list[str]:
    told = [found[column] for column in COLUMNS]
    return [f"{s.covered}/{s.of}" if s.of else "-" for s in told]


def _lacking(rap: RapCoverage) -> Iterator[str]:
    """Yield what no test has shown of a RAP; that nothing failed is not among it."""
    lacks = (
        ("never chosen", [m.name for m in rap.methods if not m.chosen]),
        ("context never true", [m.name for m in rap.methods if m.context_true == 0]),
        ("context never false", [m.name for m in rap.methods if m.context_false == 0]),
    )
    for what, names in lacks:
        if names:
            yield f"{what} {' '.join(names)}"
    unheard = [w.signal for m in rap.methods for w in m.waits if not w.heard]
    if unheard:
        yield f"never heard {' '.join(unheard)}"
    if rap.monitor is not None and not rap.monitor.woken:
        yield "monitor never woken"
