"""Reactive Action Packages, checked, run and explained.

    library = rapc.load("rocks.rap")
    result = rapc.run(library, "truck", "(fill-order red 4 factory-1)", seed=7)
    print(result.reason, result.succeeded)

`load` and `loads` read a library, `check` returns a report of its findings, `run` runs
tasks of the library, and `CheckedLibrary.start` starts a run for stepping and queries.
`rapc.world` has the base classes of new worlds. Every error that a caller can cause is
a `rapc.Error`. The Python API is described in docs/how-to/embed.md.
"""

# Each name is imported at its first use, so that the command line starts fast.
# Ctrl-C is handled after these imports (`rapc.cli.start`): not even `typing`.

from __future__ import annotations

from importlib import import_module as _import_module

from rapc.base.version import VERSION as _VERSION

TYPE_CHECKING = False  # true for type checkers, by its name

if TYPE_CHECKING:
    from rapc import events as events
    from rapc import live as live
    from rapc import world as world
    from rapc.analysis.driver import CheckReport as CheckReport
    from rapc.errors import ArgumentError as ArgumentError
    from rapc.errors import Error as Error
    from rapc.errors import FactError as FactError
    from rapc.errors import LoadError as LoadError
    from rapc.errors import PlanError as PlanError
    from rapc.errors import PortError as PortError
    from rapc.errors import RefusedError as RefusedError
    from rapc.errors import SavedError as SavedError
    from rapc.errors import SettingError as SettingError
    from rapc.errors import StateError as StateError
    from rapc.errors import TextError as TextError
    from rapc.errors import WorldError as WorldError
    from rapc.host import CheckedLibrary as CheckedLibrary
    from rapc.host import CheckError as CheckError
    from rapc.host import RunResult as RunResult
    from rapc.host import check as check
    from rapc.host import engine as engine
    from rapc.host import load as load
    from rapc.host import loads as loads
    from rapc.host import methods as methods
    from rapc.host import methods_text as methods_text
    from rapc.host import plan as plan
    from rapc.host import rap_text as rap_text
    from rapc.host import run as run
    from rapc.planning.engines import Engine as Engine
    from rapc.planning.plan import Plan as Plan
    from rapc.runtime.events.logs import LogTrace as LogTrace
    from rapc.runtime.events.trace import JsonTrace as JsonTrace
    from rapc.runtime.events.trace import TextTrace as TextTrace
    from rapc.runtime.interpreter import Interpreter as Interpreter
    from rapc.runtime.settings import Settings as Settings
    from rapc.runtime.task_request import TaskRequest as TaskRequest
    from rapc.spec import RunSpec as RunSpec
    from rapc.testing.from_python import TestResult as TestResult
    from rapc.testing.from_python import test as test
    from rapc.world import World as World
    from rapc.worlds.registry import open_world as open_world

__version__ = _VERSION

_NAMES = {
    "rapc.errors": (
        "ArgumentError Error FactError LoadError PlanError PortError "
        "RefusedError SavedError SettingError StateError TextError "
        "WorldError"
    ),
    "rapc.host": (
        "CheckError CheckedLibrary RunResult check engine load loads methods "
        "methods_text plan rap_text run"
    ),
    "rapc.planning.engines": "Engine",
    "rapc.planning.plan": "Plan",
    "rapc.runtime.interpreter": "Interpreter",
    "rapc.runtime.events.logs": "LogTrace",
    "rapc.runtime.events.trace": "JsonTrace TextTrace",
    "rapc.analysis.driver": "CheckReport",
    "rapc.spec": "RunSpec",
    "rapc.runtime.settings": "Settings",
    "rapc.runtime.task_request": "TaskRequest",
    "rapc.world": "World",
    "rapc.worlds.registry": "open_world",
    "rapc.testing.from_python": "test TestResult",
}
"""The public names that are not modules, by the module that defines each."""

_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}

_MODULES = {"events": "rapc.events", "live": "rapc.live", "world": "rapc.world"}

__all__ = ["__version__", *_HOMES, *_MODULES]  # noqa: PLE0604  # all are strings


def __getattr__(name: str) -> object:
    if name in _MODULES:
        return _import_module(_MODULES[name])
    if name not in _HOMES:
        former = _import_module("rapc.base.former").NAMES.get(name)
        now = f"; it is replaced by {former}" if former else ""
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}{now}")
    return getattr(_import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    own = [name for name in globals() if name.startswith("__")]
    return sorted({*own, *__all__})
