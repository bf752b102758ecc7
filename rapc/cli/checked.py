"""A library for the commands that run one: read, checked and compiled."""

from __future__ import annotations

from rapc.cli.common import print_findings
from rapc.cli.options import USAGE, say
from rapc.compiler.program import Program
from rapc.host import CheckError, load


def load_checked(path: str) -> Program:
    """Return a library for a command that runs it, from sources or saved.

    A finding of severity error is printed and ends the command with status 2; others
    do not stop it.
    """
    try:
        library = load(path)
    except CheckError as error:
        print_findings(error.report, "full")
        raise SystemExit(USAGE) from None
    for name in library.files:
        say(f"read {name}")
    return library.program
