"""The earlier name of the module `rapc.world`; an import explains the new name."""

from __future__ import annotations

from rapc.base.former import module_help


def __getattr__(name: str) -> object:
    if name.startswith("__"):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    raise ImportError(module_help(__name__), name=__name__)
