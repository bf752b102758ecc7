"""Which RAPs may come up among their own subtasks: the only ones tested for it.

The test itself, by RAP and inputs, is made while a program runs [T 3.2.5]. What methods
of problem solvers call is not known here.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.ir.walk import steps
from rapc.library.library import Library


class Recursion:
    """The circles among the calls of a library, found as far as they are asked about.

    A RAP is recursive if it is called, directly or through others, by itself: if its
    strongly connected component in the graph of calls has two members or a call of
    its own. The components are found by Tarjan's algorithm (SIAM J. Comput. 1, 1972),
    without recursion. Only RAPs that can be reached from those asked about are read,
    for a library that was compiled decodes a RAP when it is first looked at.
    """

    def __init__(self, library: Library) -> None:
        self._raps = library.raps
        #: Whether a RAP is recursive, for all RAPs in finished components.
        self._known: dict[str, bool] = {}

    def covers(self, name: str) -> bool:
        """Whether the RAP `name` may come up among its own subtasks."""
        found = self._known.get(name)
        if found is None:
            self._search(name)
            found = self._known[name]
        return found

    def _search(self, root: str) -> None:
        """Find the components of all RAPs that can be reached from `root`.

        `order` numbers the RAPs as they are met; `low` is the smallest number that a
        RAP can get back to; `open_` holds the RAPs whose component is not finished;
        `path` those that lead from `root` to where the search is, with the calls that
        are still to be followed; `selves` are the RAPs that call themselves.
        """
        order: dict[str, int] = {}
        low: dict[str, int] = {}
        open_: list[str] = []
        path: list[tuple[str, Iterator[str]]] = []
        selves: set[str] = set()

        def enter(name: str) -> None:
            order[name] = low[name] = len(order)
            open_.append(name)
            path.append((name, iter(self._calls(name))))

        enter(root)
        while path:
            name, calls = path[-1]
            called = next((c for c in calls if c not in self._known), None)
            if called is None:
                path.pop()
                if path:
                    caller = path[-1][0]
                    low[caller] = min(low[caller], low[name])
                if low[name] == order[name]:
                    self._finish(open_, name, name in selves)
            elif called not in order:
                enter(called)
            elif called == name:
                selves.add(name)
            else:
                low[name] = min(low[name], order[called])

    def _finish(self, open_: list[str], first: str, itself: bool) -> None:
        """Take the component that began with `first` off `open_`, and note it.

        `itself` tells whether `first` calls itself.
        """
        members = [open_.pop()]
        while members[-1] != first:
            members.append(open_.pop())
        circle = itself or len(members) > 1
        self._known.update(dict.fromkeys(members, circle))

    def _calls(self, name: str) -> dict[str, None]:
        """The RAPs that the methods of a RAP call, each once, in order."""
        methods = self._raps[name].methods
        goals = (step.goal.name for method in methods for step in steps(method))
        return dict.fromkeys(called for called in goals if called in self._raps)
