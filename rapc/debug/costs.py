"""Differences in time between two runs, or between pairs of runs of equal seeds.

The accounts of the runs (`rapc.debug.account`) give their sums (`Times`); pairs of sums
give the changes of all figures, a table of the changes and a verdict.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from statistics import fmean, stdev

import msgspec

from rapc.base.values import readable
from rapc.debug.account import (
    KINDS,
    SUSPENDED,
    WAITING,
    Account,
    Piece,
    idle_in_words,
)
from rapc.debug.answer import Answer, Cell, table

_MOST_ROWS = 6
"""The highest number of rows of a section."""

_ROUNDING = 1e-9
"""Differences up to this part of a figure are due to the rounding of sums."""

Share = tuple[str, str, str, float]
"""The goal of a family and the `kind` and `what` of its pieces, with their time."""


class Times(msgspec.Struct, frozen=True):
    """The sums of an account, as data that experiments store.

    The names of the fields are keys in the files of experiments.
    """

    time: float
    #: The end reason; empty before the end.
    reason: str
    #: The foreground tasks that succeeded, and those that did not.
    succeeded: int
    others: int
    #: The time of the run; the sum is `time`.
    shares: tuple[Share, ...]
    #: The time of each family from its arrival to its end; families overlap.
    within: tuple[Share, ...]
    #: The goals of the foreground tasks.
    ahead: tuple[str, ...]
    #: For each request or skill, by its name: how often, and how long.
    requests: Mapping[str, tuple[int, float]]
    #: How often tasks failed, by a text with the family, the RAP and the result.
    failures: Mapping[str, int]


def times_of(account: Account) -> Times:
    """Return the sums of an account."""
    families = account.families
    foreground = [one for one in families.values() if not one.background]
    succeeded = sum(one.outcome == "succeeded" for one in foreground)
    requests: dict[str, tuple[int, float]] = {}
    for spell in account.spells:
        for part in spell.parts if not spell.background else ():
            count, time = requests.get(str(part[0]), (0, 0))
            requests[str(part[0])] = count + 1, time + spell.stop - spell.start
    goals = {number: one.goal for number, one in families.items()}
    within = [piece for pieces in account.of_family.values() for piece in pieces]
    return Times(
        time=account.now,
        reason=account.reason,
        succeeded=succeeded,
        others=len(foreground) - succeeded,
        shares=_shares(account.of_run, goals),
        within=_shares(within, goals),
        ahead=tuple(dict.fromkeys(one.goal for one in foreground)),
        requests=requests,
        failures=_failures(account, goals),
    )


def _shares(pieces: Iterable[Piece], goals: Mapping[int, str]) -> tuple[Share, ...]:
    found: dict[tuple[str, str, str], float] = {}
    for one in pieces:
        family = goals.get(one.family or 0, "")
        key = (family, one.kind, one.what)
        found[key] = found.get(key, 0) + one.stop - one.start
    return tuple([(*key, time) for key, time in found.items()])


def _failures(account: Account, goals: Mapping[int, str]) -> dict[str, int]:
    found: dict[str, int] = {}
    for (family, rap, result), count in account.failures.items():
        text = f"{goals[family]}: {rap} failed, {result}"
        found[text] = found.get(text, 0) + count
    return found


Pair = tuple[Times, Times]
"""The sums of the first and of the second side."""


class Change(msgspec.Struct, frozen=True):
    """A figure before and after: averages over the pairs, and their difference."""

    #: The section of the table, a key of `_SECTIONS`.
    of: str
    #: The name of the figure in the section.
    what: str
    before: float
    after: float
    difference: float
    #: Half the width of the 95 % confidence interval; 0 for a single pair.
    margin: float

    @property
    def is_significant(self) -> bool:
        """Whether the two figures differ beyond chance and rounding."""
        rounding = _ROUNDING * max(abs(self.before), abs(self.after))
        return abs(self.difference) > max(self.margin, rounding)


def change(of: str, what: str, pairs: Sequence[tuple[float, float]]) -> Change:
    """Return the change of a figure over pairs of runs."""
    differences = [after - before for before, after in pairs]
    margin = 0.0
    if len(pairs) > 1:
        margin = _quantile(len(pairs) - 1) * stdev(differences) / math.sqrt(len(pairs))
    before, after = (fmean(one) for one in zip(*pairs, strict=True))
    return Change(of, what, before, after, fmean(differences), margin)


_QUANTILES = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228)
"""The 97.5th percentiles of Student's t distribution for 1 to 10 degrees of freedom."""


def _quantile(freedom: int) -> float:
    """Return the 97.5th percentile of Student's t distribution.

    From 11 degrees of freedom on the error of the series is below 0.001.
    """
    if freedom <= len(_QUANTILES):
        return _QUANTILES[freedom - 1]
    z = 1.959964
    first = (z**3 + z) / 4
    second = (5 * z**5 + 16 * z**3 + 3 * z) / 96
    return z + first / freedom + second / freedom**2


# --- the table ----------------------------------------------------------------------

_Figures = Mapping[str, float]


def _total(shares: Iterable[Share], key: Callable[[Share], str]) -> dict[str, float]:
    found: dict[str, float] = {}
    for one in shares:
        found[key(one)] = found.get(key(one), 0) + one[3]
    return found


def _of_kind(kind: str) -> Callable[[Times], _Figures]:
    return lambda one: _total([s for s in one.shares if s[1] == kind], lambda s: s[2])


