"""Tables of settings, limits and versions of formats."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module

from generator.markdown import table
from generator.python import Notes
from rapc.runtime.settings import Settings

LIMITS: Mapping[str, tuple[str, str]] = {
    "bytes of a file of RAP text": ("rapc.base.limits", "MAX_BYTES"),
    "characters of a name": ("rapc.base.limits", "MAX_NAME"),
    "characters of a number": ("rapc.base.limits", "MAX_NUMBER"),
    "levels of lists in a text": ("rapc.base.limits", "MAX_DEPTH"),
    "propositions and tests in a formula": ("rapc.base.limits", "MAX_LEAVES"),
    "findings reported for a file": ("rapc.base.limits", "MAX_FINDINGS"),
    "initial facts of a world": ("rapc.runtime.held_world", "MOST_FACTS"),
    "time of the clock": ("rapc.runtime.held_world", "LATEST"),
    "bytes of a line of a remote world": ("rapc.worlds.remote.protocol", "LINE_LIMIT"),
    "messages in an answer of a remote world": (
        "rapc.worlds.remote.protocol",
        "MOST_MESSAGES",
    ),
    "cycles of a test without `until`": ("rapc.testing.run", "MOST_CYCLES"),
    "time of a test without `until`": ("rapc.testing.run", "LATEST"),
    "seeds of an experiment": ("rapc.experiments.definition", "MOST_SEEDS"),
}
"""The limits that a user can reach, each with the module and name of its value."""


def limits() -> str:
    """Return the table of limits."""
    values = {
        what: getattr(import_module(module), name)
        for what, (module, name) in LIMITS.items()
    }
    rows = [(what, f"{value:,}") for what, value in values.items()]
    return table(("limit", "highest value"), rows)


def formats() -> str:
    """Return the table of the versions of file formats."""
    homes = {
        "compiled library": ("rapc.library.saved", "FORMAT"),
        "saved run": ("rapc.runtime.saving.format", "FORMAT"),
        "trace": ("rapc.runtime.interpreter", "TRACE_FORMAT"),
        "journal": ("rapc.durable.folder", "FORMAT"),
        "bug report": ("rapc.debug.bug", "FORMAT"),
        "protocol of remote worlds": ("rapc.worlds.remote.protocol", "PROTOCOL"),
        "results of experiments": ("rapc.experiments.store", "FORMAT"),
    }
    rows = [
        (what, str(getattr(import_module(module), name)))
        for what, (module, name) in homes.items()
    ]
    return table(("format", "version"), rows)


def settings() -> str:
    """Return the table of the settings of the interpreter."""
    notes = Notes.of(Settings)
    rows = [
        (f"`rapc.{name}`", f"`{str(value).lower()}`", notes[name.replace("-", "_")])
        for name, value in Settings().named().items()
    ]
    return table(("setting", "default", "meaning"), rows)
