"""Known names of one kind, with the nearest to a mistyped one."""

from __future__ import annotations

from collections.abc import Iterable

from rapc.base.names import nearest

_MOST = 50
"""How many different names get a suggestion: looking for one costs milliseconds."""


class Names:
    """Names that may be meant; suggestions are remembered, and limited in number."""

    def __init__(self, names: Iterable[str]) -> None:
        self._names = sorted(set(names))
        self._near: dict[str, str | None] = {}

    def near(self, name: str) -> str | None:
        """The known name nearest to another, or None."""
        if name not in self._near:
            if len(self._near) >= _MOST:
                return None
            self._near[name] = nearest(name, self._names)
        return self._near[name]

    def did_you_mean(self, name: str, otherwise: str = "") -> str:
        """The help for an unknown name: a question, or what to say without one."""
        close = self.near(name)
        return f"did you mean `{close}`?" if close else otherwise
