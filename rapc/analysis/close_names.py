"""Names one slip of the pen apart, found without comparing each with each."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

_MOST = 60
"""How long a name may be; nobody compares longer ones by eye."""

_LOOKED_AT = 10
"""Of names that all are one letter from each other only so many are looked at."""

_TELLS_APART = re.compile(r"[0-9]+|-[a-z]$")
"""What tells names apart that come in rows: `?arm1`, `?arm-b`."""


class Close:
    """Finds names one slip away, by what is left of names that lose a letter.

    Args:
        names: the names that may be meant.
        least: how long a name must be for a slip to show.
    """

    def __init__(self, names: Iterable[str], least: int) -> None:
        self._least = least
        self._names: dict[str, list[str]] = {}
        for name in names:
            for short in self._shortened(name):
                self._names.setdefault(short, []).append(name)

    def to(self, name: str) -> str | None:
        """Return the first name close to another that is not of a row with it."""
        found = (other for other in self.all_to(name) if not is_row(name, other))
        return next(found, None)

    def all_to(self, name: str) -> Iterator[str]:
        """Yield the names one slip away from another, each once."""
        seen = {name}
        for short in self._shortened(name):
            for other in self._names.get(short, [])[:_LOOKED_AT]:
                if other not in seen and is_one_slip(name, other):
                    seen.add(other)
                    yield other

    def is_long(self, name: str) -> bool:
        """Whether a name is long enough for a slip to show, and not absurdly long."""
        return self._least <= len(name) <= _MOST

    def _shortened(self, name: str) -> Iterator[str]:
        """Yield `name`; if it is long enough, also `name` without each letter."""
        yield name
        if self.is_long(name):
            for at in range(len(name)):
                yield name[:at] + name[at + 1 :]


def is_row(one: str, other: str) -> bool:
    """Whether two names differ by what numbers or letters the names of a row."""
    return _TELLS_APART.sub("", one) == _TELLS_APART.sub("", other)


def is_one_slip(one: str, other: str) -> bool:
    """Whether one letter left out, put in, changed or swapped makes them equal."""
    start = 0
    while start < min(len(one), len(other)) and one[start] == other[start]:
        start += 1
    left, right = one[start:], other[start:]
    if len(left) == len(right):
        swapped = left[1::-1] == right[:2] and left[2:] == right[2:]
        return left[1:] == right[1:] or swapped
    longer, shorter = (left, right) if len(left) > len(right) else (right, left)
    return longer[1:] == shorter
