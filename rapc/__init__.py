"""rapc: Reactive Action Packages, checked, run and explained.

What a program needs is here; each name is imported when it is first asked for, so that
the command line starts at once.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from rapc.base.version import VERSION

if TYPE_CHECKING:
    from rapc.analysis.driver import check as check
    from rapc.api import compile_library as compile
    from rapc.api import extend as extend
    from rapc.api import load as load
    from rapc.runtime.events import events
    from rapc.runtime.events.trace import JsonTrace as JsonTrace
    from rapc.runtime.events.trace import TextTrace as TextTrace
    from rapc.runtime.interpreter import Interpreter as Interpreter
    from rapc.runtime.settings import Settings as Settings
    from rapc.runtime.task_request import TaskRequest as TaskRequest
    from rapc.runtime.task_request import read_task_request as task
    from rapc.world import World as World
    from rapc.worlds.registry import open_world as open_world

__version__ = VERSION

__all__ = (
    "Interpreter",
    "JsonTrace",
    "Settings",
    "TaskRequest",
    "TextTrace",
    "World",
    "__version__",
    "check",
    "compile",
    "events",
    "extend",
    "load",
    "open_world",
    "task",
)

_HOMES = {
    "Interpreter": ("rapc.runtime.interpreter", "Interpreter"),
    "JsonTrace": ("rapc.runtime.events.trace", "JsonTrace"),
    "Settings": ("rapc.runtime.settings", "Settings"),
    "TaskRequest": ("rapc.runtime.task_request", "TaskRequest"),
    "TextTrace": ("rapc.runtime.events.trace", "TextTrace"),
    "World": ("rapc.world", "World"),
    "check": ("rapc.analysis.driver", "check"),
    "compile": ("rapc.api", "compile_library"),
    "extend": ("rapc.api", "extend"),
    "load": ("rapc.api", "load"),
    "open_world": ("rapc.worlds.registry", "open_world"),
    "task": ("rapc.runtime.task_request", "read_task_request"),
}


def __getattr__(name: str) -> object:
    if name == "events":
        return import_module("rapc.runtime.events.events")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOMES[name]
    return getattr(import_module(module), attribute)
