"""All commands, in the order of `:help`."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

from msgspec.structs import replace

from rapc.repl.commands.acting import ACTING
from rapc.repl.commands.asking import ASKING
from rapc.repl.commands.exporting import EXPORTING
from rapc.repl.commands.helping import HELPING
from rapc.repl.commands.looking import LOOKING
from rapc.repl.commands.moving import MOVING, TIME
from rapc.repl.commands.remembering import REMEMBERING
from rapc.repl.commands.stopping import SEARCHING, STOPPING
from rapc.repl.shell import Command

_GROUPS: Sequence[tuple[str, Sequence[Command]]] = (
    ("going on", MOVING),
    ("stopping", STOPPING),
    ("time", (*TIME, *SEARCHING)),
    ("looking", LOOKING),
    ("asking", ASKING),
    ("what has been", (*REMEMBERING, *EXPORTING)),
    ("acting", ACTING),
    ("this and that", HELPING),
)


def commands() -> tuple[Command, ...]:
    """Return all commands, each with the group that it belongs to."""
    groups = ([replace(one, group=name) for one in found] for name, found in _GROUPS)
    return tuple(chain.from_iterable(groups))
