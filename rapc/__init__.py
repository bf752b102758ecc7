"""rapc: Reactive Action Packages, checked, run and explained.

What a program needs is here; each name is imported when it is first asked for, so that
the command line starts at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rapc.analysis.driver import check as check
    from rapc.loader import load as load

__version__ = "0.1.0"

__all__ = ("__version__", "check", "load")

_HOMES = {
    "check": "rapc.analysis.driver",
    "load": "rapc.loader",
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
