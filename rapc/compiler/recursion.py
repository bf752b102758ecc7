"""Which RAPs may come up among their own subtasks: the only ones tested for it.

The test itself, by RAP and inputs, is made while a program runs [T 3.2.5]. What methods
of problem solvers call is not known here.
"""

from __future__ import annotations

from rapc.base.graph import components
from rapc.ir.walk import steps
from rapc.library.library import Library


class Recursion:
    """The recursive RAPs of a library, found as far as they are asked about.

    A RAP is recursive if it is called, directly or through others, by itself. Only RAPs
    that can be reached from those asked about are read, for a library that was compiled
    decodes a RAP when it is first looked at.
    """

    def __init__(self, library: Library) -> None:
        self._raps = library.raps
        self._known: dict[str, bool] = {}

    def covers(self, name: str) -> bool:
        """Return whether the RAP `name` may come up among its own subtasks."""
        if name not in self._known:
            for members in components([name], self._calls, self._known):
                is_circle = len(members) > 1 or members[0] in self._calls(members[0])
                self._known.update(dict.fromkeys(members, is_circle))
        return self._known[name]

    def _calls(self, name: str) -> dict[str, None]:
        """Return the RAPs that the methods of a RAP call, each once, in order."""
        methods = self._raps[name].methods
        goals = (step.goal.name for method in methods for step in steps(method))
        return dict.fromkeys(called for called in goals if called in self._raps)
