"""What a run is begun with, as plain data: one record for all that begin runs.

The command line, a Python program, a test, an experiment and a trace hold one `RunSpec`
each. Python callables, listeners and a world that a host has made are handed in beside
it. How a run is made of a spec is in `rapc.runtime.interpreter`.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

Plain = bool | int | float | str
"""The value of an option or a setting; that of an option of kind `text` is the text."""


class RunSpec(msgspec.Struct, frozen=True, kw_only=True, rename="kebab"):
    """All that decides what a run does, but for Python code beside the world's.

    Values are text where the language has a form for them: tasks, facts and faults.
    """

    #: The library as it was named, and the digest of its texts.
    library: str = ""
    digest: str = ""
    #: The name of the world; `module:Class` besides if it was named so.
    world: str = ""
    world_class: str = ""
    #: Options of the world; those that are missing have their defaults.
    options: Mapping[str, Plain] = {}
    #: Settings of the interpreter, by the names of the command line.
    settings: Mapping[str, Plain] = {}
    seed: int = 0
    #: An agenda of the library, whose tasks come first.
    agenda: str | None = None
    tasks: tuple[str, ...] = ()
    #: Facts in memory besides those of the world.
    facts: tuple[str, ...] = ()
    #: Faults put into the world.
    faults: tuple[str, ...] = ()
    #: The time at which the run is stopped.
    until: int | float | None = None