def _in_family(one: Times) -> _Figures:
    """Return the waits and suspensions within each family."""
    kept = [s for s in one.within if s[1] in (WAITING, SUSPENDED)]
    return _total(kept, lambda s: f"{s[0]}: {idle_in_words(s[1], s[2])}")


_SECTIONS: Mapping[str, Callable[[Times], _Figures]] = {
    "run": lambda one: {
        "time": one.time,
        "tasks succeeded": one.succeeded,
        "tasks not succeeded": one.others,
    },
    "kind": lambda one: _total(one.shares, lambda s: s[1]),
    **{kind: _of_kind(kind) for kind in KINDS},
    "family": lambda one: _total(one.shares, lambda s: s[0]),
    "arrival to end": lambda one: _total(
        [s for s in one.within if s[0] in one.ahead], lambda s: s[0]
    ),
    "in family": _in_family,
    "failures": lambda one: dict(one.failures),
    "requests": lambda one: {name: n for name, (n, _) in one.requests.items()},
}
"""The sections of the table: the figures of a run by name.

`kind` and `family` divide the time of the run; `acting`, `sensing`, `waiting` and
`suspended` divide the time of that kind. In `arrival to end` (foreground tasks) and `in
family`, families overlap.
"""


def changes(pairs: Sequence[Pair]) -> dict[str, list[Change]]:
    """Return the significant changes by section, the largest first."""
    found: dict[str, list[Change]] = {}
    for of, figures in _SECTIONS.items():
        read = [(figures(before), figures(after)) for before, after in pairs]
        names = dict.fromkeys(name for pair in read for one in pair for name in one)
        made = (
            change(of, name, [(a.get(name, 0), b.get(name, 0)) for a, b in read])
            for name in names
        )
        kept = [one for one in made if one.is_significant]
        found[of] = sorted(kept, key=lambda one: -abs(one.difference))
    return found


def rows(found: Mapping[str, Sequence[Change]]) -> Iterator[tuple[Cell, ...]]:
    """Yield the rows of a table with the columns of `columns`."""
    for of, listed in found.items():
        for one in listed[:_MOST_ROWS]:
            percent = 100 * one.difference / one.before if one.before else None
            yield (
                *(of, one.what, _short(one.before), _short(one.after)),
                *(f"{one.difference:+.4g}", _short(one.margin) if one.margin else None),
                None if percent is None else f"{percent:+.0f} %",
            )
        if len(listed) > _MOST_ROWS:
            yield (of, f"... and {len(listed) - _MOST_ROWS} more", *[None] * 5)


def _short(figure: float) -> Cell:
    rounded = round(figure, 2)
    return int(rounded) if rounded == int(rounded) else rounded


def columns(before: str, after: str) -> tuple[str, ...]:
    """Return the columns of `rows`; the names are those of the two sides."""
    return ("of", "what", before, after, "difference", "± 95 %", "")


# --- the verdict --------------------------------------------------------------------


class Verdict(msgspec.Struct, frozen=True):
    """The result of a comparison."""

    #: A line for each figure that differs, or the line `no difference`.
    lines: tuple[str, ...]
    #: Whether the second side is worse by at least the threshold.
    worse: bool


def verdict(
    pairs: Sequence[Pair], names: tuple[str, str], threshold: float = 0
) -> Verdict:
    """Return whether the second side is worse: fewer successes, or else more time.

    The time decides only if the numbers of successes do not differ.

    Args:
        pairs: the runs of the two sides.
        names: the names of the two sides.
        threshold: the smallest increase of the time that is worse, in per cent.
    """
    time = change("run", "time", [(a.time, b.time) for a, b in pairs])
    done = change("run", "done", [(a.succeeded, b.succeeded) for a, b in pairs])
    lines = []
    for label, one in (("time", time), ("tasks succeeded", done)):
        if one.is_significant:
            sides = zip(names, (one.before, one.after), strict=True)
            both = ", ".join(f"{name} {readable(round(n, 2))}" for name, n in sides)
            lines.append(f"{label}: {both} ({_in_per_cent(one)})")
    if done.is_significant:
        worse = done.difference < 0
    else:
        least = threshold / 100 * time.before
        worse = time.is_significant and 0 < time.difference >= least
    return Verdict(tuple(lines) or ("no difference in time and successes",), worse)


def table_of(
    pairs: Sequence[Pair],
    names: tuple[str, str],
    *lines: str,
    notes: Sequence[str] = (),
) -> Answer:
    """Return the verdict, further lines, and the table of the changes."""
    head = (*verdict(pairs, names).lines, *_by_pair(pairs), *lines)
    made, none = rows(changes(pairs)), "no difference in times"
    return table(columns(*names), made, *head, none=none, notes=notes)


def _by_pair(pairs: Sequence[Pair]) -> Iterator[str]:
    """Yield a line with the number of pairs by their difference in time."""
    if len(pairs) > 1:
        slower = sum(after.time > before.time for before, after in pairs)
        faster = sum(after.time < before.time for before, after in pairs)
        equal = sum(after == before for before, after in pairs)
        line = f"slower in {slower} of {len(pairs)} seeds, faster in {faster}"
        yield f"{line}, equal in all figures in {equal}"


def _in_per_cent(one: Change) -> str:
    """Return a difference in per cent, with its confidence interval."""
    if not one.before:
        return f"{one.difference:+.4g}"
    margin = f" ± {100 * one.margin / one.before:.1f}" if one.margin else ""
    return f"{100 * one.difference / one.before:+.1f}{margin} %"
