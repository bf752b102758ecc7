"""Names of earlier versions and their replacements, for messages."""

from __future__ import annotations

from collections.abc import Mapping

MODULES: Mapping[str, str] = {
    "rapc.api": "`rapc`",
    "rapc.runtime.events.events": "`rapc.events`",
    "rapc.runtime.submission": "`rapc.TaskRequest`",
    "rapc.runtime.trace": "`rapc.JsonTrace` and `rapc.TextTrace`",
    "rapc.runtime.world": "`rapc.world`",
    "rapc.terms": "`rapc.world`",
    "rapc.version": "`rapc.__version__`",
}
"""Removed modules, each with its replacement."""

NAMES: Mapping[str, str] = {
    "Report": "`rapc.CheckReport`",
    "Submission": "`rapc.TaskRequest`",
    "compile": "`rapc.load(path).program`",
    "extend": "`CheckedLibrary.extend`",
    "task": "`rapc.TaskRequest`, or the task as text",
}
"""Removed names of `rapc`, each with its replacement."""

_FIELDS = ("offer", "handlers", "options", "functions", "solvers", "comparators")
"""Fields of a `Kit` that were methods of a world."""

_UPGRADING = 'see "Upgrading" in CHANGELOG.md'


def module_help(name: str | None) -> str:
    """Return the replacement of a removed module; empty for other modules."""
    if name is None or name not in MODULES:
        return ""
    return f"`{name}` is replaced by {MODULES[name]}; {_UPGRADING}"


def kit_help(world: object) -> str:
    """Return the help for a world that has methods in place of a `Kit`."""
    found = [name for name in _FIELDS if callable(getattr(world, name, None))]
    if not found:
        return ""
    listed = ", ".join(f"`{name}`" for name in found)
    return f"{listed}: fields of `kit = Kit(...)`, no methods; {_UPGRADING}"
