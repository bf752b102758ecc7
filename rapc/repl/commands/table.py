"""Table of all commands, in the order of `:help`, by group and module."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import ModuleType

from msgspec.structs import replace

from rapc.debug.answer import Command
from rapc.debug.questions import (
    beliefs,
    commitments,
    differences,
    ends,
    facts,
    idle,
    state,
    tasks,
    times,
    what_if,
    why,
    why_not,
)
from rapc.repl.commands import (
    acting,
    exporting,
    helping,
    moving,
    querying,
    stopping,
    travelling,
)

_GROUPS: Mapping[str, Sequence[ModuleType]] = {
    "moving": (moving,),
    "stopping": (stopping,),
    "time": (travelling, differences),
    "looking": (tasks, querying, state, beliefs),
    "explaining": (why, why_not, commitments, ends),
    "past": (facts, times, idle, exporting),
    "acting": (acting, what_if),
    "session": (helping,),
}


def commands() -> tuple[Command, ...]:
    """Return all commands, each with its group."""
    return tuple(
        replace(one, group=group)
        for group, modules in _GROUPS.items()
        for module in modules
        for one in vars(module).values()
        if isinstance(one, Command) and one.does.__module__ == module.__name__
    )
