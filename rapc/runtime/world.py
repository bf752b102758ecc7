"""The module that `rapc.world` was in earlier versions: who imports from it is told."""

from __future__ import annotations

from rapc.base.former import module_help


def __getattr__(name: str) -> object:
    if name.startswith("__"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    raise ImportError(module_help(__name__), name=__name__)
