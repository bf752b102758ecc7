"""Similar names for unknown names, and nouns with their number."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from rapc.base.limits import MAX_COMPARED, MAX_SUGGESTIONS

_CUTOFF = 0.72


def plural(number: int, word: str) -> str:
    """Return `number` and `word`, in the plural unless `number` is 1: `2 inputs`."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def nearest(name: str, names: Iterable[str]) -> str | None:
    """Return the known name most similar to a mistyped name, or None.

    Of equally similar names the first in sorted order is returned: the result does not
    depend on the order of `names`.
    """
    import difflib  # noqa: PLC0415  # most commands know all their names

    best: tuple[float, str] | None = None
    matcher = difflib.SequenceMatcher(b=name, autojunk=False)
    for candidate in sorted(set(names)):
        if candidate == name:
            continue
        matcher.set_seq1(candidate)
        if matcher.real_quick_ratio() < _CUTOFF or matcher.quick_ratio() < _CUTOFF:
            continue
        ratio = matcher.ratio()
        if ratio >= _CUTOFF and (best is None or ratio > best[0]):
            best = (ratio, candidate)
    return best[1] if best else None


def is_slip(name: str, other: str) -> bool:
    """Return whether few letters differ: 1, or a quarter of the shorter name.

    A letter differs if it is missing, added or replaced, or if two letters are
    swapped. `nearest` also returns names that share only a long end.
    """
    if max(len(name), len(other)) > MAX_COMPARED:
        return False
    return _wrong_letters(name, other) <= max(1, min(len(name), len(other)) // 4)


def _wrong_letters(name: str, other: str) -> int:
    above: list[int] = []
    row = list(range(len(other) + 1))
    for at, letter in enumerate(name):
        earlier, above, row = above, row, [at + 1]
        for to, wanted in enumerate(other):
            cost = min(above[to] + (letter != wanted), above[to + 1] + 1, row[to] + 1)
            if at and to and (name[at - 1], letter) == (wanted, other[to - 1]):
                cost = min(cost, earlier[to - 1] + 1)
            row.append(cost)
    return row[-1]


_LOOKED_AT = 10
"""The limit of compared names that share a shortened form."""

_TELLS_APART = re.compile(r"[0-9]+|-[a-z]$")
"""The different parts of names in a numbered or lettered series: `?arm1`, `?arm-b`."""


class Close:
    """An index of names that finds a name with one wrong letter.

    The index has each name also without each of its letters; the search does not
    compare each name with each.

    Args:
        names: the known names.
        least: the least length of a name for a slip.
    """

    def __init__(self, names: Iterable[str], least: int) -> None:
        self._least = least
        self._names: dict[str, list[str]] = {}
        for name in names:
            for short in self._shortened(name):
                self._names.setdefault(short, []).append(name)

    def to(self, name: str) -> str | None:
        """Return the first name one slip away that is not of the same series."""
        found = (other for other in self.all_to(name) if not is_row(name, other))
        return next(found, None)

    def all_to(self, name: str) -> Iterator[str]:
        """Yield the names one slip away from `name`, each once."""
        seen = {name}
        for short in self._shortened(name):
            for other in self._names.get(short, [])[:_LOOKED_AT]:
                if other not in seen and _wrong_letters(name, other) == 1:
                    seen.add(other)
                    yield other

    def is_long(self, name: str) -> bool:
        """Return whether the length of a name allows the search for slips."""
        return self._least <= len(name) <= MAX_COMPARED

    def _shortened(self, name: str) -> Iterator[str]:
        """Yield `name`; if it is long enough, also `name` without each letter."""
        yield name
        if self.is_long(name):
            for at in range(len(name)):
                yield name[:at] + name[at + 1 :]


def is_row(one: str, other: str) -> bool:
    """Return whether two names belong to one series: `?arm1` and `?arm2`."""
    return _TELLS_APART.sub("", one) == _TELLS_APART.sub("", other)


def did_you_mean(
    name: str, names: Iterable[str], otherwise: str = "", form: str = "`{}`"
) -> str:
    """Return the help for an unknown name: a question, or else `otherwise`.

    Args:
        name: the unknown name.
        names: the known names.
        otherwise: the result if no known name is similar.
        form: the form of the similar name in the question.
    """
    near = nearest(name, names)
    return f"did you mean {form.format(near)}?" if near else otherwise


def hint(name: str, names: Iterable[str]) -> str:
    """Return a suffix for a message: `; did you mean ...`, or nothing."""
    said = did_you_mean(name, names)
    return f"; {said}" if said else ""


class Suggestions:
    """The similar names for unknown names, with a cache.

    Only the first 50 unknown names are searched: the time stays in proportion to the
    length of a text with many unknown names.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._names = dict.fromkeys(sorted(set(names)))
        self._near: dict[str, str | None] = {}

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def near(self, name: str) -> str | None:
        """Return the known name nearest to `name`, or None."""
        if name not in self._near:
            if len(self._near) >= MAX_SUGGESTIONS:
                return None
            self._near[name] = nearest(name, self._names)
        return self._near[name]

    def did_you_mean(self, name: str, otherwise: str = "") -> str:
        """Return the help for an unknown name: a question, or else `otherwise`."""
        close = self.near(name)
        return f"did you mean `{close}`?" if close else otherwise
