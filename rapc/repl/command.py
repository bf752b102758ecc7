"""A command of the debugger: its name, what it takes and says, and examples of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import msgspec

from rapc.repl.answer import Answer
from rapc.repl.arguments import Arguments

if TYPE_CHECKING:
    from rapc.repl.shell import Shell

Does = Callable[["Shell", Arguments], Answer]


class Command(msgspec.Struct, frozen=True):
    """Something that begins with a colon."""

    #: Its name, without the colon.
    name: str
    #: What it is given, as it is written in the help: `[N]`.
    takes: str
    #: What it does, in one sentence.
    doc: str
    does: Does
    examples: tuple[str, ...] = ()
    #: What else there is to know, a paragraph.
    more: str = ""
    #: The group under which `:help` lists it.
    group: str = ""
