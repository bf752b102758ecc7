"""Which RAPs may come up among their own subtasks: the only ones tested for it.

The test itself, by RAP and inputs, is made while a program runs (T 3.2.5).
"""

from __future__ import annotations

from collections.abc import Mapping

from rapc.ir.walk import steps
from rapc.library.library import Library


def recursive(library: Library) -> frozenset[str]:
    """The names of all RAPs on a circle of calls, with some that only lie between two.

    What methods of problem solvers call is not known here.
    """
    calls = {
        name: {step.goal.name for method in rap.methods for step in steps(method)}
        for name, rap in library.raps.items()
    }
    callers: dict[str, set[str]] = {name: set() for name in calls}
    for name, called in calls.items():
        for other in called & calls.keys():
            callers[other].add(name)
    return _lasting(calls, callers) & _lasting(callers, calls)


def _lasting(
    ahead: Mapping[str, set[str]], behind: Mapping[str, set[str]]
) -> frozenset[str]:
    """The names from which a way ahead need not end."""
    left = {name: len(others & ahead.keys()) for name, others in ahead.items()}
    ends = [name for name, count in left.items() if count == 0]
    ended = set(ends)
    while ends:
        for name in behind[ends.pop()]:
            left[name] -= 1
            if left[name] == 0:
                ended.add(name)
                ends.append(name)
    return frozenset(left.keys() - ended)
