"""What rapc is to reach beside its peers, and whether it has.

A target is judged at the worst of its sizes, and not at all if one of them was not
measured. A rate is compared so that a larger figure is better, a time so that a smaller
one is; `at_least` says which way the bar stands. What can be understood in two ways is
judged in both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import msgspec

from bench.common import short
from bench.results import Results

PARSED = (100, 1000, 5000)
ITEMS = (1000, 10_000, 100_000)
MONITORS = (10, 100, 1000, 10_000, 100_000)
MANY = (1000, 10_000, 100_000)
DEPTHS = (6, 8)


TIMES = ("us", "/s", "s", "s of processor")
"""The units of times and rates, which belong to a machine that does nothing else."""


class Found(msgspec.Struct, frozen=True):
    """A figure held against a bar, and what it is made of."""

    value: float
    made_of: str


Measure = Callable[[Results], Found | None]


class Target(msgspec.Struct, frozen=True):
    """One thing to be reached: at least the bar, or at most."""

    area: str
    what: str
    measure: Measure
    bar: float
    at_least: bool = False
    unit: str = "x"

    def reached(self, found: Found) -> bool:
        """Whether the bar is reached."""
        if self.at_least:
            return found.value >= self.bar
        return found.value <= self.bar


def _worst(
    workload: str,
    ours: str,
    figure: str,
    sizes: Sequence[int],
    *,
    at_least: bool,
    scale: float = 1,
) -> Measure:
    """A figure of ours by itself, at the worst size."""

    def measure(results: Results) -> Found | None:
        found = []
        for size in sizes:
            value = results.at(workload, ours, size, figure)
            if value is None:
                return None
            found.append((value * scale, f"at {size:,}"))
        return Found(*(min if at_least else max)(found))

    return measure


def _ratio(
    workload: str,
    above: tuple[str, Sequence[int]],
    below: tuple[str, Sequence[int]],
    figure: str,
    *,
    at_least: bool,
) -> Measure:
    """One peer's figure over another's, size by size, at the worst of them."""

    def measure(results: Results) -> Found | None:
        found = []
        for over, under in zip(above[1], below[1], strict=True):
            one = results.at(workload, above[0], over, figure)
            other = results.at(workload, below[0], under, figure)
            if one is None or not other:
                return None
            told = f"{_told(one, figure)} / {_told(other, figure)}"
            size = f"{over:,}" if over == under else f"{over:,} / {under:,}"
            found.append((one / other, f"at {size}: {told}"))
        return Found(*(min if at_least else max)(found))

    return measure


def _cost(name: str, beside: str = "", scale: float = 1) -> Measure:
    """A cost of ours; with another, its processor time is told too."""

    def measure(results: Results) -> Found | None:
        value = results.costs.get(name)
        if value is None:
            return None
        other = results.costs.get(beside)
        told = "" if other is None else f"{short(other)} s of processor"
        return Found(value * scale, told)

    return measure


def _loading(what: str, way: str) -> Measure:
    """How much longer sources take than a compiled library."""

    def measure(results: Results) -> Found | None:
        sources = results.costs.get(f"load-{what}.sources")
        other = results.costs.get(f"load-{what}.{way}")
        if sources is None or not other:
            return None
        return Found(sources / other, f"{short(sources)} / {short(other)} ms")

    return measure


def _told(value: float, figure: str) -> str:
    """A figure with its unit: a rate as it is, a time in microseconds."""
    if figure.endswith("_per_s"):
        return f"{short(value)}/s"
    return f"{short(value * 1e6)} us"


def _parsing() -> Iterator[Target]:
    for ours, what, theirs, bar in (
        ("rapc", "lists and atoms", "hand+pos", 0.9),
        ("rapc-ir", "typed nodes", "hand+pos", 0.9),
        ("rapc-load", "a library to be run", "clips", 1.0),
    ):
        measure = _ratio(
            "W1",
            (ours, PARSED),
            (theirs, PARSED),
            "definitions_per_s",
            at_least=True,
        )
        yield Target(
            "W1", f"text to {what}, rate over `{theirs}`", measure, bar, at_least=True
        )


def _asking() -> Iterator[Target]:
    names = {"first_sel": "first answer", "all_sel": "all answers"}
    for figure, what in names.items():
        ours, peer = ("rapc", ITEMS[1:2]), ("swipl", ITEMS[1:2])
        measure = _ratio("W2", ours, peer, figure, at_least=False)
        yield Target("W2", f"{what}, time over `swipl`", measure, 1.5)
        slow = ("sqlite3", ITEMS[1:2])
        measure = _ratio("W2", slow, ours, figure, at_least=True)
        yield Target("W2", f"{what}, `sqlite3` over ours", measure, 4, at_least=True)
        few, many = ("rapc", ITEMS[:1]), ("rapc", ITEMS[2:])
        measure = _ratio("W2", many, few, figure, at_least=False)
        yield Target("W2", f"{what}, 100,000 items over 1,000", measure, 2)


def _waiting() -> Iterator[Target]:
    measure = _worst("W3", "rapc", "fire", MONITORS, at_least=False, scale=1e6)
    yield Target("W3", "one firing", measure, 5, unit="us")
    few, many = ("rapc", MONITORS[:1]), ("rapc", MONITORS[-1:])
    measure = _ratio("W3", many, few, "fire", at_least=False)
    yield Target("W3", "100,000 monitors over 10", measure, 1.5)
    for theirs, sizes, bar in (
        ("py_trees", MONITORS[-1:], 20_000),
        ("jason", MANY, 1),
        ("bt.cpp", MANY, 1),
    ):
        measure = _ratio("W3", (theirs, sizes), ("rapc", sizes), "fire", at_least=True)
        what = f"one firing, `{theirs}` over ours"
        yield Target("W3", what, measure, bar, at_least=True)


def _expanding() -> Iterator[Target]:
    for ours, how in (("rapc", ""), ("rapc-inputs", ", depth as input")):
        measure = _worst("W4", ours, "tasks_per_s", DEPTHS, at_least=True)
        what = f"tasks a second{how}"
        yield Target("W4", what, measure, 300_000, at_least=True, unit="/s")
        for theirs, bar in (("py_trees", 2.5), ("agentspeak", 3)):
            mine, peer = (ours, DEPTHS), (theirs, DEPTHS)
            measure = _ratio("W4", mine, peer, "tasks_per_s", at_least=True)
            what = f"tasks{how}, rate over `{theirs}`"
            yield Target("W4", what, measure, bar, at_least=True)


def _tracing() -> Iterator[Target]:
    for ours, how in (("rapc-traced", "events kept"), ("rapc-written", "written")):
        plain, traced = ("rapc", MONITORS), (ours, MONITORS)
        measure = _ratio("W3", plain, traced, "fire", at_least=True)
        what = f"firings a second, {how} over not"
        yield Target("trace", what, measure, 0.5, at_least=True)
        measure = _ratio(
            "W4", (ours, DEPTHS), ("rapc", DEPTHS), "tasks_per_s", at_least=True
        )
        what = f"tasks a second, {how} over not"
        yield Target("trace", what, measure, 0.5, at_least=True)


def _commands() -> Iterator[Target]:
    for name, what in (
        ("truck", "`rapc run`, nine orders in the still world"),
        ("truck-compiled", "the same of a compiled library"),
        ("truck-again", "the same run, as a later one in a process"),
    ):
        run = _cost(f"{name}.cpu")
        yield Target("truck", what, run, 0.5, unit="s of processor")
    yield Target("truck", "peak memory of it", _cost("truck.peak"), 80, unit="MB")
    check = _cost("check.wall", "check.cpu")
    yield Target("start", "`rapc check stdlib`", check, 1.0, unit="s")
    yield Target(
        "start", "`rapc --help`", _cost("help.wall", "help.cpu"), 0.12, unit="s"
    )
    for name, what in (("truck", "stdlib/truck"), ("generated", "many RAPs")):
        load = _loading(name, "artifact")
        told = f"{what}, sources over compiled"
        yield Target("load", told, load, 10, at_least=True)
        load = _loading(name, "artifact-all")
        told = f"{what}, the same with each RAP read"
        yield Target("load", told, load, 10, at_least=True)


TARGETS: tuple[Target, ...] = (
    *_parsing(),
    *_asking(),
    *_waiting(),
    *_expanding(),
    Target(
        "W5",
        "a dormant task, of 10,000",
        _worst("W3", "rapc", "bytes_per_monitor", (10_000,), at_least=False),
        1200,
        unit="bytes",
    ),
    *_tracing(),
    *_commands(),
)


def table(results: Results) -> Iterator[str]:
    """The targets as rows of a Markdown table, each judged."""
    yield "| | what | measured | of | target | reached |"
    yield "|---|---|---:|---|---:|---|"
    for target in TARGETS:
        if results.shared and target.unit in TIMES:
            continue
        found = target.measure(results)
        cells = ("not measured", "", "") if found is None else _cells(target, found)
        value, made_of, verdict = cells
        row = (target.area, target.what, value, made_of, _bar(target), verdict)
        yield "| " + " | ".join(row) + " |"


def _cells(target: Target, found: Found) -> tuple[str, str, str]:
    verdict = "yes" if target.reached(found) else "**no**"
    return f"{short(found.value)} {target.unit}", found.made_of, verdict


def _bar(target: Target) -> str:
    sign = "at least" if target.at_least else "at most"
    return f"{sign} {short(target.bar)} {target.unit}"
