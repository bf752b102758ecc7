"""Description of the start of a run as plain data, for all front ends.

The command line, a Python program, a test, an experiment and a trace hold one `RunSpec`
each. Python callables, listeners and a world instance of a host are separate arguments.
`rapc.runtime.interpreter` makes a run from a spec.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

Plain = bool | int | float | str
"""The value of an option or a setting; a `str` for an option of kind `text`."""


class RunSpec(msgspec.Struct, frozen=True, kw_only=True, rename="kebab"):
    """All data that determine a run, except Python code outside the world.

    Values are text if the language has a syntax for them: tasks, facts and faults.
    """

    #: The library as the user named it, and the digest of its texts.
    library: str = ""
    digest: str = ""
    #: The name of the world; also `module:Class`, or the address of a remote world, if
    #: the user named it in this form.
    world: str = ""
    world_class: str = ""
    #: Options of the world; missing options have their defaults.
    options: Mapping[str, Plain] = {}
    #: Settings of the interpreter, by the names of the command line.
    settings: Mapping[str, Plain] = {}
    seed: int = 0
    #: An agenda of the library, whose tasks come first.
    agenda: str | None = None
    tasks: tuple[str, ...] = ()
    #: Initial facts, in addition to the facts of the world.
    facts: tuple[str, ...] = ()
    #: Faults of the world.
    faults: tuple[str, ...] = ()
    #: The time at which the run is stopped.
    until: int | float | None = None
