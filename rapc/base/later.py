"""Modules that are imported when something of them is first wanted.

What few runs need is not to be paid for by every start. Imports still stand at the head
of a file, where readers, mypy and import-linter see them:

    if TYPE_CHECKING:
        from rapc.library import saved
    else:
        saved = later("rapc.library.saved")

Not in modules that are compiled (pyproject.toml): the compiler drops the second half.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # to type checkers it is true; `rapc.cli.start` has no time

if TYPE_CHECKING:
    from typing import Any


def later(name: str) -> Any:
    """Return what stands for the module `name`, which is not imported yet."""
    return _Later(name)


class _Later:
    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, attribute: str) -> Any:
        return getattr(import_module(self._name), attribute)
