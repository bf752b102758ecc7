"""The nearest name, for "did you mean"."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher

_CUTOFF = 0.72


def counted(number: int, word: str) -> str:
    """A number with what is counted, in the plural unless it is one: `2 inputs`."""
    return f"{number} {word}{'' if number == 1 else 's'}"


def nearest(name: str, names: Iterable[str]) -> str | None:
    """The known name that looks most like a mistyped one, or None.

    Ties go to the name that sorts first, so the answer does not depend on the
    order in which names are given.
    """
    best: tuple[float, str] | None = None
    matcher = SequenceMatcher(b=name, autojunk=False)
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
